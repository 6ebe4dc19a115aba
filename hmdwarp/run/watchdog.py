"""Ends the program when a call into the runtime never comes back: a hung service leaves no other way out."""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from types import TracebackType

from ..errors import MachineError

LOOKS = 20  # at a call within the limit
LONGEST_LOOK_S = 0.25
LAST_WORDS_S = 10.0  # for each: a report takes a second or two, and a disk that hangs too must not keep the program
PRINTING_S = 1.0


class Watchdog:
    """Looks on from a thread of its own while it is entered. limit_s: how long one call may take. last_words: each is called before the
    program is ended, from another thread than the one that hangs, and may fail or hang itself; it returns what the user should know of
    it ("the recording is in walk.csv"), or "".

    What is counted is how often the call was still under way when looked at, not what a clock says: a program that was stopped for a
    while (Ctrl-Z, a debugger) goes on as if nothing had been.
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
        """Around one call that may hang; calls within it are watched in its place. what: its name, for the message. 0.2 us."""
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
            _within(LAST_WORDS_S, partial(_keep, say_last, saved))
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
    """Calls of one name; it holds nothing of a single call, so that one is enough for calls within calls."""

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


def _keep(say_last: Callable[[], str], saved: list[str]) -> None:
    saved.append(say_last())


def _within(limit_s: float, do: Callable[[], object]) -> None:
    """Do it, but do not wait for longer than that; whatever goes wrong in it."""

    def guarded() -> None:
        with suppress(BaseException):
            do()

    thread = threading.Thread(target=guarded, daemon=True)
    thread.start()
    thread.join(limit_s)


def _print(line: str) -> None:
    os.write(2, f"{' '.join(line.split())}\n".encode(errors="replace"))  # sys.stderr may be locked by who hangs
    sys.stdout.flush()  # os._exit does not
