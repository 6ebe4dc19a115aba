"""Clocks that wrap, and single stamps that are none: found from the numbers alone."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from .. import quaternions
from .times import BILLION, Stamps

_DAY_S = 86400
# A counter of 32 bits, with a sign or without, in its own unit or in one 10^3, 10^6, 10^9 as large;
# those of other sizes only where nothing is lost in between.
_BITS, _OTHER_BITS, _SCALES = (32, 31), (33, 30, 24, 16), (1, 10**3, 10**6, 10**9)
_LONG = 10**5  # steps a wrap: no recording ends by chance that near to the top, and begins near 0
_SHORTEST = 20  # steps a wrap
_NEAR, _NEAREST = 1000, 5  # steps from the last stamp before a wrap to the first after it
_SMOOTH = 3.0  # times the largest of the turns around it
_MOST_ROWS = 3  # rows in succession with a stamp that is none
_MOST_SHARE = 0.01
_LEAST_ROWS = 20
_IN_LINE = 10.0  # median steps
_ABSURD = 20.0  # times all other steps together


@attrs.frozen
class Wraps:
    """Where a clock begins again in one recording."""

    rows: NDArray[np.intp]  # the first of each round
    stamps: Stamps  # counted on
    what: str  # the length of a round, in words


def midnights(stamps: Stamps) -> Wraps | None:
    """Unwrap a time-of-day clock at midnight, where it falls by a day in one recording."""
    over = np.diff(stamps.whole) < -_DAY_S // 2
    over &= (stamps.whole[1:] < _DAY_S) & (stamps.whole[:-1] < _DAY_S)
    return _counted_on(stamps, over, _DAY_S * BILLION, "midnight") if stamps.clock and over.any() else None


def wraps_of(stamps: Stamps, orientation: NDArray[np.float64]) -> Wraps | None:
    """Unwrap a counter of so many bits that falls from near its top to near 0, or to its bottom.

    Counters of nanoseconds wrap every 4 seconds: there the head must move on smoothly as well, and
    so with bits that are rare.
    """
    steps = stamps.steps()
    falls = np.flatnonzero(steps < 0)
    if stamps.clock or not 0 < len(falls) * _SHORTEST <= len(stamps):
        return None
    step = float(np.median(steps[steps > 0]))
    scales = _SCALES if stamps.billionths.any() else (1,)
    for bits, scale in ((bits, scale) for bits in (*_BITS, *_OTHER_BITS) for scale in scales):
        top = 2**bits / scale
        if top < _SHORTEST * step:
            continue
        long = bits in _BITS and top / step > _LONG
        after = steps[falls] + top
        near = (after > 0) & (after <= step * (_NEAR if long else _NEAREST))
        near &= (stamps.whole[falls] <= top) & (stamps.whole[falls + 1] >= -top / 2 - 1)
        over = np.zeros(len(steps), bool)
        over[falls[near]] = True
        if not long:
            over &= _smooth(orientation)
        if over.any():
            return _counted_on(
                stamps, over, 2**bits * BILLION // scale, f"2^{bits}{f'/{scale:g}' if scale > 1 else ''}"
            )
    return None


def _counted_on(stamps: Stamps, over: NDArray[np.bool_], length: int, what: str) -> Wraps:
    rounds = np.concatenate([[0], np.cumsum(over)])
    whole, billionths = divmod(length, BILLION)
    parts = stamps.billionths + rounds * billionths
    counted = Stamps(stamps.whole + rounds * whole + parts // BILLION, parts % BILLION, stamps.clock)
    return Wraps(np.flatnonzero(over) + 1, counted, what)


def _smooth(orientation: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return of each step whether it turns the head no more than those around it."""
    unit = orientation / np.maximum(np.linalg.norm(orientation, axis=1, keepdims=True), 1e-9)
    angle = quaternions.angle_between(unit[:-1], unit[1:])
    padded = np.pad(angle, 3, mode="edge")
    around = np.max([padded[k : k + len(angle)] for k in (0, 1, 2, 4, 5, 6)], axis=0)
    return np.asarray(angle <= _SMOOTH * around + np.radians(1.0))


def absurd_rows(stamps: Stamps) -> NDArray[np.intp]:
    """Return rows whose stamp is out of line while those around it go on as if it were not there.

    Only a few: a clock that falls often has restarts or is no clock.
    """
    steps, n = stamps.steps(), len(stamps)
    falls = np.flatnonzero(steps < 0)
    if n < _LEAST_ROWS or not (steps > 0).any() or len(falls) > max(_MOST_ROWS, _MOST_SHARE * n):
        return np.empty(0, np.intp)
    step = float(np.median(steps[steps > 0]))
    found: set[int] = set()
    for fall in falls.tolist():
        if not {fall, fall + 1} & found:
            found |= _out_of_line(stamps, fall, step)
    if not found:  # no copy of what may be 10^7 rows
        return np.array(_far_ends(steps), dtype=np.intp)
    kept = np.setdiff1d(np.arange(n), sorted(found))
    ends = kept[list(_far_ends(stamps[kept].steps()))]
    return np.union1d(np.array(sorted(found), dtype=np.intp), ends)


def _out_of_line(stamps: Stamps, fall: int, step: float) -> set[int]:
    """Return the rows at a step back without which time goes on; empty where it starts anew."""
    for count in range(1, _MOST_ROWS + 1):
        for before, after in ((fall - count, fall + 1), (fall, fall + 1 + count)):
            if before >= 0 and after < len(stamps):
                gap = float(stamps[np.array([before, after])].steps()[0])
                if 0 < gap <= _IN_LINE * step * (count + 1):
                    return set(range(before + 1, after))
    return set()


def _far_ends(steps: NDArray[np.float64]) -> range:
    """Return the first or the last few rows where one step away from them dwarfs all others."""
    far = int(np.argmax(steps))
    others = float(steps[steps > 0].sum() - steps[far])
    if not 0 < others * _ABSURD < steps[far]:
        return range(0)
    if far < _MOST_ROWS:
        return range(far + 1)
    return range(far + 1, len(steps) + 1) if len(steps) - far <= _MOST_ROWS else range(0)
