"""Data that cross the link little by little: what has been sent, what has arrived, what is missing.

Things to send are bytes, each by its number. They cross in fragments, so that any of them fits a
budget, and a lost fragment is sent again by itself.
"""

from __future__ import annotations

import heapq
import struct
from collections.abc import Iterable, Iterator, Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

# As much as fits an Ethernet frame with its headers.
FRAGMENT_BYTES = 1400
# Number of the thing, of the fragment, how many fragments the thing has, bytes of this one.
_HEAD = struct.Struct("<IIIH")

Fragment = tuple[int, int]  # the thing, and which of its fragments


@attrs.frozen(eq=False)
class Update:
    """What one frame brings."""

    # Fragments with their heads; the link writes what it has decoded over it.
    content: NDArray[np.uint8]
    # What the sender needs to know again when it hears of the frame.
    fragments: tuple[Fragment, ...] = ()
    sent_ns: int = 0


class Outbox:
    """The sender's side: each thing until it has arrived.

    A fragment that was lost is sent again once the sender hears of the loss. What is on its way
    waits for that news, however long it takes; see Link.settled for what the news assumes.
    """

    def __init__(self, things: Sequence[bytes]) -> None:
        self._things = tuple(things)
        self._waiting = {number: set(range(_fragments(thing))) for number, thing in enumerate(things)}
        # When it is heard, a number that keeps equal instants in order, the update, its fate.
        self._news: list[tuple[int, int, Update, bool]] = []
        self._heard = 0
        # From sending to hearing of the arrival, of the last update that is known to have arrived;
        # None before the first.
        self.round_trip_ns: int | None = None

    @property
    def waiting(self) -> frozenset[int]:
        """The things of which something is to be sent."""
        return frozenset(self._waiting)

    def update(self, order: Iterable[int], budget: int, now_ns: int) -> Update:
        """Return the next fragments, of the first things in `order` that wait.

        order: a thing may occur more than once. budget: bytes; one fragment is sent however small
        it is.
        """
        out = bytearray()
        sent: list[Fragment] = []
        for piece, data in self._next(order):
            if sent and len(out) + _HEAD.size + len(data) > budget:
                break
            out += _HEAD.pack(*piece, _fragments(self._things[piece[0]]), len(data)) + data
            sent.append(piece)
        for number, index in sent:
            self._waiting[number].discard(index)
            if not self._waiting[number]:
                del self._waiting[number]
        return Update(np.frombuffer(bytes(out), np.uint8).copy(), tuple(sent), now_ns)

    def _next(self, order: Iterable[int]) -> Iterator[tuple[Fragment, bytes]]:
        for number in dict.fromkeys(order):
            for index in sorted(self._waiting.get(number, ())):
                yield (number, index), self._things[number][FRAGMENT_BYTES * index : FRAGMENT_BYTES * (index + 1)]

    def heard(self, update: Update, arrived: bool, heard_ns: int) -> None:
        """Take note of an update's fate, of which the sender hears at that instant."""
        if update.fragments:
            heapq.heappush(self._news, (heard_ns, self._heard, update, arrived))
            self._heard += 1

    def settle(self, now_ns: int) -> None:
        """Act on the news heard by now: what was lost waits again."""
        while self._news and self._news[0][0] <= now_ns:
            heard_ns, _, update, arrived = heapq.heappop(self._news)
            if arrived:
                self.round_trip_ns = heard_ns - update.sent_ns
                continue
            for number, index in update.fragments:
                self._waiting.setdefault(number, set()).add(index)


class Inbox:
    """The receiver's side: things as they become whole, in any order of arrival."""

    def __init__(self) -> None:
        self._begun: dict[int, dict[int, bytes]] = {}
        self._whole: set[int] = set()
        self.bytes = 0

    @property
    def whole(self) -> int:
        """How many things are whole."""
        return len(self._whole)

    def take(self, content: NDArray[np.uint8]) -> Iterator[tuple[int, bytes]]:
        """Take an update's content; yield the number and bytes of each thing that is now whole."""
        data, at = content.tobytes(), 0
        self.bytes += len(data)
        while at < len(data):
            number, index, count, length = _HEAD.unpack_from(data, at)
            at += _HEAD.size + length
            if number in self._whole:
                continue
            begun = self._begun.setdefault(number, {})
            begun[index] = data[at - length : at]
            if len(begun) == count:
                self._whole.add(number)
                del self._begun[number]
                yield number, b"".join(begun[index] for index in range(count))


def _fragments(thing: bytes) -> int:
    return max(1, -(-len(thing) // FRAGMENT_BYTES))
