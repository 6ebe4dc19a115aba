"""When a live run is over: a signal, or as much as was asked for."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable
from types import FrameType


class Ending:
    """While it is entered, Ctrl-C, SIGTERM and SIGHUP only ask the run to end after the refresh under way; a second one of them interrupts
    at once, for whoever will not wait. Ctrl-C is the usual way to end a live run; the others are raised once more when it is left, after
    everything inside has been written, so that the program ends by them.

    asked: the number of the signal that came, None before. The clock runs from the first refresh on; now_ns: which one, the display's
    once there is a display.
    """

    def __init__(self, seconds: float | None, frames: int | None) -> None:
        self._seconds, self._frames = seconds, frames
        self._began_ns: int | None = None
        self.now_ns: Callable[[], int] = time.monotonic_ns
        self.asked: int | None = None
        self._before: dict[int, object] = {}

    def due(self, count: int) -> bool:
        """Whether to end now, after `count` refreshes with a picture."""
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
                if (
                    number is not None and signal.getsignal(number) != signal.SIG_IGN
                ):  # nohup ignores SIGHUP, and is obeyed
                    self._before[number] = signal.signal(number, self._ask)
        return self

    def __exit__(self, *_: object) -> None:
        for number, handler in self._before.items():
            signal.signal(number, handler)  # type: ignore[arg-type]
        self._before.clear()
        if self.asked not in (None, signal.SIGINT):
            signal.raise_signal(self.asked)
