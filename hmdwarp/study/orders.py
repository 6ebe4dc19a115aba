"""In which order conditions come: balanced, and allotted by what is missing, not by the number of a participant."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence

from ..errors import InputError
from .design import FIXED, RANDOM, WILLIAMS, Design, Part

Order = tuple[tuple[str, ...], ...]  # names of conditions, a tuple for each repeat
RANDOM_ROWS = 1000  # more than there are participants: each gets a row nobody else had


def williams(n: int) -> tuple[tuple[int, ...], ...]:
    """Rows of 0 .. n-1: n of them where n is even, 2n where it is odd.

    Over all rows every number is in each place equally often (once, or twice), and every ordered pair of different numbers stands side
    by side equally often. Source: Williams 1949, Experimental designs balanced for the estimation of residual effects of treatments,
    Aust J Sci Res A 2(2). For n = 6 it is the square of his table: 1 2 6 3 5 4 and its shifts.
    """
    if n < 1:
        raise InputError(f"a Williams design of {n} conditions: wanted 1 or more")
    first = _zigzag(n)
    rows = [tuple((one + shift) % n for one in first) for shift in range(n)]
    if n % 2 and n > 1:
        rows += [row[::-1] for row in rows]
    return tuple(rows)


def _zigzag(n: int) -> tuple[int, ...]:
    """0, 1, n-1, 2, n-2, ..: neighbours differ by every number of 1 .. n-1 once (n even), or by each and its opposite (n odd)."""
    return tuple((k + 1) // 2 if k % 2 else (n - k // 2) % n for k in range(n))


def rows_for(design: Design, part: str) -> tuple[Order, ...]:
    """All orders of a part; a participant gets one of them. Names of conditions, a tuple for each repeat.

    williams: the rows of the square, which condition is which number by a draw from the seed. Every repeat goes through the whole square,
    in other rows each time, so that over all orders each repeat is balanced by itself. Between two repeats, pairs are spread as evenly
    as they can be over the orders, and no condition follows itself (unless it is the only one).
    random: RANDOM_ROWS of them, every repeat a permutation of its own that does not begin with what the one before ended with.
    fixed: one, as in the file.
    The same file gives the same orders, on every machine and with every version of Python.
    """
    conditions = design.part(part)
    names = tuple(one.name for one in conditions.conditions)
    if design.order == FIXED:
        return ((names,) * design.repeats,)
    if design.order == RANDOM:
        return tuple(_random_order(design, conditions, row) for row in range(RANDOM_ROWS))
    assert design.order == WILLIAMS
    drawn = _shuffled(names, design.seed, "williams", part)
    shifts = _seam_shifts(len(names), design.repeats)
    square = williams(len(names))
    return tuple(_rows_of(square, row, shifts, drawn) for row in range(len(square)))


def _rows_of(square: tuple[tuple[int, ...], ...], row: int, shifts: Sequence[int], names: Sequence[str]) -> Order:
    """The order that begins with that row of the square. The mirrored half of an odd one moves the other way: see _seam_shifts."""
    n = len(names)
    half, place = divmod(row, n)
    rows = [square[half * n + (place + (-shift if half else shift)) % n] for shift in shifts]
    return tuple(tuple(names[number] for number in one) for one in rows)


def _seam_shifts(n: int, repeats: int) -> tuple[int, ...]:
    """How far each repeat's row lies from the first one's.

    Rows are shifts of one sequence, so where the row moves by s from one repeat to the next, what stands last before the seam and what
    comes first after it differ by d = s - reach in all orders at once (reach: from the first to the last of a row). Over all orders that
    is each pair of distance d once; in the mirrored half, which moves by -s, each pair of distance -d. So d = 0 is never taken, the least
    used d is, and of these one whose row was used least.
    """
    first = _zigzag(n)
    reach, mirrored = first[-1], n % 2 == 1
    shifts, seams, rows = [0], [0] * n, [0] * n
    rows[0] = 1
    for _ in range(repeats - 1):
        steps = [step for step in range(n) if (step - reach) % n] or [0]
        step = min(steps, key=lambda s: (seams[(s - reach) % n], rows[(shifts[-1] + s) % n], (s - reach) % n))
        for distance in {(step - reach) % n, (reach - step) % n} if mirrored else {(step - reach) % n}:
            seams[distance] += 1
        shifts.append((shifts[-1] + step) % n)
        rows[shifts[-1]] += 1
    return tuple(shifts)


def _random_order(design: Design, part: Part, row: int) -> Order:
    names = tuple(one.name for one in part.conditions)
    order: list[tuple[str, ...]] = []
    for repeat in range(design.repeats):
        drawn = _shuffled(names, design.seed, "random", part.name, row, repeat)
        again = 0
        while order and len(names) > 1 and drawn[0] == order[-1][-1]:
            again += 1
            drawn = _shuffled(names, design.seed, "random", part.name, row, repeat, again)
        order.append(drawn)
    return tuple(order)


def allot(filled: Sequence[int], seed: int) -> int:
    """The row whose turn it is: one of those taken least often. filled: how often each row is taken, by sessions that are over or going on.

    Between several, a draw from the seed and from what is filled decides, never the number of a participant: who comes next cannot be
    told from who came before, and gaps that dropouts left are filled first.
    """
    if not filled:
        raise InputError("there is no order to allot: the part has no conditions")
    least = min(filled)
    tied = [row for row, count in enumerate(filled) if count == least]
    return tied[_draw(len(tied), seed, "allot", *filled)]


def _shuffled(names: Sequence[str], seed: int, *words: object) -> tuple[str, ...]:
    """A permutation that these words decide (Fisher and Yates)."""
    out = list(names)
    for last in range(len(out) - 1, 0, -1):
        chosen = _draw(last + 1, seed, *words, last)
        out[last], out[chosen] = out[chosen], out[last]
    return tuple(out)


def _draw(below: int, seed: int, *words: object) -> int:
    """0 .. below-1, decided by the words alone: NumPy's and Python's generators may change what a seed gives. Of 256 bits, so each
    number is as likely as any other to 70 places."""
    told = "\x1f".join(map(str, (seed, *words)))
    return int.from_bytes(hashlib.sha256(told.encode()).digest(), "big") % below
