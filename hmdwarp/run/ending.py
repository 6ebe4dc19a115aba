"""The end of a live run, by a signal or a limit; and the wait for a lost display."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any

from ..display import Lost

RETRY_S = 0.5


class Ending:
    """End a live run, by a signal or after some seconds or pictures.

    Use as a context manager.

    Inside, Ctrl-C, SIGTERM and SIGHUP only request the end of the run after the current refresh; a
    second one interrupts at once. Ctrl-C is the usual way to end a live run. The other signals are
    raised again on exit, after everything inside has been written, so that they end the program.
    """

    def __init__(self, seconds: float | None, frames: int | None) -> None:
        """Set the limits.

        seconds, frames: how much to show; None for no limit. Time counts from the first refresh.
        """
        self._seconds, self._frames = seconds, frames
        self._began_ns: int | None = None
        # The clock; replaced by the display's once there is one.
        self.now_ns: Callable[[], int] = time.monotonic_ns
        # Number of the first signal received, or None.
        self.asked: int | None = None
        self._before: dict[int, Any] = {}

    def due(self, count: int) -> bool:
        """Return whether to end now, after `count` refreshes with a picture."""
        now_ns = self.now_ns()
        if self._began_ns is None and count:
            self._began_ns = now_ns
        late = (
            self._seconds is not None and self._began_ns is not None and now_ns - self._began_ns >= self._seconds * 1e9
        )
        return self.asked is not None or late or (self._frames is not None and count >= self._frames)

    def _ask(self, number: int, _: FrameType | None) -> None:
        if self.asked is not None:
            raise KeyboardInterrupt
        self.asked = number

    def __enter__(self) -> Ending:
        if threading.current_thread() is threading.main_thread():
            for name in ("SIGINT", "SIGTERM", "SIGHUP"):
                number = getattr(signal, name, None)
                # nohup ignores SIGHUP; keep it ignored.
                if number is not None and signal.getsignal(number) != signal.SIG_IGN:
                    self._before[number] = signal.signal(number, self._ask)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)
        self._before.clear()
        if self.asked is not None and self.asked != signal.SIGINT:
            signal.raise_signal(self.asked)


def come_back(
    reopen: Callable[[], bool], lost: Lost, wait_s: float, ending: Ending, say: Callable[[str], None]
) -> bool:
    """Retry opening a lost display until it succeeds.

    Return False if a signal requests the end first.

    Errors: Lost, when it takes too long.
    """
    say(f"{lost}; waiting up to {wait_s:g} s for it to come back (Ctrl-C ends)")
    until = time.monotonic() + wait_s
    while time.monotonic() < until:
        if ending.asked is not None:
            return False
        if reopen():
            say("it is back")
            return True
        time.sleep(RETRY_S)
    raise Lost(f"{lost}; it has not come back within {wait_s:g} s")
