"""Ends the program when a call into the runtime never comes back: a hung service leaves no other way out."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Watchdog:
    """Looks on from a thread of its own. limit_s: how long one call may take. last_words: called before the program is ended."""

    def __init__(self, limit_s: float, last_words: Callable[[], None]) -> None:
        self._limit_s, self._last_words = limit_s, last_words

    @contextmanager
    def watching(self, what: str) -> Iterator[None]:
        """Around one call that may hang. what: its name, for the message."""
        yield

    def __enter__(self) -> Watchdog:
        return self

    def __exit__(self, *_: object) -> None:
        pass
