"""The connection to the X server; detects a break that would make Xlib exit the program."""

from __future__ import annotations

import ctypes
from types import ModuleType

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
