"""The window system through glfw: its start, its screens, and a connection that may break."""

from __future__ import annotations

import contextlib
import ctypes
import importlib.util
import os
import platform
from collections.abc import Mapping
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from ...errors import MachineError

if TYPE_CHECKING:
    import ctypes

    import glfw

    WindowHandle = ctypes._Pointer[glfw._GLFWwindow]
    ScreenHandle = ctypes._Pointer[glfw._GLFWmonitor]
    VideoMode = glfw._GLFWvidmode.GLFWvidmode
else:  # glfw loads in start()
    WindowHandle = ScreenHandle = VideoMode = object


REMEDY = (
    "run in a desktop session, or under a virtual screen (Debian, Ubuntu: sudo apt-get install xvfb, then put "
    "'xvfb-run -a' before the "
    "command); 'hmdwarp doctor' shows what is there"
)


def variant(environ: Mapping[str, str]) -> str:
    """Return which of glfw's two libraries fits, "x11" or "wayland".

    "" leaves it to glfw, which goes by XDG_SESSION_TYPE alone. A session of one kind may offer only
    the other kind of display, as under ssh -X, Xvfb and in containers.
    """
    wayland, x11 = environ.get("WAYLAND_DISPLAY"), environ.get("DISPLAY")
    if "PYGLFW_LIBRARY_VARIANT" in environ or bool(wayland) == bool(x11):
        return ""
    return "wayland" if wayland else "x11"


def choose_library() -> None:
    """Choose the library that fits, before glfw is imported."""
    fitting = variant(os.environ)
    if fitting:
        os.environ["PYGLFW_LIBRARY_VARIANT"] = fitting
    if (fitting or os.environ.get("PYGLFW_LIBRARY_VARIANT") or os.environ.get("XDG_SESSION_TYPE")) == "wayland":
        _load_the_glfw_of_imgui()


def _load_the_glfw_of_imgui() -> None:
    """Load the glfw library of Dear ImGui's package, which has the same name and needs X11.

    Under Wayland that package would find the library of the glfw package, which lacks X11, and fail
    to load. It finds its own if that was loaded first.
    """
    spec = importlib.util.find_spec("imgui_bundle")
    if spec is not None and spec.origin is not None:
        with contextlib.suppress(OSError):
            ctypes.CDLL(str(Path(spec.origin).with_name("libglfw.so.3")))


def start() -> ModuleType:
    """Return the running glfw. Errors: MachineError with the reason."""
    if platform.system() == "Linux":
        if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
            raise MachineError(f"no window: neither DISPLAY nor WAYLAND_DISPLAY is set; {REMEDY}")
        choose_library()
    try:
        import glfw
    except Exception as error:  # its loader may raise anything where a library is missing
        raise MachineError(f"no window: glfw cannot be loaded ({error}); pip install glfw") from error
    glfw.ERROR_REPORTING = "log"  # else every refusal (a window position under Wayland) is a warning on stderr
    if not glfw.init():
        raise MachineError(f"no window: {last_error(glfw)}; {REMEDY}")
    return glfw


def last_error(glfw: ModuleType) -> str:
    """Return glfw's reason for refusing the last call."""
    code, message = glfw.get_error()
    words = message.decode(errors="replace") if isinstance(message, bytes) else str(message or "no reason given")
    return f"{' '.join(words.split())}" if code else "no reason given"


UNKNOWN = "none"


def screen_of(glfw: ModuleType, handle: WindowHandle) -> ScreenHandle | None:
    """Return the screen that a window fills, or that most of it lies on; None without any."""
    filled: ScreenHandle | None = glfw.get_window_monitor(handle)
    if filled:
        return filled
    x, y = glfw.get_window_pos(handle)  # (0, 0) under Wayland, which does not report it
    w, h = glfw.get_window_size(handle)
    screens: list[ScreenHandle] = glfw.get_monitors() or []
    return max(screens, key=lambda screen: _shared(glfw, screen, (x, y, w, h)), default=None)


def _shared(glfw: ModuleType, screen: ScreenHandle, rectangle: tuple[int, int, int, int]) -> int:
    """Return the area of the rectangle on the screen."""
    mode = glfw.get_video_mode(screen)
    if mode is None:
        return 0
    x, y, w, h = rectangle
    left, top = glfw.get_monitor_pos(screen)
    across = min(x + w, left + mode.size.width) - max(x, left)
    down = min(y + h, top + mode.size.height) - max(y, top)
    return int(max(0, across) * max(0, down))


def mode_of(glfw: ModuleType, screen: ScreenHandle | None) -> VideoMode | None:
    """Return size and refresh_rate of a screen; None without one."""
    return glfw.get_video_mode(screen) if screen else None


def screen_text(glfw: ModuleType, screen: ScreenHandle | None) -> str:
    """Return the screen's name, size and rate."""
    mode = mode_of(glfw, screen)
    if mode is None:
        return UNKNOWN
    name = glfw.get_monitor_name(screen)
    name = name.decode(errors="replace") if isinstance(name, bytes) else str(name)
    rate = f" at {mode.refresh_rate} Hz" if mode.refresh_rate > 0 else ""
    return f"{name}, {mode.size.width}x{mode.size.height}{rate}"


_ErrorHandler = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p)
_ExitHandler = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)


class XConnection:
    """A connection that may break (logged out, ssh ended, server crashed).

    Xlib 1.7 or later (2020) lets a program survive that; an older one exits with status 1. Under
    Wayland the window closes instead.
    """

    def __init__(self, glfw: ModuleType) -> None:
        # Whether the server is gone. Then no part of the window may be used, not even to free it.
        self.broken = False
        # Kept referenced here: Xlib stores only the pointers.
        self._handlers = _ErrorHandler(lambda _: 0), _ExitHandler(self._note)
        if glfw.get_platform() == glfw.PLATFORM_X11:
            self._listen(ctypes.cast(glfw.get_x11_display(), ctypes.c_void_p))

    def _listen(self, display: ctypes.c_void_p) -> None:
        try:
            xlib = ctypes.CDLL("libX11.so.6")  # the one that glfw has loaded
            set_exit_handler = xlib.XSetIOErrorExitHandler
        except (OSError, AttributeError):
            return
        # The default error handler exits before the exit handler is called: both must be replaced.
        xlib.XSetIOErrorHandler.argtypes, xlib.XSetIOErrorHandler.restype = (_ErrorHandler,), ctypes.c_void_p
        xlib.XSetIOErrorHandler(self._handlers[0])
        set_exit_handler.argtypes = (ctypes.c_void_p, _ExitHandler, ctypes.c_void_p)
        set_exit_handler.restype = None
        set_exit_handler(display, self._handlers[1], None)

    def _note(self, *_: object) -> None:
        self.broken = True
