"""Balanced orders of conditions and of pairs, and the order that the next session gets."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ...base import InputError
from ..scales import FIRST, NEITHER
from .definitions import FIXED, PAIR, RANDOM, Design

_BETWEEN = "/"  # no condition's name has it

Pair = tuple[str, str]  # as they are shown
Table = NDArray[np.float64]  # (n, n) counts


def pair_name(first: str, second: str) -> str:
    """Return a pair as an order names it: the first condition is shown first."""
    return f"{first}{_BETWEEN}{second}"


def pair_of(name: str) -> Pair:
    """Return the two conditions of a pair's name."""
    first, second = name.split(_BETWEEN)
    return first, second


def turned(name: str) -> str:
    """Return the name of the same pair the other way round."""
    return pair_name(*reversed(pair_of(name)))


def every_pair(names: Sequence[str]) -> tuple[str, ...]:
    """Return each pair once; each condition comes first as often, but for one."""
    numbered = list(enumerate(names))
    return tuple(
        pair_name(a, b) if (i + j) % 2 else pair_name(b, a) for (i, a), (j, b) in itertools.combinations(numbered, 2)
    )


def tables_of(
    names: Sequence[str], answers: Iterable[tuple[Pair, float]], *, allows_ties: bool
) -> tuple[Table, Table | None]:
    """Count answers about pairs as shown, FIRST, SECOND or NEITHER, as jod_scores takes them."""
    place = {name: number for number, name in enumerate(names)}
    wins, ties = np.zeros((2, len(names), len(names)))
    for (first, second), answer in answers:
        a, b = place[first], place[second]
        if answer == NEITHER:
            ties[a, b] += 1
            ties[b, a] += 1
        elif answer == FIRST:
            wins[a, b] += 1
        else:
            wins[b, a] += 1
    return wins, ties if allows_ties else None


Order = tuple[tuple[str, ...], ...]  # names of conditions or pairs, one tuple per repeat
RANDOM_ROWS = 1000  # more than there are participants, so that no two share a row


def williams(n: int) -> tuple[tuple[int, ...], ...]:
    """Return the rows of a Williams design over 0 .. n-1: n for even n, 2n for odd n.

    Over all rows every number stands in each place equally often, and every ordered pair of
    different numbers stands side by side equally often. For n = 6 it is the square of Williams'
    table: 1 2 6 3 5 4 and its shifts.

    Errors: InputError for n below 1.
    Source: Williams 1949, Experimental designs balanced for the estimation of residual effects of
    treatments, Aust J Sci Res A 2(2).
    """
    if n < 1:
        raise InputError(f"a Williams design of {n} conditions: expected 1 or more")
    first = _zigzag(n)
    rows = [tuple((number + shift) % n for number in first) for shift in range(n)]
    if n % 2 and n > 1:
        rows += [row[::-1] for row in rows]
    return tuple(rows)


def _zigzag(n: int) -> tuple[int, ...]:
    """Return 0, 1, n-1, 2, n-2, ..: neighbours differ by each of 1 .. n-1 (or minus it) once."""
    return tuple((k + 1) // 2 if k % 2 else (n - k // 2) % n for k in range(n))


def rows_for(design: Design, part: str) -> tuple[Order, ...]:
    """Return all orders of a part; each participant gets one of them.

    williams: the rows of the square; the seed draws which condition gets which number. Every repeat
    goes through the whole square, in other rows each time, so that each repeat is balanced over all
    orders. Between two repeats pairs are spread as evenly as possible over the orders, and no
    condition follows itself (unless it is the only one).
    random: RANDOM_ROWS orders; each repeat is its own permutation, and does not begin with the last
    condition of the repeat before.
    fixed: one order, that of the file.
    In a study of pairs the same of pairs. Each order comes a second time with every pair the other
    way round, and so does each second repeat.
    The same file gives the same orders on every machine and with every version of Python.
    """
    names, orders = presented(design, part), tuple[Order, ...]()
    if design.order == FIXED:
        orders = ((names,) * design.repeats,)
    elif design.order == RANDOM:
        orders = tuple(_random_order(design, part, names, row) for row in range(RANDOM_ROWS))
    else:
        orders = _williams_orders(_shuffled(names, design.seed, "williams", part), design.repeats)
    if design.shows != PAIR:
        return orders

    def alternating(order: Order, first: int) -> Order:
        """Turn the pairs of every second repeat. first: 1 to begin with turned ones."""
        return tuple(tuple(map(turned, names)) if (repeat + first) % 2 else names for repeat, names in enumerate(order))

    return tuple(alternating(order, first) for first in (0, 1) for order in orders)


def _williams_orders(names: tuple[str, ...], repeats: int) -> tuple[Order, ...]:
    """Return the order from each row on; the mirrored half moves back: see _seam_shifts."""
    n, shifts, square, orders = len(names), _seam_shifts(len(names), repeats), williams(len(names)), list[Order]()
    for row in range(len(square)):
        half, place = divmod(row, n)
        rows = [square[half * n + (place + (-shift if half else shift)) % n] for shift in shifts]
        orders.append(tuple(tuple(names[number] for number in row) for row in rows))
    return tuple(orders)


def presented(design: Design, part: str) -> tuple[str, ...]:
    """Return what a repeat shows: the names of the part's conditions, or of its pairs."""
    names = tuple(condition.name for condition in design.part(part).conditions)
    return every_pair(names) if design.shows == PAIR else names


def trials_of(design: Design, part: str) -> int:
    """Return the number of trials of a session."""
    return len(presented(design, part)) * design.repeats


def _seam_shifts(n: int, repeats: int) -> tuple[int, ...]:
    """Return how far each repeat's row lies from the row of the first repeat.

    Rows are shifts of one sequence. Where the row moves by s from one repeat to the next, the last
    number before the seam and the first after it differ by d = s - reach in all orders at once
    (reach: from the first to the last number of a row). Over all orders that is each pair of
    distance d once; in the mirrored half, which moves by -s, each pair of distance -d. So d = 0 is
    never chosen; the least used d is, and of several the one whose row was used least.
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


def _random_order(design: Design, part: str, names: tuple[str, ...], row: int) -> Order:
    order: list[tuple[str, ...]] = []
    for repeat in range(design.repeats):
        drawn = _shuffled(names, design.seed, "random", part, row, repeat)
        again = 0
        while order and len(names) > 1 and drawn[0] == order[-1][-1]:
            again += 1
            drawn = _shuffled(names, design.seed, "random", part, row, repeat, again)
        order.append(drawn)
    return tuple(order)


def allot(filled: Sequence[int], seed: int) -> int:
    """Return the row for the next session: one of those filled least often, drawn by seed.

    filled: how many complete or running sessions each row has. No participant's number decides:
    the next order cannot be guessed.
    """
    if not filled:
        raise InputError("there is no order to allot: the part has no conditions")
    least = min(filled)
    tied = [row for row, count in enumerate(filled) if count == least]
    return tied[draw(len(tied), seed, "allot", *filled)]


def _shuffled(names: Sequence[str], seed: int, *words: object) -> tuple[str, ...]:
    """Return a permutation that the seed and these words decide (Fisher and Yates)."""
    out = list(names)
    for last in range(len(out) - 1, 0, -1):
        chosen = draw(last + 1, seed, *words, last)
        out[last], out[chosen] = out[chosen], out[last]
    return tuple(out)


def draw(below: int, seed: int, *words: object) -> int:
    """Draw from 0 .. below-1, decided by seed and words alone.

    NumPy's and Python's generators may change what a seed gives; SHA-256 does not. With 256 bits
    every number is equally likely to 70 places.
    """
    text = "\x1f".join(map(str, (seed, *words)))
    return int.from_bytes(hashlib.sha256(text.encode()).digest(), "big") % below
