"""A window on the desktop beside the headset: it shows what the left eye sees, and its keys are the controls."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING

# GLX is X11's; glfw's library for that must be chosen before anything imports glfw.
os.environ.setdefault("PYGLFW_LIBRARY_VARIANT", "x11")

from .. import Closed, Command  # noqa: E402
from ..desktop.keys import command_of  # noqa: E402
from ..desktop.layout import viewports  # noqa: E402
from ..desktop.opening import start  # noqa: E402
from ..desktop.window import Window  # noqa: E402

if TYPE_CHECKING:
    from ...gpu.textures import Canvas
    from ..present import Presenter

SIZE = (480, 480)
PERIOD_NS = 30_000_000  # the headset has the machine; the window is content with every second or third picture
QUIT = "quit"


class Mirror:
    """gl: its context, which the headset's pictures are drawn with. Errors: MachineError where there is no window."""

    def __init__(self) -> None:
        self._glfw = start()
        try:
            self._window = Window(self._glfw, "hmdwarp", SIZE, vsync=False)
        except BaseException:
            self._glfw.terminate()
            raise
        self.gl = self._window.gl
        self._screen = self.gl.detect_framebuffer(0)
        self._commands: list[Command] = []
        self._drawn_ns = 0
        self._closed = False
        self._glfw.set_key_callback(self._window.handle, self._key)

    def _key(self, _: object, key: int, __: int, action: int, mods: int) -> None:
        command = command_of(key, action, mods)
        if command is not None:
            self._commands.append(command)

    def poll(self) -> None:
        """Hear the window. Errors: Closed."""
        self._glfw.poll_events()
        if self._glfw.window_should_close(self._window.handle) or any(one.control == QUIT for one in self._commands):
            raise Closed("the window was closed")

    def commands(self) -> Sequence[Command]:
        """What its keys asked for since the last time."""
        asked, self._commands = self._commands, []
        return asked

    def title(self, text: str) -> None:
        """Over the window."""
        self._window.title(text)

    def show(self, presenter: Presenter, panel: Canvas | None) -> None:
        """The left eye's picture, as large as it fits; not at every refresh."""
        now_ns = time.monotonic_ns()
        if panel is None or now_ns - self._drawn_ns < PERIOD_NS or self._window.hidden:
            return
        self._drawn_ns = now_ns
        size = self._window.framebuffer_size
        (viewport,) = viewports(size, 1, panel.size[0] / panel.size[1])
        self._screen.viewport = (0, 0, *size)
        self._screen.use()
        self._screen.clear()
        presenter.show(panel, self._screen, viewport, hardware_srgb=False)
        self._glfw.swap_buffers(self._window.handle)

    def close(self) -> None:
        """May be called twice."""
        if not self._closed:
            self._closed = True
            self._window.close()
            self._glfw.terminate()
