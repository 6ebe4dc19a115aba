"""A desktop window that mirrors the left eye of the headset and reads the keys."""

from __future__ import annotations

import time
from collections.abc import Sequence

from ...gpu import Canvas
from .. import Command, Label, Status
from ..controls import CONTROLS, Control, help_closes
from ..desktop.window import Window
from ..desktop.window_input import Keys, token
from ..desktop.window_system import start, viewports
from ..present import Presenter

SIZE = (480, 480)
TITLE_NS = 250_000_000
PERIOD_NS = 30_000_000  # the headset has priority; every second or third picture is enough for the window
# Its keys can quit. A runtime recentres the head and corrects the lens itself, and has only one
# view.
_QUIT = "quit"
ELSEWHERE = ("recentre", "panel", "lens", "view")


class Mirror:
    """The mirror window, whose context draws the headset's pictures. Errors: MachineError."""

    def __init__(self, controls: tuple[Control, ...] = CONTROLS) -> None:
        self._keys = Keys(tuple(control for control in controls if control.name not in ELSEWHERE))
        glfw = start()
        self._window = Window(glfw, "hmdwarp", SIZE, vsync=False)
        self.gl = self._window.gl
        self._screen = self.gl.detect_framebuffer(0)
        self._commands: list[Command] = []
        self._drawn_ns = self._titled_ns = 0
        self._help = False
        glfw.set_key_callback(self._window.handle, self._key)

    def _key(self, _: object, key: int, __: int, action: int, mods: int) -> None:
        command = self._keys.command_of(key, action, mods)
        if command is None:
            return
        if self._help and key == token("Escape"):
            self._help = False
        elif command.control == "help":
            self._help = not self._help
        elif command.control == "full_screen":
            self._window.fill_screen(not self._window.fills_screen)
        elif command.control == _QUIT:
            self._window.end()
        else:
            self._commands.append(command)

    def poll(self) -> None:
        self._window.poll_events()
        self._window.check_open()

    def commands(self) -> Sequence[Command]:
        commands, self._commands = self._commands, []
        return commands

    def show_status(self, status: Status) -> None:
        self._keys.status, now_ns = status, time.monotonic_ns()
        if now_ns - self._titled_ns >= TITLE_NS:
            self._titled_ns = now_ns
            self._window.title(status.title())

    def show(self, presenter: Presenter, panel: Canvas | None, label: Label) -> None:
        """Show the left eye's picture as large as fits, with label or help.

        Skips some refreshes.
        """
        now_ns = time.monotonic_ns()
        if now_ns - self._drawn_ns < PERIOD_NS or self._window.hidden:
            return
        self._drawn_ns = now_ns
        size = self._window.framebuffer_size
        self._screen.viewport = place = (0, 0, *size)
        self._screen.use()
        self._screen.clear()
        self._help = self._help and not help_closes(self._keys.controls, has_text_panel=not isinstance(label, str))
        text = presenter.notice(self._keys.help_text(moves=False) if self._help else label)
        (into,) = viewports(size, 1, panel.size[0] / panel.size[1]) if panel else (place,)
        presenter.show(panel, self._screen, into, hardware_srgb=False, notice=text)
        self._window.send()

    def close(self) -> None:
        self._window.close()
