"""SIGTERM and SIGHUP as exceptions: everything on the way out cleans up as after Ctrl-C."""

from __future__ import annotations

import signal

_came: list[int] = []


class Ended(BaseException):
    """A signal that ends the program; args: its number."""


def end_cleanly() -> None:
    """From now on SIGTERM and SIGHUP raise Ended, the first time.

    Later ones are ignored, for cleaning up is under way.
    """

    def end(number: int, _: object) -> None:
        signal.signal(number, signal.SIG_IGN)
        _came.append(number)
        raise Ended(number)

    for name in ("SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        # Nohup ignores SIGHUP, and is obeyed.
        if number is not None and signal.getsignal(number) == signal.SIG_DFL:
            signal.signal(number, end)


def end_if_asked(*_: object) -> None:
    """Raise Ended again, once, if a signal came and its exception was lost; call after every step.

    Python drops what is raised inside a destructor or a callback of the garbage collector, and the
    signal with it.
    """
    if _came:
        raise Ended(_came.pop())
