"""The connection to an X server: notices when it breaks, where Xlib would end the program at once."""

from __future__ import annotations

import ctypes
from types import ModuleType

_ErrorHandler = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p)
_ExitHandler = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p)


class Connection:
    """A connection. broken: whether the server is gone (logged out, ssh ended, crashed).

    Then nothing of the window may be touched, not even to free it. Xlib 1.7 or later (2020) lets a
    program survive that; an older one exits with status 1 as it always did, and Wayland tells glfw
    by closing the window.
    """

    def __init__(self, glfw: ModuleType) -> None:
        self.broken = False
        # Kept here: Xlib holds the pointers alone.
        self._handlers = _ErrorHandler(lambda _: 0), _ExitHandler(self._note)
        if glfw.get_platform() == glfw.PLATFORM_X11:
            self._listen(ctypes.cast(glfw.get_x11_display(), ctypes.c_void_p))

    def _listen(self, display: ctypes.c_void_p) -> None:
        try:
            xlib = ctypes.CDLL("libX11.so.6")  # the one that glfw has loaded
            ask = xlib.XSetIOErrorExitHandler
        except (OSError, AttributeError):
            return
        # The usual error handler exits before the exit handler is asked, so both must be ours.
        xlib.XSetIOErrorHandler.argtypes, xlib.XSetIOErrorHandler.restype = (_ErrorHandler,), ctypes.c_void_p
        xlib.XSetIOErrorHandler(self._handlers[0])
        ask.argtypes, ask.restype = (ctypes.c_void_p, _ExitHandler, ctypes.c_void_p), None
        ask(display, self._handlers[1], None)

    def _note(self, *_: object) -> None:
        self.broken = True
