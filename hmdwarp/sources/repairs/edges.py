"""Depth off its colour is moved back, mixed depth taken out, and missing depth guessed."""

from __future__ import annotations

from collections.abc import Iterator

import attrs
import numpy as np
from numpy.typing import NDArray

from . import LEAST_SURE, MOST_SURE, MeasuredDepth, Pixels, Repair, SurfaceSettings, repairs

# Jumps of depth that are looked at, and below which no offset is believed.
_MOST_JUMPS, _FEWEST_JUMPS = 4000, 50
_CONTRAST = 0.3  # of colour, summed over its channels: more than that is an edge, and counts no more
_BESIDE_THE_BEST = 9  # offsets around the best one that blurred edges raise too
_REACH = 2  # pixels between mixed depth and the surfaces that it is mixed of, at most
# Each with its opposite: left and right, above and below, and the two diagonals.
_WAYS = ((0, 1), (1, 0), (1, 1), (1, -1))


@attrs.frozen
class _EdgesSettings(SurfaceSettings):
    most: int = 6  # most pixels by which depth may be off its colour, on each axis; 0 never moves it
    evidence: float = 5.0  # standard deviations by which the best offset must stand out from the others

    def __attrs_post_init__(self) -> None:
        if not 0 <= self.most <= 64:
            raise ValueError(f"most is {self.most}: expected 0 to 64 pixels")
        if not self.evidence >= 0:
            raise ValueError(f"evidence is {self.evidence:g}: expected 0 or more")


@repairs.register
class Edges(Repair):
    """Line depth up with colour where its jumps meet contrast, and remove flying pixels."""

    name = "edges"
    summary = "depth moves to where its silhouettes meet those of the colour; depth between two surfaces is taken out"
    needs = "the CPU"
    source = (
        "jumps of depth meet edges of colour, as in Levinson and Thrun 2013, Automatic Online Calibration of Cameras "
        "and Lasers; flying pixels as in Reynolds et al. 2011, Capturing Time-of-Flight Data with Confidence"
    )
    Settings = _EdgesSettings

    def run(self, colour: Pixels, depth: MeasuredDepth) -> MeasuredDepth:
        settings: _EdgesSettings = self.settings
        with np.errstate(invalid="ignore"):  # NaN is no depth: every comparison with it is False
            down, right = depth_offset(colour, depth.inverse_depth, settings)
            inverse = _moved(depth.inverse_depth, down, right, np.nan)
            flying = _between_surfaces(inverse, settings)
        confidence = _moved(depth.confidence, down, right, 0)
        return MeasuredDepth(np.where(flying, np.float32(np.nan), inverse), np.where(flying, np.float32(0), confidence))


def depth_offset(colour: Pixels, inverse: Pixels, settings: _EdgesSettings) -> tuple[int, int]:
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


def _between_surfaces(inverse: Pixels, settings: _EdgesSettings) -> NDArray[np.bool_]:
    """Return pixels farther than a neighbour, one or two away, and nearer than the opposite one."""
    beside = np.zeros(inverse.shape, bool)  # of a jump of depth along a row or a column
    for axis in (0, 1):
        there, marks = np.moveaxis(inverse, axis, 0), np.moveaxis(beside, axis, 0)
        for distance in range(1, _REACH + 1):
            jumps = settings.apart(there[distance:], there[:-distance])
            marks[distance:] |= jumps
            marks[:-distance] |= jumps
    around = np.pad(inverse, _REACH, constant_values=np.nan)
    at = np.flatnonzero(np.pad(beside, _REACH))
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


@repairs.register
class NoRepair(Repair):
    name = "none"
    summary = "depth as it was given: a pixel without depth is a hole"
    needs = "nothing"
    source = "the baseline of every repair"
    is_pass = False

    def run(self, colour: Pixels, depth: MeasuredDepth) -> MeasuredDepth:
        return depth


_WIDEST = 320  # pixels of the longer side on which gaps are closed; finer pictures take a share of their pixels
_UNLIKE = 1e-3  # weight of a colour that has nothing in common: something is better than nothing
_DIAGONAL = np.float32(np.sqrt(2))


@attrs.frozen
class _CompleteSettings(SurfaceSettings):
    colour: float = 0.08  # standard deviation of colours of one surface, sRGB of 0 to 1
    reach: float = 0.075  # share of the picture's longer side at which the confidence has fallen to a half
    least: float = 0.0  # confidence below which a guess is not taken: the pixel stays a hole

    def __attrs_post_init__(self) -> None:
        if not (0 < self.colour < float("inf") and 0 < self.reach < float("inf")):
            raise ValueError(f"colour={self.colour:g}, reach={self.reach:g}: expected more than 0")
        if not 0 <= self.least <= 1:
            raise ValueError(f"least is {self.least:g}: expected 0 to 1")


@repairs.register
class Complete(Repair):
    """Give each pixel without depth that of a surface next to the gap.

    Eight directions propose the first measured depth on them, weighted by colour and the square of
    the distance. The surface with the most support wins; the weighted mean of its proposals is the
    guess, its share of all weights times 2^-(d / reach)^2 at the nearest one's distance d the
    confidence. Measured depth stays as it is, bit for bit.
    """

    name = "complete"
    summary = "missing depth is guessed from the measured depth around it, by colour and distance, with a confidence"
    needs = "the CPU"
    source = (
        "joint bilateral weights as in Petschnigg et al. 2004 and Kopf et al. 2007, on the nearest measured pixels; "
        "the vote between surfaces is this project's"
    )
    Settings = _CompleteSettings

    def run(self, colour: Pixels, depth: MeasuredDepth) -> MeasuredDepth:
        settings: _CompleteSettings = self.settings
        gaps = np.isnan(depth.inverse_depth)
        if not gaps.any() or gaps.all():
            return depth
        part = -(-max(gaps.shape) // _WIDEST)
        guess, confidence = _closed(*_reduced(colour, depth.inverse_depth, part), settings, part / max(gaps.shape))
        rows, columns = np.nonzero(gaps)
        at = (rows // part, columns // part)
        taken = (confidence[at] >= settings.least) & ~np.isnan(guess[at])
        inverse, sure = depth.inverse_depth.copy(), depth.confidence.copy()
        inverse[gaps] = np.where(taken, guess[at], np.float32(np.nan))
        sure[gaps] = np.where(taken, np.clip(confidence[at], LEAST_SURE, MOST_SURE), np.float32(0))
        return MeasuredDepth(inverse, sure)


def _reduced(colour: Pixels, inverse: Pixels, part: int) -> tuple[Pixels, Pixels]:
    # The depth is the one nearest to their mean, never a mixture.
    if part == 1:
        return colour, inverse
    high, wide = inverse.shape
    over = ((0, -high % part), (0, -wide % part))
    colours = np.pad(colour, (*over, (0, 0)), mode="edge")
    blocks = np.pad(inverse, over, constant_values=np.nan)
    corners = [(slice(row, None, part), slice(column, None, part)) for row in range(part) for column in range(part)]
    depths = np.stack([blocks[corner] for corner in corners])
    unknown = np.isnan(depths)
    mean = np.where(unknown, 0, depths).sum(axis=0) / np.maximum(part * part - unknown.sum(axis=0), 1)
    nearest = np.where(unknown, np.inf, np.abs(depths - mean)).argmin(axis=0)
    mean_colour = np.add.reduce([colours[corner] for corner in corners]) / np.float32(part * part)
    return mean_colour, np.take_along_axis(depths, nearest[None], axis=0)[0]


def _closed(colour: Pixels, inverse: Pixels, settings: _CompleteSettings, pixel: float) -> tuple[Pixels, Pixels]:
    """Return inverse depth without gaps, and confidence. pixel: its share of the longer side."""
    known = ~np.isnan(inverse)
    confidence = known.astype(np.float32)
    gaps = np.flatnonzero(~known)
    if len(gaps) == 0:
        return inverse, confidence
    colours, depths = colour.reshape(-1, 3), inverse.ravel()
    proposed, weights, distances = [], [], []
    for there, distance in _nearest_known(known, gaps):
        found = there >= 0
        unlike = ((colours[there] - colours[gaps]) ** 2).sum(axis=1)
        alike = np.exp(unlike * np.float32(-0.5 / settings.colour**2)) + np.float32(_UNLIKE)
        proposed.append(np.where(found, depths[there], np.float32(0)))
        weights.append(np.where(found, alike / (distance * distance), np.float32(0)))
        distances.append(distance)
    values, weight, away = np.stack(proposed), np.stack(weights), np.stack(distances)
    support = weight.copy()  # of each proposal, by those of the same surface
    for index in range(len(values)):
        for other in range(index + 1, len(values)):
            same = ~settings.apart(values[index], values[other])
            support[index] += same * weight[other]
            support[other] += same * weight[index]
    support[weight == 0] = -1
    best = np.take_along_axis(values, support.argmax(axis=0)[None], axis=0)[0]
    belongs = ~settings.apart(values, best) & (weight > 0)
    share, total = (weight * belongs).sum(axis=0), weight.sum(axis=0)
    nearest = np.where(belongs, away, np.inf).min(axis=0) * np.float32(pixel / settings.reach)
    with np.errstate(invalid="ignore", divide="ignore"):  # nothing known in any direction: NaN, and 0
        guess = (weight * belongs * values).sum(axis=0) / share
        sure = np.where(total > 0, share / total * np.exp2(-nearest * nearest), np.float32(0))
    depths, sureness = depths.copy(), confidence.ravel()
    depths[gaps], sureness[gaps] = guess, sure
    return depths.reshape(inverse.shape), sureness.reshape(inverse.shape)


def _nearest_known(known: NDArray[np.bool_], gaps: NDArray[np.intp]) -> Iterator[tuple[NDArray[np.intp], Pixels]]:
    """Return the first known pixel, -1 for none, in eight directions, and how many pixels away."""
    high, wide = known.shape
    rows, columns = np.divmod(gaps, wide)
    for found in _up_and_down(known, rows, columns):
        yield np.where(found >= 0, found * wide + columns, -1), np.abs(found - rows).astype(np.float32)
    for found in _up_and_down(known.T, columns, rows):
        yield np.where(found >= 0, rows * wide + found, -1), np.abs(found - columns).astype(np.float32)
    lines, places = np.arange(high)[:, None], np.arange(wide)[None, :]
    for sign in (1, -1):
        # Each row pushed one pixel farther than the one above: diagonals stand upright.
        pushed = lines if sign == 1 else high - 1 - lines
        upright = np.zeros((high, high + wide - 1), bool)
        upright[lines, places + pushed] = known
        for found in _up_and_down(upright, rows, columns + pushed[rows, 0]):
            there = found * wide + columns + sign * (rows - found)
            yield np.where(found >= 0, there, -1), np.abs(found - rows).astype(np.float32) * _DIAGONAL


def _up_and_down(
    known: NDArray[np.bool_], rows: NDArray[np.intp], columns: NDArray[np.intp]
) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Return the row of the first known pixel above and below each place, -1 for none."""
    line = np.arange(len(known), dtype=np.int32)[:, None]
    above, under = (np.maximum.accumulate(np.where(one, line, np.int32(-1)), axis=0) for one in (known, known[::-1]))
    found = (len(known) - 1 - under[::-1])[rows, columns]
    return above[rows, columns], np.where(found < len(known), found, -1)
