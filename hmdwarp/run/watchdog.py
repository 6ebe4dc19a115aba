"""End the program when a call into the runtime never returns.

A hung service leaves no other way out.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from types import TracebackType

from ..errors import MachineError

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
    """Watched calls of one name.

    It keeps no state of a single call, so one object serves nested calls.
    """

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
