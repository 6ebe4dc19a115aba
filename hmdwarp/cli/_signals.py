"""SIGTERM and SIGHUP as exceptions: everything on the way out cleans up as after Ctrl-C."""

from __future__ import annotations

import os
import signal
import sys
import threading

INTERRUPTED = 130  # the shells' status for Ctrl-C: 128 + SIGINT
_AGAIN_S = 0.05  # after which a callback that swallowed the exception has returned


class Ended(BaseException):
    """A signal that ends the program; args: its number."""


def end_cleanly() -> None:
    """From now on SIGTERM and SIGHUP raise Ended, the first time that anybody hears of it.

    Later ones are ignored, for cleaning up is under way. Python drops what is raised inside a
    destructor or a callback of C code, Ctrl-C's exception too; then the signal comes again, after a
    moment.
    """

    def end(number: int, _: object) -> None:
        signal.signal(number, signal.SIG_IGN)
        raise Ended(number)

    def dropped(about: sys.UnraisableHookArgs) -> None:
        if Ended is None:  # Python is ending: it has cleared this module
            return
        if isinstance(about.exc_value, Ended):
            (number,) = about.exc_value.args
            signal.signal(number, end)
        elif isinstance(about.exc_value, KeyboardInterrupt):
            number = signal.SIGINT
        else:
            usual(about)
            return
        again = threading.Timer(_AGAIN_S, os.kill, (os.getpid(), number))
        again.daemon = True
        again.start()

    usual, sys.unraisablehook = sys.unraisablehook, dropped

    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        # Nohup ignores SIGHUP, and is obeyed.
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, end)
