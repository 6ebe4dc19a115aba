"""Faults that no convention is: an answer is told only where none of them explains as much."""

from __future__ import annotations

import itertools
import math
from typing import Any

import attrs
import numpy as np

from .conventions import PIXEL, differences
from .overlap import BEND, DEPTH_SHIFT, DEPTH_WIDE, TURN, Fitted, Noise, cost
from .search import SURE, Candidate, Search, margin, standard_errors
from .stated_frames import Reading

_CLOSE = 0.05  # of the depth
EXPLAINED = 0.98  # of the depths that nothing hides
_CUT, _AT_MOST = 0.02, 1e-3  # share of the pixels at the largest depth; how near to it they are
# What is fitted for each, and the least with a name: rad, per squared tangent, tangents, pixels.
_FITTED = {
    "a turn between pose and camera": dict.fromkeys(TURN, 0.015),
    "a lens that distorts": {BEND: 0.03},
    "depth of other optics than the colour": {DEPTH_WIDE: 0.02, **dict.fromkeys(DEPTH_SHIFT, 0.75)},
}
_EACH = {"scales": 0.01}
# Where a fit begins; shifts of the depth at tenths of the width.
_STARTS = {**dict.fromkeys(TURN, (-0.12, 0.0, 0.12)), BEND: (-0.2, 0.0, 0.2), DEPTH_WIDE: (0.85, 1.0, 1.18)}
FAULTS = ("depth that is cut off", *_FITTED, "depth of another scale in each frame")


def explained(search: Search, reading: Reading) -> float:
    """Return the share of the depths on surfaces that agree, of those that nothing nearer hides."""
    infinity = reading.end - reading.offset / reading.factor
    found = search.middle.residuals(attrs.evolve(reading, end=infinity, offset=0.0) if not reading.along else reading)
    known = found.depth[found.seen & ~np.isnan(found.depth) & ~found.sky] * math.copysign(1, reading.factor)
    agree, behind = int((np.abs(known) < _CLOSE).sum()), int((known > _CLOSE).sum())
    return agree / max(agree + behind, 1)


def standing_faults(search: Search, noise: Noise, best: Candidate) -> tuple[str, ...]:
    """Return those of FAULTS that explain the frames as well as a reading, or what it leaves."""
    own = best.fitted.names if best.fitted else ()
    tries, width = [], search.stated.frames[0].depth.shape[1]
    starts = _STARTS | dict.fromkeys(DEPTH_SHIFT, tuple(at * width for at in (-0.1, -0.05, 0.0, 0.05, 0.1)))
    for least in _FITTED.values():
        each_of = itertools.product(*(starts[name] for name in least))
        values: list[dict[str, Any]] = [dict(zip(least, one, strict=True)) for one in each_of]
        begun = [search.best([Reading(**each) for each in values])]
        if DEPTH_WIDE in least and (best.reading.pixel_x or best.reading.pixel_y):
            # A shift of the depth alone looks like a principal point that is off by as much.
            begun.append(Reading(depth_x=-best.reading.pixel_x, depth_y=-best.reading.pixel_y))
        instead = [search.fitted(one, tuple(least)) for one in begun]
        tries.append((instead, search.fitted(best.reading, (*least, *own)), least))
    tries.append(([_of_each(search, Reading())], _of_each(search, best.reading), _EACH))
    may_be_cut_off = best.changes or explained(search, best.reading) < EXPLAINED
    found = []
    if may_be_cut_off and not search.stated.may_be_buffer:
        depths = [frame.depth[np.isfinite(frame.depth) & (frame.depth != 0)] for frame in search.stated.frames]
        most = (1 - _AT_MOST) * max(float(depth.max()) for depth in depths)
        found = [FAULTS[0]] if float(np.median([float((depth > most).mean()) for depth in depths])) > _CUT else []
    for words, (instead, besides, least) in zip(FAULTS[1:], tries, strict=True):
        leaves = -_margin(search, noise, besides.reading, best, least) > SURE
        # A turn of a degree is half a pixel, which is the more common.
        named = {name: limit * (1 + (PIXEL in differences(best.reading))) for name, limit in least.items()}
        explains = best.changes and any(
            _has_a_name(one, named) and _margin(search, noise, one.reading, best, least) < SURE for one in instead
        )
        if explains or leaves and _has_a_name(besides, named):
            found.append(words)
    return tuple(found)


def _margin(search: Search, noise: Noise, one: Reading, best: Candidate, least: dict[str, float]) -> float:
    """Return by how many standard errors a reading is worse than the best."""
    if DEPTH_WIDE not in least:
        return margin(search.candidate(one, noise, 1), best)
    # Elsewhere in the picture of depth there are other gaps and edges: what both know is compared.
    found = [search.fine.residuals(reading) for reading in (one, best.reading)]
    known = ~np.isnan(found[0].depth + found[1].depth)
    costs = (np.where(known, cost(each, noise), np.nan) for each in found)
    worse, better = (search.fine.by_block(each)[0] for each in costs)
    return standard_errors(worse - better)


def _has_a_name(found: Fitted, least: dict[str, float]) -> bool:
    error = dict(zip(found.names, found.error, strict=True))
    off = {name: np.abs(np.subtract(getattr(found.reading, name), name == DEPTH_WIDE)).max() for name in least}
    return any(off[name] > max(most, SURE * error.get(name, 0.0)) for name, most in least.items())


def _of_each(search: Search, reading: Reading) -> Fitted:
    """Return the reading with a scale of the depth of each frame, 1 on average."""
    pairs, count = search.middle.pairs, len(search.stated.frames)
    rows = np.eye(count)[pairs[:, 0]] - np.eye(count)[pairs[:, 1]]
    scales = np.zeros(count)
    for _ in range(3):
        found = search.middle.residuals(attrs.evolve(reading, scales=tuple(scales)))
        with np.errstate(invalid="ignore"):
            off = np.array([np.median(one[np.abs(one) < 1]) if (np.abs(one) < 1).any() else 0.0 for one in found.depth])
        scales -= np.linalg.lstsq(rows, off, rcond=None)[0]
    return Fitted(attrs.evolve(reading, scales=tuple((scales - scales.mean()).tolist())))
