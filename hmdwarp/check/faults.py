"""Faults that no convention is: an answer is told only where none of them explains as much."""

from __future__ import annotations

import itertools
import math

import attrs
import numpy as np

from .conventions import PIXEL, differences
from .overlap import BEND, DEPTH_SHIFT, DEPTH_WIDE, LOGARITHMS, TURN, Fitted, Noise, cost
from .search import SURE, Candidate, Search, standard_errors
from .stated_frames import Reading

_CLOSE = 0.05  # of the depth
EXPLAINED = 0.98  # of the depths that nothing hides
_CUT, _AT_MOST = 0.02, 1e-3  # share of the pixels at the largest depth; how near to it they are
# What is fitted for each, and the least with a name: rad, per squared tangent, tangents, pixels.
_FITTED = {
    "a turn between pose and camera": dict.fromkeys(TURN, 0.015),
    "a lens that distorts": {BEND: 0.03},
    "depth of other optics than the colour": {DEPTH_WIDE: 0.02, **dict.fromkeys(DEPTH_SHIFT, 0.75)},
    "depth of another scale in each frame": {"scales": 0.01},
}
FAULTS = ("depth that is cut off", *_FITTED)
_SHIFTS = (-0.1, -0.05, 0.0, 0.05, 0.1)  # where a fit begins; shifts of the depth in shares of the width
_STARTS = {**dict.fromkeys(TURN, (-0.12, 0.0, 0.12)), BEND: (-0.2, 0.0, 0.2), DEPTH_WIDE: (0.85, 1.0, 1.18)}
_SURELY = 14.0  # standard errors of the answer's numbers, with a fault fitted beside them


def explained(search: Search, reading: Reading) -> float:
    """Return the share of the depths on surfaces that agree, of those that nothing nearer hides."""
    infinity = reading.end - reading.offset / reading.factor
    found = search.middle.residuals(attrs.evolve(reading, end=infinity, offset=0.0) if not reading.along else reading)
    known = found.depth[found.seen & ~np.isnan(found.depth) & ~found.sky] * math.copysign(1, reading.factor)
    agree, behind = int((np.abs(known) < _CLOSE).sum()), int((known > _CLOSE).sum())
    return agree / max(agree + behind, 1)


def standing(search: Search, noise: Noise, best: Candidate, own: tuple[str, ...], base: Reading) -> tuple[str, ...]:
    """Return those of FAULTS that explain what a reading leaves, or the frames as well as it.

    own, base: the numbers of the reading, and the reading with them as stated.
    """
    found = [words for words, least in _FITTED.items() if _stands(search, noise, best, own, base, least)]
    if search.stated.may_be_buffer or (not best.changes and explained(search, best.reading) >= EXPLAINED):
        return tuple(found)
    depths = [frame.depth[np.isfinite(frame.depth) & (frame.depth != 0)] for frame in search.stated.frames]
    most = (1 - _AT_MOST) * max(float(depth.max()) for depth in depths)
    is_cut = float(np.median([float((depth > most).mean()) for depth in depths])) > _CUT
    return (*FAULTS[: int(is_cut)], *found)


def _stands(
    search: Search, noise: Noise, best: Candidate, own: tuple[str, ...], base: Reading, least: dict[str, float]
) -> bool:
    width = search.stated.frames[0].depth.shape[1]
    # A turn of a degree is half a pixel, which is the more common.
    named = {name: limit * (1 + (PIXEL in differences(best.reading))) for name, limit in least.items()}
    starts = _STARTS | dict.fromkeys(DEPTH_SHIFT, tuple(at * width for at in _SHIFTS)) | {"scales": ((),)}
    values = itertools.product(*(starts[name] for name in least))
    tried = (attrs.evolve(base, **dict(zip(least, one, strict=True))) for one in values)
    begun = [min(tried, key=lambda one: search.candidate(one, noise, 1).total)]
    if DEPTH_WIDE in least:  # a shift of the depth alone looks like a principal point that is off
        begun.append(attrs.evolve(base, depth_x=-best.reading.pixel_x, depth_y=-best.reading.pixel_y))
    instead = [_fitted(search, one, tuple(least)) for one in begun]
    beside = [_fitted(search, one, (*least, *own)) for one in (best.reading, *(found.reading for found in instead))]
    gains = []
    for one in beside:
        found = [search.fine.residuals(reading) for reading in (best.reading, one.reading)]
        known = ~np.isnan(found[0].depth + found[1].depth)  # elsewhere in the picture of depth are other gaps
        before, after = (search.fine.by_block(np.where(known, cost(each, noise), np.nan))[0] for each in found)
        gains.append(before - after)
    nearest = int(np.argmax([gain.sum() for gain in gains]))
    both, leaves = beside[nearest], standard_errors(gains[nearest])
    sure = [off / error for name in own if name in both.names for off, error in [_off(both, name)]]
    is_doubtful = max(sure, default=math.inf) < _SURELY and any(_has_a_name(one, named) for one in instead)
    return is_doubtful or (leaves > SURE and _has_a_name(both, named))


def _off(found: Fitted, name: str) -> tuple[float, float]:
    """Return by how much a number is not as stated, and its standard error."""
    value = np.asarray(getattr(found.reading, name))
    off = np.abs(np.log(np.abs(value)) if name in LOGARITHMS else value).max()
    return float(off), dict(zip(found.names, found.error, strict=True)).get(name, 0.0)


def _has_a_name(found: Fitted, least: dict[str, float]) -> bool:
    return any(off > max(most, SURE * error) for name, most in least.items() for off, error in [_off(found, name)])


def _fitted(search: Search, reading: Reading, names: tuple[str, ...]) -> Fitted:
    """Return the reading with these numbers as the frames have them."""
    if "scales" not in names:
        return search.fitted(search.fitted(reading, names).reading, names)
    pairs, count = search.middle.pairs, len(search.stated.frames)
    rows = np.eye(count)[pairs[:, 0]] - np.eye(count)[pairs[:, 1]]
    scales = np.zeros(count)
    for _ in range(3):
        found = search.middle.residuals(attrs.evolve(reading, scales=tuple(scales)))
        with np.errstate(invalid="ignore"):
            off = np.array([np.median(one[np.abs(one) < 1]) if (np.abs(one) < 1).any() else 0.0 for one in found.depth])
        scales -= np.linalg.lstsq(rows, off, rcond=None)[0]
    return Fitted(attrs.evolve(reading, scales=tuple((scales - scales.mean()).tolist())))
