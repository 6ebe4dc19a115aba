"""The books of both sides of a link of points: nothing lost for good, nothing doubled."""

from __future__ import annotations

from collections import Counter

import numpy as np

from hmdwarp.cloudlight.points import (
    LEAST_BUDGET,
    PAGE,
    Block,
    PointRoom,
    PointSender,
    block_range,
    packed_sky,
    unpacked,
)
from hmdwarp.frames.layers import Update

SKY = np.arange(9.0).reshape(3, 3)


def block_of(cell: int, age: int, number: int) -> Block:
    count = block_range(number)[1] if number >= 0 else 0
    rng = np.random.default_rng(cell + 100 * max(number, 0))
    arrays = (rng.integers(0, 1 << 30, count, np.uint32), *(rng.integers(0, 256, (count, k), np.uint8) for k in (2, 3)))
    return Block(cell, age, number, 2, True, (1.0, -2.0, 1e6), 0.5, 0.25, *arrays)


class Client:
    """A room that knows what each page holds."""

    def __init__(self, room: int) -> None:
        self.pages: dict[int, tuple[int, int]] = {}
        self.room = PointRoom(room, self.write, self.clear)

    def write(self, block: Block, slot: int, pages: list[int], points: int) -> None:
        assert not self.pages.keys() & set(pages)
        self.pages |= dict.fromkeys(pages, (block.cell, block.number))

    def clear(self, pages: list[int]) -> None:
        for page in pages:
            del self.pages[page]

    def take(self, update: Update) -> None:
        for block in unpacked(update.content)[2]:
            self.room.take(block)


def update_of(sent: list, now_ns: int) -> Update:
    data = packed_sky(SKY, complete=False) + b"".join(block_of(*block).packed() for block in sent)
    return Update(np.frombuffer(data, np.uint8).copy(), tuple(sent), now_ns)


def test_blocks_follow_each_other_in_whole_pages():
    at = 0
    for number in range(40):
        first, count = block_range(number)
        assert first == at and count % PAGE == 0
        assert len(block_of(0, 0, number).packed()) < LEAST_BUDGET - len(packed_sky(SKY, complete=True))
        at += count


def test_packing_is_reversible():
    wanted = [block_of(7, 3, 5), block_of(8, 65535, -1)]
    data = np.frombuffer(packed_sky(SKY, complete=True) + b"".join(block.packed() for block in wanted), np.uint8)
    complete, sky, got = unpacked(data)
    assert complete and np.array_equal(sky, SKY)
    for one, other in zip(got, wanted, strict=True):
        assert (one.cell, one.age, one.low, one.edge, one.area) == (
            other.cell, other.age, other.low, other.edge, other.area,
        )  # fmt: skip
        assert one.body == 2 and one.double_sided
        for name in ("positions", "normals", "colours"):
            assert np.array_equal(getattr(one, name), getattr(other, name))


def test_repeated_blocks_are_kept_once_and_older_ones_ignored():
    client = Client(1024)
    for sent in ([(1, 1, 0)], [(1, 1, 0)], [(1, 0, 1)]):
        client.take(update_of(sent, 0))
    assert client.room.points == PAGE
    client.take(update_of([(1, 2, -1)], 0))
    client.take(update_of([(1, 1, 1)], 0))
    assert client.room.points == 0 and not client.pages


def test_ten_minutes_of_loss_and_disorder_stay_within_bounds():
    """At 60 frames a second: a head wanders over 200 cells; the room holds a third."""
    rng, room, cells, frames = np.random.default_rng(0), 64 * 128, 200, 36_000
    book, client = PointSender(cells, room), Client(room)
    flying: list[tuple[int, Update]] = []
    most = 0
    for now in range(frames):
        book.settle(now)
        here = int(60 * (1 + np.sin(now / 500))) % cells
        wanted = range(here, min(here + 40, cells))
        if now > frames - 400:  # it stands still, and nothing is lost
            wanted = range(20, 60)
        sent = book.forgetting(20)
        for cell in wanted:
            if len(sent) >= 8:
                break
            if book.points[cell] < 128:
                if block_range(book.next_block(cell))[1] > book.free:
                    gone = [k for k in np.flatnonzero(book.points) if k not in wanted]
                    for k in gone[:5]:
                        book.forget(int(k))
                    break
                sent.append(book.sent(cell))
        update = update_of(sent, now)
        arrives = rng.random() > 0.2 or now > frames - 400
        due = now + int(rng.integers(1, 40))
        book.heard(update, arrives, due + 5)
        if arrives:
            flying.append((due, update))
        for due in [message for message in flying if message[0] <= now]:
            client.take(due[1])
        flying = [message for message in flying if message[0] > now]
        assert client.room.points <= room and len(client.pages) <= room // PAGE
        most = max(most, book.remembered)
    # Two frames of 28 things for each of the 45 frames before the news returns, and each cell's.
    assert most < 45 * 28 + 8 * cells
    pages = Counter(client.pages.values())
    assert all(count * PAGE == block_range(number)[1] for (_, number), count in pages.items()), "none is doubled"
    held = set(pages)
    for cell in range(20, 60):
        assert {number for of, number in held if of == cell} >= set(range(4)), "all that was wanted has arrived"
