"""The end of a live run, by a signal, a limit or a hung runtime; Python's garbage collector."""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from types import FrameType, TracebackType
from typing import Any

from ..display import Lost
from ..errors import MachineError

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


LOOKS = 20  # polls of a call within the limit
LONGEST_LOOK_S = 0.25
# For each: a report takes a second or two, and a hung disk must not keep the program alive.
LAST_WORDS_S = 10.0
PRINTING_S = 1.0


class Watchdog:
    """Watch calls from a thread of its own while it is entered.

    limit_s: how long one call may take. last_words: each is called before the program ends, from
    another thread than the hung one, and may fail or hang itself; it returns a sentence for the
    user ("the recording is in walk.csv"), or "".

    The watchdog counts polls that find the call still running, not elapsed time: a program that was
    stopped for a while (Ctrl-Z, a debugger) continues undisturbed.
    """

    def __init__(self, limit_s: float, last_words: Sequence[Callable[[], str]]) -> None:
        self._limit_s, self._last_words = limit_s, last_words
        self._look_s = min(limit_s / LOOKS, LONGEST_LOOK_S)
        self._watches: dict[str, _Watch] = {}
        self._under_way: list[str] = []  # the innermost call last
        self._entered = 0
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._look_on, name="watchdog", daemon=True)

    def watching(self, what: str) -> _Watch:
        """Watch one call that may hang; calls nested within it are watched in its place.

        what: its name, for the message. Costs 0.2 us.
        """
        return self._watches.get(what) or self._watches.setdefault(what, _Watch(self, what))

    def _look_on(self) -> None:
        last, looks = 0, 0
        while not self._over.wait(self._look_s):
            entered, under_way = self._entered, self._under_way[-1:]
            looks = looks + 1 if under_way and entered == last else 0
            last = entered
            if looks * self._look_s >= self._limit_s:
                self._end(under_way[0])

    def _end(self, what: str) -> None:
        saved: list[str] = []
        for say_last in self._last_words:
            _within(LAST_WORDS_S, lambda say_last=say_last: saved.append(say_last()))  # type: ignore[misc]
        found = f"the OpenXR runtime has not answered {what} for {self._limit_s:g} s"
        line = "; ".join(
            [f"hmdwarp: {found}: it hangs; end its service, start it again, then try once more", *filter(None, saved)]
        )
        _within(PRINTING_S, lambda: _print(line))
        os._exit(MachineError.exit_status)

    def __enter__(self) -> Watchdog:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._over.set()
        self._thread.join()


class _Watch:
    """Watched calls of one name, which may nest: it keeps no state of a single call."""

    __slots__ = ("_dog", "_what")

    def __init__(self, dog: Watchdog, what: str) -> None:
        self._dog, self._what = dog, what

    def __enter__(self) -> None:
        dog = self._dog
        dog._under_way.append(self._what)
        dog._entered += 1

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._dog._under_way.pop()


def _within(limit_s: float, do: Callable[[], object]) -> None:
    """Call it, but wait no longer than that; ignore any failure."""

    def guarded() -> None:
        with suppress(BaseException):
            do()

    thread = threading.Thread(target=guarded, daemon=True)
    thread.start()
    thread.join(limit_s)


def _print(line: str) -> None:
    # Sys.stderr may be locked by the hung thread.
    os.write(2, f"{' '.join(line.split())}\n".encode(errors="replace"))
    sys.stdout.flush()  # os._exit does not flush


class GarbageControl:
    """Collect garbage only between pictures.

    What exists on entry (modules, shaders, the scene) is frozen, so that no collection scans it. A
    program that has frozen its objects itself keeps them frozen, and is not scanned at each entry.
    """

    def __init__(self, on: bool = True) -> None:
        """Configure it. on: False leaves collection to Python, for comparison."""
        self._on = on
        self._was_enabled = self._freezes = False

    def __enter__(self) -> GarbageControl:
        self._was_enabled, self._freezes = gc.isenabled(), not gc.get_freeze_count()
        if self._on:
            gc.collect()
            if self._freezes:
                gc.freeze()
            gc.disable()
        return self

    def between(self) -> None:
        """Collect the youngest generation, to which a refresh adds some hundred objects.

        Call between pictures.
        """
        if self._on:
            gc.collect(0)

    def __exit__(self, *_: object) -> None:
        if self._on:
            if self._freezes:
                gc.unfreeze()
            if self._was_enabled:
                gc.enable()


class Pauses:
    """Number and time of collections between `start` and `stop`, by generation.

    Costs about a microsecond for each collection.
    """

    def __init__(self) -> None:
        self._runs, self._total_ns, self._longest_ns = [0, 0, 0], 0, 0
        self._began_ns: int | None = None

    def start(self) -> None:
        """Count from now on."""
        gc.callbacks.append(self._notice)

    def stop(self) -> None:
        """Stop counting; safe to call twice, or without start."""
        if self._notice in gc.callbacks:
            gc.callbacks.remove(self._notice)

    def _notice(self, phase: str, about: dict[str, int]) -> None:
        if phase == "start":
            self._began_ns = time.perf_counter_ns()
        elif self._began_ns is not None:
            took_ns, self._began_ns = time.perf_counter_ns() - self._began_ns, None
            self._runs[about["generation"]] += 1
            self._total_ns += took_ns
            self._longest_ns = max(self._longest_ns, took_ns)

    def as_dict(self) -> dict[str, Any]:
        """Return its part of summary.json.

        Counts from the youngest generation to the oldest, times in ms.
        """
        return {"collections": self._runs, "total_ms": self._total_ns * 1e-6, "longest_ms": self._longest_ns * 1e-6}
