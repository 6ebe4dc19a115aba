"""A window with an OpenGL 4.3 core context: creation, size, full screen, swaps.

It does not depend on the pictures shown in it.
"""

from __future__ import annotations

import ctypes
from types import ModuleType
from typing import Any

import moderngl

from ...base import MachineError
from ...gpu import WANTED
from .. import Closed
from .window_system import ScreenHandle, Size, VideoMode, WindowHandle, last_error, window_size

_UNKNOWN_HZ = 60.0
_FALLBACK_ROOM = (1280, 800)  # free area where no screen reports its size


class _WindowContext:
    """A window's context for moderngl, by glfw's loader, which belongs to the window."""

    def __init__(self, glfw: ModuleType, handle: WindowHandle) -> None:
        self._glfw, self._handle = glfw, handle

    def load_opengl_function(self, name: str) -> int:
        return ctypes.cast(self._glfw.get_proc_address(name), ctypes.c_void_p).value or 0

    def __enter__(self) -> _WindowContext:
        self._glfw.make_context_current(self._handle)
        return self

    def __exit__(self, *_: object) -> None:
        self._glfw.make_context_current(None)

    def release(self) -> None:
        """Do nothing: the context goes with its window."""


class Window:
    """A window for pictures of (w, h) `wanted` pixels, with a column next to them.

    column: its width in pixels at a content scale of 1.
    Errors: MachineError with the reason why there is no window, or no OpenGL 4.3 in it.
    """

    def __init__(
        self, glfw: ModuleType, title: str, wanted: Size, column: int = 0, *, full_screen: bool = False,
        vsync: bool = True,
    ) -> None:  # fmt: skip
        self._glfw, self._title = glfw, title
        self.handle = hidden_window(glfw, title, _units(glfw, wanted, column))
        self._closed = False
        self._place: tuple[int, int, int, int] | None = None  # its place before it filled the screen
        if full_screen:
            self.fill_screen(True)
        # Callbacks instead of a query at every picture: a round trip to the X server takes 50 us.
        self._minimised = False
        glfw.set_framebuffer_size_callback(self.handle, lambda _, *size: setattr(self, "framebuffer_size", size))
        glfw.set_window_iconify_callback(self.handle, lambda _, on: setattr(self, "_minimised", bool(on)))
        glfw.show_window(self.handle)
        # (w, h) in pixels; (0, 0) while it is minimised, on some systems
        self.framebuffer_size: Size = tuple(glfw.get_framebuffer_size(self.handle))
        glfw.focus_window(self.handle)
        # moderngl's annotation omits context objects, its manual does not
        context: Any = _WindowContext(glfw, self.handle)
        context.__enter__()  # current from now on
        self.vsync = vsync  # whether swaps wait for the screen
        glfw.swap_interval(1 if vsync else 0)
        try:
            self.gl = moderngl.create_context(require=WANTED, context=context)
        except Exception as error:  # moderngl raises bare Exception and ValueError
            self.close()
            raise MachineError(
                f"no OpenGL {WANTED / 100:.1f} in a window: {error}; 'hmdwarp doctor' shows what is there"
            ) from error
        self.gl.gc_mode = "context_gc"

    @property
    def hidden(self) -> bool:
        """Whether pictures are invisible: minimised, or without a single pixel."""
        return self._minimised or min(self.framebuffer_size) < 1

    @property
    def rate_hz(self) -> float:
        """Refresh rate of its screen; 60 where unknown (virtual screens)."""
        _, mode = self._screen()
        return float(mode.refresh_rate) if mode is not None and mode.refresh_rate > 0 else _UNKNOWN_HZ

    def _screen(self) -> tuple[ScreenHandle | None, VideoMode | None]:
        """Return the screen that it fills, or that most of it lies on, and its size and rate."""
        glfw = self._glfw

        def shared(screen: ScreenHandle) -> int:
            """Return the area of the window on the screen."""
            if (mode := glfw.get_video_mode(screen)) is None:
                return 0
            x, y = glfw.get_window_pos(self.handle)  # (0, 0) under Wayland, which does not report it
            w, h = glfw.get_window_size(self.handle)
            left, top = glfw.get_monitor_pos(screen)
            across = min(x + w, left + mode.size.width) - max(x, left)
            down = min(y + h, top + mode.size.height) - max(y, top)
            return int(max(0, across) * max(0, down))

        found = glfw.get_window_monitor(self.handle) or max(glfw.get_monitors() or [], key=shared, default=None)
        return found, glfw.get_video_mode(found) if found else None

    def pixel_of(self, x: float, y: float) -> tuple[float, float]:
        """Return framebuffer pixels, from the bottom left, of a position that glfw reports.

        x, y: from the top left, in the window's own units, which on some desktops are not pixels.
        """
        (w, h), (fw, fh) = self._glfw.get_window_size(self.handle), self.framebuffer_size
        return x * fw / max(w, 1), fh - y * fh / max(h, 1)

    def poll_events(self) -> None:
        self._glfw.poll_events()

    def check_open(self) -> None:
        """Errors: Closed, once the user has closed it."""
        if self._glfw.window_should_close(self.handle):
            raise Closed("the window was closed")

    def wait_events(self, seconds: float) -> None:
        self._glfw.wait_events_timeout(seconds)

    @property
    def fills_screen(self) -> bool:
        return bool(self._glfw.get_window_monitor(self.handle))

    def fill_screen(self, on: bool) -> None:
        """Fill its screen, if there is any, or return to its earlier place."""
        glfw, (screen, mode) = self._glfw, self._screen()
        if on and not self.fills_screen and mode is not None:
            self._place = (*glfw.get_window_pos(self.handle), *glfw.get_window_size(self.handle))
            glfw.set_window_monitor(self.handle, screen, 0, 0, mode.size.width, mode.size.height, mode.refresh_rate)
        elif not on and self.fills_screen:
            glfw.set_window_monitor(self.handle, None, *(self._place or (0, 0, *_FALLBACK_ROOM)), 0)

    def title(self, text: str) -> None:
        if text != self._title:
            self._title = text
            self._glfw.set_window_title(self.handle, text)

    def swap(self) -> None:
        """Swap the buffers.

        Returns when the screen has the picture, so that no second one ages in the driver's queue.
        """
        self.send()
        self.gl.finish()

    def send(self) -> None:
        """Swap the buffers without waiting for the screen."""
        self._glfw.swap_buffers(self.handle)

    def end(self) -> None:
        """Request that it is closed at the next opportunity."""
        self._glfw.set_window_should_close(self.handle, True)

    def close(self) -> None:
        """Destroy it, and end glfw. Safe to call twice."""
        if not self._closed:
            self._glfw.destroy_window(self.handle)
            self._glfw.terminate()
        self._closed = True


def _units(glfw: ModuleType, wanted: Size, column: int) -> Size:
    """Return (w, h) of a window for `wanted` pixels and a column, in units of any size (HiDPI)."""
    screen = glfw.get_primary_monitor()
    room = glfw.get_monitor_workarea(screen)[2:] if screen else _FALLBACK_ROOM
    content = (glfw.get_monitor_content_scale(screen)[0] if screen else 0.0) or 1.0
    # The free area is in pixels everywhere; a unit is a pixel under X11, and `content` of them
    # under Wayland.
    unit = content if glfw.get_platform() == glfw.PLATFORM_WAYLAND else 1.0
    width, height = window_size(wanted, tuple(room), round(column * content))
    return max(1, round(width / unit)), max(1, round(height / unit))


def hidden_window(glfw: ModuleType, title: str, size: Size) -> WindowHandle:
    """Return a new window that is not shown. Errors: as Window."""
    glfw.default_window_hints()
    for hint, value in {
        glfw.VISIBLE: glfw.FALSE,
        glfw.CONTEXT_VERSION_MAJOR: WANTED // 100,
        glfw.CONTEXT_VERSION_MINOR: WANTED // 10 % 10,
        glfw.OPENGL_PROFILE: glfw.OPENGL_CORE_PROFILE,
        # Report resets of the GPU; drivers without this ignore it.
        glfw.CONTEXT_ROBUSTNESS: glfw.LOSE_CONTEXT_ON_RESET,
        glfw.DEPTH_BITS: 0,
        glfw.STENCIL_BITS: 0,
        glfw.SCALE_FRAMEBUFFER: glfw.TRUE,
    }.items():
        glfw.window_hint(hint, value)
    handle: WindowHandle = glfw.create_window(*size, title, None, None)
    if not handle:
        failure = last_error(glfw)
        glfw.terminate()
        raise MachineError(
            f"no window with OpenGL {WANTED / 100:.1f} ({failure}); 'hmdwarp doctor' shows what is there"
        )
    return handle
