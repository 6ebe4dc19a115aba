"""Points of the scene's surfaces for a client that keeps them."""

from __future__ import annotations

import heapq
import struct
from collections.abc import Callable, Iterator
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from . import MOST_BUDGET, Delivered, between, layers


@attrs.frozen(order=True)
class Cloud:
    """Points that are delivered little by little."""

    # Bytes of each frame, at most, before they are packed.
    budget: int = attrs.field(default=60_000, validator=between(1, MOST_BUDGET))
    # Points that the client has room for.
    room: int = attrs.field(default=1 << 20, validator=between(1024, 1 << 26))
    # Distance of points in pixels of the shown picture, where all have arrived.
    spacing: float = attrs.field(default=1.0, validator=between(1e-3, 1e6))


@layers.register
class Points(Delivered):
    """A PointUpdate for each Cloud. The amount is the frozenset of them."""

    name = "points"
    summary = "new points of the surfaces that the head may see, packed: what lacks most first"
    drawn_by = "points"
    something = frozenset({Cloud()})


# A cell of the scene has an endless sequence of points of which any run is spread evenly. A block
# is a run of it with all that the receiver needs, so blocks may come in any order. Where the
# receiver's room runs out, a cell is forgotten as a whole: its age rises, and older blocks mean
# nothing.

# Room is given in pages of so many points.
PAGE = 16
_LARGEST = 128
# Bytes of a point: position, normal, colour.
POINT_BYTES = 9
# Whether all is sent that may be seen, and the background: zenith, horizon, ground.
_SKY = struct.Struct("<B9e")
# Cell, its age, the block, its points, the body, whether double-sided; lowest corner, edge, area.
_HEAD = struct.Struct("<IHHHHH5f")
HEAD_BYTES = _HEAD.size
SKY_BYTES = _SKY.size
# Any block fits.
LEAST_BUDGET = 2000
_AGES = 1 << 16

Sent = tuple[int, int, int]  # cell, age, block; block -1 for forgetting alone


def block_range(block: int) -> tuple[int, int]:
    """Return first point and number of points: a page, then as many as before up to 128."""
    if block == 0:
        return 0, PAGE
    if PAGE << (block - 1) >= _LARGEST:
        doublings = (_LARGEST // PAGE).bit_length()
        return _LARGEST * (block - doublings + 1), _LARGEST
    return PAGE << (block - 1), PAGE << (block - 1)


@attrs.frozen(eq=False)
class PointUpdate:
    """What one frame brings."""

    # The background and blocks; the link writes what it has decoded over it.
    content: NDArray[np.uint8]
    # What the sender needs to know again when it hears of the frame.
    blocks: tuple[Sent, ...] = ()
    sent_ns: int = 0


@attrs.frozen(eq=False)
class Block:
    """One run of points as received; count 0 where a cell is only forgotten."""

    cell: int
    age: int
    number: int
    body: int
    double_sided: bool
    low: tuple[float, float, float]
    edge: float
    area: float
    # (n,) packed positions, (n, 2) normals, (n, 3) colours; see scenes.SurfacePoints.
    positions: NDArray[np.uint32]
    normals: NDArray[np.uint8]
    colours: NDArray[np.uint8]

    def packed(self) -> bytes:
        """Return its bytes."""
        place = (*self.low, self.edge, self.area)
        count = len(self.positions)
        head = _HEAD.pack(self.cell, self.age, self.number % _AGES, count, self.body, self.double_sided, *place)
        return head + b"".join(array.tobytes() for array in (self.positions, self.normals, self.colours))


def packed_sky(colours: NDArray[np.float64], *, complete: bool) -> bytes:
    """Return the start of every update. colours: (3, 3) of zenith, horizon and ground."""
    largest = float(np.finfo(np.float16).max)
    return _SKY.pack(complete, *np.clip(colours, 0, largest).ravel())


def unpacked(content: NDArray[np.uint8]) -> tuple[bool, NDArray[np.float64], list[Block]]:
    """Return whether all that may be seen was sent, the background and the blocks of an update."""
    data = content.tobytes()
    complete, *sky = _SKY.unpack_from(data)
    return bool(complete), np.array(sky).reshape(3, 3), list(_blocks(data, _SKY.size))


def _blocks(data: bytes, at: int) -> Iterator[Block]:
    while at < len(data):
        cell, age, number, count, body, double, *low, edge, area = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        arrays: list[NDArray[Any]] = []
        for kind, columns in ((np.uint32, 1), (np.uint8, 2), (np.uint8, 3)):
            array = np.frombuffer(data, kind, count * columns, at)
            arrays.append(array if columns == 1 else array.reshape(count, columns))
            at += array.nbytes
        yield Block(cell, age, number, body, bool(double), (low[0], low[1], low[2]), edge, area, *arrays)


class PointSender:
    """The sender's book: for each cell what is on its way or has arrived.

    It holds some numbers for each cell, and what is on its way until its fate is heard. It never
    counts on room that the receiver may not have yet: forgotten cells take theirs until the
    receiver is known to have heard of it. See Link.settled for what the news assumes.
    """

    def __init__(self, cells: int, room: int) -> None:
        self._room = room // PAGE
        self._age, self._next = np.zeros(cells, np.int64), np.zeros(cells, np.int64)
        # Points sent and not known to be lost.
        self.points = np.zeros(cells, np.int64)
        self._lost: dict[int, set[int]] = {}
        # Cells whose forgetting must still be sent, and pages that they hold until it is heard.
        self._to_forget: dict[int, None] = {}
        self._held: dict[int, int] = {}
        self._used = 0
        self._news: list[tuple[int, int, PointUpdate, bool]] = []
        self._heard = 0
        # From sending to hearing of the arrival, of the last update known to have arrived.
        self.round_trip_ns: int | None = None

    @property
    def free(self) -> int:
        """Points that the receiver still has room for."""
        return (self._room - self._used) * PAGE

    @property
    def remembered(self) -> int:
        """How many things it remembers besides its numbers for each cell."""
        lost = sum(map(len, self._lost.values()))
        return lost + len(self._to_forget) + len(self._held) + sum(len(news[2].blocks) for news in self._news)

    def next_block(self, cell: int) -> int:
        """Return the block to send next: the first that was lost, else the first not sent."""
        lost = self._lost.get(cell)
        return min(lost) if lost else int(self._next[cell])

    def sent(self, cell: int) -> Sent:
        """Enter that next_block() is sent; return it with its age."""
        block = self.next_block(cell)
        if block == self._next[cell]:
            self._next[cell] += 1
        else:
            self._lost[cell].discard(block)
            if not self._lost[cell]:
                del self._lost[cell]
        count = block_range(block)[1]
        self.points[cell] += count
        self._used += count // PAGE
        return cell, int(self._age[cell]), block

    def forget(self, cell: int) -> None:
        """Take a cell from the receiver; it can be sent anew at once."""
        self._held[cell] = self._held.get(cell, 0) + int(self.points[cell]) // PAGE
        self._age[cell] = (self._age[cell] + 1) % _AGES
        self._next[cell] = self.points[cell] = 0
        self._lost.pop(cell, None)
        self._to_forget[cell] = None

    def forgetting(self, most: int) -> list[Sent]:
        """Return at most so many things to send so that cells are forgotten; entered as sent."""
        out = [(cell, int(self._age[cell]), -1) for cell in list(self._to_forget)[:most]]
        for cell, *_ in out:
            del self._to_forget[cell]
        return out

    def heard(self, update: PointUpdate, arrived: bool, heard_ns: int) -> None:
        """Take note of an update's fate, of which the sender hears at that instant."""
        heapq.heappush(self._news, (heard_ns, self._heard, update, arrived))
        self._heard += 1

    def settle(self, now_ns: int) -> None:
        """Act on the news heard by now."""
        while self._news and self._news[0][0] <= now_ns:
            heard_ns, _, update, arrived = heapq.heappop(self._news)
            if arrived:
                self.round_trip_ns = heard_ns - update.sent_ns
            for cell, age, block in update.blocks:
                if age == self._age[cell]:
                    (self._arrived if arrived else self._missing)(cell, block)

    def _arrived(self, cell: int, block: int) -> None:
        """Any block of the newest age makes the receiver forget older ones."""
        self._used -= self._held.pop(cell, 0)
        self._to_forget.pop(cell, None)

    def _missing(self, cell: int, block: int) -> None:
        if block < 0:
            if cell in self._held:
                self._to_forget[cell] = None
            return
        self._lost.setdefault(cell, set()).add(block)
        count = block_range(block)[1]
        self.points[cell] -= count
        self._used -= count // PAGE


@attrs.define(eq=False)
class _Cell:
    age: int
    slot: int
    blocks: set[int] = attrs.field(factory=set)
    pages: list[int] = attrs.field(factory=list)
    points: int = 0


class PointRoom:
    """The receiver's book: which pages and slot each cell has. It never takes more than its room.

    write: called with each block that is taken, its slot, its pages, and the points that the cell
    has now. clear: called with pages that hold nothing any more.
    """

    def __init__(
        self, room: int, write: Callable[[Block, int, list[int], int], None], clear: Callable[[list[int]], None]
    ) -> None:
        self._free = list(range(room // PAGE - 1, -1, -1))
        self._slots = list(range(room // PAGE - 1, -1, -1))
        self._cells: dict[int, _Cell] = {}
        # The age of cells that were forgotten.
        self._ages: dict[int, int] = {}
        self._write, self._clear = write, clear
        self.high = 0  # no page from here on was ever used

    @property
    def points(self) -> int:
        """How many points it holds."""
        return sum(cell.points for cell in self._cells.values())

    def take(self, block: Block) -> None:
        """Take a block, unless it came before or is older than what is there."""
        known = self._cells.get(block.cell)
        age = known.age if known is not None else self._ages.get(block.cell, 0)
        newer = (block.age - age) % _AGES
        if newer >= _AGES // 2:
            return
        if newer:
            if known is not None:
                cell = self._cells.pop(block.cell)
                self._clear(cell.pages)
                self._free += cell.pages
                self._slots.append(cell.slot)
            self._ages[block.cell] = block.age
        pages = len(block.positions) // PAGE
        known = self._cells.get(block.cell)
        if not pages or (known is not None and block.number in known.blocks) or pages > len(self._free):
            return
        if known is None:
            known = self._cells[block.cell] = _Cell(block.age, self._slots.pop())
        taken = [self._free.pop() for _ in range(pages)]
        known.pages += taken
        known.blocks.add(block.number)
        known.points += pages * PAGE
        self.high = max(self.high, max(taken) + 1)
        self._write(block, known.slot, taken, known.points)
