"""Silhouettes: depth that is off its colour is moved back, mixed depth is taken out."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from . import MeasuredDepth, Pixels, Repair, SurfaceSettings, repairs

# Jumps of depth that are looked at, and below which no offset is believed.
_MOST_JUMPS, _FEWEST_JUMPS = 4000, 50
_CONTRAST = 0.3  # of colour, summed over its channels: more than that is an edge, and counts no more
_BESIDE_THE_BEST = 9  # offsets around the best one that blurred edges raise too
_REACH = 2  # pixels between mixed depth and the surfaces that it is mixed of, at most
# Each with its opposite: left and right, above and below, and the two diagonals.
_WAYS = ((0, 1), (1, 0), (1, 1), (1, -1))


@attrs.frozen
class EdgesSettings(SurfaceSettings):
    # Most pixels by which depth may be off its colour, on each axis; 0 never moves it.
    most: int = 6
    # Standard deviations by which the best offset must stand out from the others.
    evidence: float = 5.0

    def __attrs_post_init__(self) -> None:
        if not 0 <= self.most <= 64:
            raise ValueError(f"most is {self.most}: expected 0 to 64 pixels")
        if not self.evidence >= 0:
            raise ValueError(f"evidence is {self.evidence:g}: expected 0 or more")


@repairs.register
class Edges(Repair):
    """Line depth up with colour, and remove flying pixels.

    Depth is moved as a whole, by whole pixels, to where its jumps meet the most contrast of colour,
    if that place stands out. A pixel between two surfaces, nearer than the one on its one side and
    farther than the one on the other, is on neither: it loses its depth.
    """

    name = "edges"
    summary = "depth moves to where its silhouettes meet those of the colour; depth between two surfaces is taken out"
    needs = "the CPU"
    source = (
        "jumps of depth meet edges of colour, as in Levinson and Thrun 2013, Automatic Online Calibration of Cameras "
        "and Lasers; flying pixels as in Reynolds et al. 2011, Capturing Time-of-Flight Data with Confidence"
    )
    Settings = EdgesSettings

    def run(self, colour: Pixels, depth: MeasuredDepth) -> MeasuredDepth:
        settings: EdgesSettings = self.settings
        with np.errstate(invalid="ignore"):  # NaN is no depth: every comparison with it is False
            down, right = depth_offset(colour, depth.inverse_depth, settings)
            inverse = _moved(depth.inverse_depth, down, right, np.nan)
            flying = _between_surfaces(inverse, settings)
        confidence = _moved(depth.confidence, down, right, 0)
        return MeasuredDepth(np.where(flying, np.float32(np.nan), inverse), np.where(flying, np.float32(0), confidence))


def depth_offset(colour: Pixels, inverse: Pixels, settings: EdgesSettings) -> tuple[int, int]:
    """Return how far depth must move, down and right, to meet its colour; (0, 0) if unclear."""
    most, contrast, count = settings.most, 0.0, 0
    for axis in (0, 1):
        here, before = np.moveaxis(inverse, axis, 0)[1:], np.moveaxis(inverse, axis, 0)[:-1]
        # Jumps that stay inside the picture at every offset.
        inside = settings.apart(here, before)[most : len(here) - most, most : here.shape[1] - most]
        at = np.flatnonzero(inside)
        at = at[:: -(-len(at) // _MOST_JUMPS) or 1]
        if len(at) == 0:
            continue
        rows, columns = np.divmod(at, inside.shape[1])
        contrasts = np.abs(np.diff(np.moveaxis(colour, axis, 0), axis=0)) @ np.ones(3, np.float32)
        steps = np.minimum(contrasts, np.float32(_CONTRAST))
        offsets = np.arange(2 * most + 1)  # from -most, as `inside` begins at most
        along, across = (offsets[:, None], offsets[None, :]) if axis == 0 else (offsets[None, :], offsets[:, None])
        place = (rows + along[..., None]) * steps.shape[1] + columns + across[..., None]
        contrast = contrast + steps.ravel()[place].sum(axis=2)
        count += len(at)
    if count < _FEWEST_JUMPS or most == 0:
        return 0, 0
    found = np.asarray(contrast)
    down, right = np.divmod(int(found.argmax()), found.shape[1])
    others = np.sort(found, axis=None)[:-_BESIDE_THE_BEST]
    stands_out = found.max() - np.median(found) > settings.evidence * others.std()
    at_the_end = {down, right} & {0, 2 * most}
    return (int(down) - most, int(right) - most) if stands_out and not at_the_end else (0, 0)


def _moved(values: Pixels, down: int, right: int, empty: float) -> Pixels:
    if down == right == 0:
        return values
    high, wide = values.shape
    moved = np.full_like(values, empty)
    moved[max(down, 0) : high + min(down, 0), max(right, 0) : wide + min(right, 0)] = values[
        max(-down, 0) : high - max(down, 0), max(-right, 0) : wide - max(right, 0)
    ]
    return moved


def _between_surfaces(inverse: Pixels, settings: EdgesSettings) -> NDArray[np.bool_]:
    """Return pixels farther than a neighbour, one or two away, and nearer than the opposite one."""
    around = np.pad(inverse, _REACH, constant_values=np.nan)
    at = np.flatnonzero(np.pad(_beside_jumps(inverse, settings), _REACH))
    depths, wide = around.ravel(), around.shape[1]
    here = depths[at]
    nearest_beside, found = settings.nearest_beside(here), np.zeros(len(at), bool)
    for reach in range(1, _REACH + 1):
        for down, right in _WAYS:
            step = reach * (down * wide + right)
            one, other = depths[at + step], depths[at - step]
            farther = np.minimum(one, other)
            found |= (np.maximum(one, other) > nearest_beside) & (here > settings.nearest_beside(farther))
    flying = np.zeros(depths.shape, bool)
    flying[at[found]] = True
    return flying.reshape(around.shape)[_REACH:-_REACH, _REACH:-_REACH]


def _beside_jumps(inverse: Pixels, settings: EdgesSettings) -> NDArray[np.bool_]:
    found = np.zeros(inverse.shape, bool)
    for axis in (0, 1):
        for distance in range(1, _REACH + 1):
            there = np.moveaxis(inverse, axis, 0)
            jumps = settings.apart(there[distance:], there[:-distance])
            marks = np.moveaxis(found, axis, 0)
            marks[distance:] |= jumps
            marks[:-distance] |= jumps
    return found


@repairs.register
class NoRepair(Repair):
    name = "none"
    summary = "depth as it was given: a pixel without depth is a hole"
    needs = "nothing"
    source = "the baseline of every repair"
    is_pass = False

    def run(self, colour: Pixels, depth: MeasuredDepth) -> MeasuredDepth:
        return depth
