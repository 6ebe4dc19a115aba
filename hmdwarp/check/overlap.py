"""How well frames agree under a reading, and the numbers with which they agree best."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from .stated_frames import METRES, Array, Reading, Sheet, Stated

Indices = NDArray[np.int64]
TILES = 3  # a side: parts of a picture that err together
FACTOR, OFFSET, ALONG, LATE = "factor", "offset", "along", "late_s"
PIXEL_X, PIXEL_Y, WIDE_X, WIDE_Y = "pixel_x", "pixel_y", "wide_x", "wide_y"
WIDE = "wide"  # both WIDE_X and WIDE_Y by one factor: pixels are as square as stated
# Of faults that are no convention.
TURN, BEND, DEPTH_WIDE, DEPTH_SHIFT = ("turn_x", "turn_y", "turn_z"), "bend", "depth_wide", ("depth_x", "depth_y")
LOGARITHMS = (FACTOR, WIDE_X, WIDE_Y, WIDE, DEPTH_WIDE)  # fitted as such
_ROUNDS = 5
_CUT = 6.0  # standard deviations: what disagrees more is no evidence of how much
_CHANCE = 0.8  # of the worst disagreement: what points have that meet by chance, and those out of view
_SMALL = 1e-9
_LOOSE = 1000  # small differences: how far a number may lie from where it started, without evidence
_DEPTH, _COLOUR = 0.04, 0.7  # differences that count half: of the depth; of the brightness, in its deviation


@attrs.frozen(eq=False)
class Residuals:
    """Of all points, (pairs, points); NaN where there is nothing to compare."""

    depth: Array  # relative difference of the inverse depths
    colour: Array  # difference of the brightness
    brightness: Array  # of the one frame; the other has `colour` more
    seen: NDArray[np.bool_]  # whether the point lies in the other picture
    sky: NDArray[np.bool_]  # whether both frames have it infinitely far
    pixel: Array  # (pairs, points, 2) where, in pixels


def _median(values: Array, default: float) -> float:
    known = values[~np.isnan(values)]
    return float(np.median(known)) if len(known) else default


class Overlap:
    """Points of frames, each with the frame in which it is looked up.

    pairs: (p, 2) from frame, in frame. points: how many a pair, None for every pixel. between:
    whether depth is interpolated, on surfaces alone, or that of the nearest pixel.
    """

    def __init__(self, stated: Stated, sheet: Sheet, pairs: Indices, points: int | None, *, between: bool) -> None:
        self.stated, self.sheet, self._between = stated, sheet, between
        self.pairs = pairs
        self._height, self._width = sheet.numbers.shape[1:]
        self._per_pixel = stated.frames[0].depth.shape[1] // self._width
        # Random pixels with depth, the same at each call; on surfaces between pixels, where noise
        # does not depend on a shift of the depth.
        rng, sides = np.random.default_rng(0), np.array([self._height, self._width])
        wanted = np.isfinite(sheet.inverse) & sheet.smooth if between else ~np.isnan(sheet.numbers)
        chosen = np.tile(np.arange(sides.prod()), (len(pairs), 1))
        if points is not None:
            known = [
                np.flatnonzero(wanted[one] if wanted[one].any() else ~np.isnan(sheet.numbers[one]))
                for one in pairs[:, 0]
            ]
            chosen = np.array([rng.choice(one, points, replace=len(one) < points) for one in known])
        at = np.stack(np.divmod(chosen, self._width))
        self.row, self.column = np.minimum(at + rng.random(at.shape) * between, sides[:, None, None] - 1)
        self._from, self._to = pairs[:, :1], pairs[:, 1:]
        row, column = at * TILES // sides[:, None, None]
        self.block = (np.arange(len(pairs))[:, None] * TILES + row) * TILES + column
        self.blocks = len(pairs) * TILES**2

    def residuals(self, reading: Reading) -> Residuals:
        """Return how each point disagrees with what the other frame has there."""
        turn, place = reading.poses(self.stated)
        one, other = self.pairs.T
        back = turn[other].transpose(0, 2, 1)
        across = np.einsum("pij,pj->pi", back, place[one] - place[other])
        base = self.sheet.inverse if reading.kind == METRES else self.sheet.numbers
        row = self._height - 1 - self.row if reading.depth_rows_up else self.row
        x, y = self._tangent(self.column, row, self._from, reading)
        numbers = self._picture_at(base, *self._in_depth(self.column, self.row, reading), self._from)
        apart = np.exp(reading.scales or np.zeros(len(self.stated.frames)))
        inverse = reading.inverse_depth(numbers, np.sqrt(1 + x * x + y * y)) * apart[self._from]
        ahead = np.stack([x, y, -np.ones_like(x)], axis=-1)
        moved = ahead @ (back @ turn[one]).transpose(0, 2, 1) + inverse[..., None] * across[:, None]
        w = -moved[..., 2]
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y, expected = moved[..., 0] / w, moved[..., 1] / w, inverse / w
        column, line = self._pixel(x, y, self._to, reading)
        with np.errstate(invalid="ignore"):
            seen = (w > 1e-6) & (column >= 0) & (column <= self._width - 1) & (line >= 0) & (line <= self._height - 1)
            seen &= inverse >= -1e-9
        column, line = np.where(seen, column, 0), np.where(seen, line, 0)
        there = self._in_depth(column, self._height - 1 - line if reading.depth_rows_up else line, reading)
        sampled = self._picture_at(base, *there, self._to)
        if self._between:
            smooth = self.sheet.smooth[self._to, there[1].astype(int), there[0].astype(int)]
            sampled = np.where(smooth, sampled, np.nan)
        ray = np.sqrt(1 + np.where(seen, x * x + y * y, 0))
        # Compared as numbers that were measured: what a fit may change must not change their noise.
        size = np.abs(sampled - reading.end)
        # In its own size and, so that what is far counts less, that of the median without the sky.
        with np.errstate(invalid="ignore", divide="ignore"):
            depth = reading.base(expected / apart[self._to], ray) - sampled
            depth /= 0.5 * (size + _median(size[size > 0], 1.0))
        source, target = (self._height - 1 - index for index in (row, line)) if reading.colour_rows_up else (row, line)
        pictured = self._picture_at(self.sheet.picture, column, target, self._to)
        here = self._picture_at(self.sheet.picture, self.column, source, self._from)
        colour = pictured - here
        pixel = np.stack([column, line], -1)
        sky = seen & (size == 0) & (depth == 0)
        return Residuals(np.where(seen, depth, np.nan), np.where(seen, colour, np.nan), here, seen, sky, pixel)

    def score(self, reading: Reading) -> Array:
        """Return the agreement of each point, 0 to 1; NaN where nothing can be said."""
        found = self.residuals(reading)
        with np.errstate(invalid="ignore"):
            score = 1 / ((1 + (found.depth / _DEPTH) ** 2) * (1 + (found.colour / _COLOUR) ** 2))
        return np.where(found.seen, score, 0)

    def _tangent(self, column: Indices, row: Indices, frame: Indices, reading: Reading) -> tuple[Array, Array]:
        left, right, down, up = self.stated.tangents[frame].transpose(2, 0, 1)
        x = left + (column + 0.5 + reading.pixel_x / self._per_pixel) / self._width * (right - left)
        y = up - (row + 0.5 + reading.pixel_y / self._per_pixel) / self._height * (up - down)
        x, y = x * reading.wide_x, y * reading.wide_y
        bent = 1 + reading.bend * (x * x + y * y) if reading.bend else 1.0
        return x * bent, y * bent

    def _in_depth(self, column: Array, line: Array, reading: Reading) -> tuple[Array, Array]:
        """Return where the picture of depth has these pixels of the colour's."""
        if reading.depth_wide == 1 and not (reading.depth_x or reading.depth_y):
            return column, line
        (x, y), wide = ((self._width - 1) / 2, (self._height - 1) / 2), reading.depth_wide
        column = (column - x) / wide + x + reading.depth_x / self._per_pixel
        line = (line - y) / wide + y + reading.depth_y / self._per_pixel
        return column.clip(0, self._width - 1), line.clip(0, self._height - 1)

    def _pixel(self, x: Array, y: Array, frame: Indices, reading: Reading) -> tuple[Array, Array]:
        left, right, down, up = self.stated.tangents[frame].transpose(2, 0, 1)
        bent = 1 + reading.bend * (x * x + y * y) if reading.bend else 1.0
        x, y = x / bent / reading.wide_x, y / bent / reading.wide_y
        column: Array = (x - left) / (right - left) * self._width - 0.5 - reading.pixel_x / self._per_pixel
        line: Array = (up - y) / (up - down) * self._height - 0.5 - reading.pixel_y / self._per_pixel
        return column, line

    def _picture_at(self, pictures: Array, column: Array, line: Array, frame: Indices) -> Array:
        """Return the values at those places: of the nearest pixel, or between pixels."""
        if not self._between:
            found: Array = pictures[frame, np.rint(line).astype(int), np.rint(column).astype(int)]
            return found
        left = np.clip(column.astype(int), 0, self._width - 2)
        top = np.clip(line.astype(int), 0, self._height - 2)
        x, y = column - left, line - top
        upper = pictures[frame, top, left] * (1 - x) + pictures[frame, top, left + 1] * x
        lower = pictures[frame, top + 1, left] * (1 - x) + pictures[frame, top + 1, left + 1] * x
        return np.asarray(upper * (1 - y) + lower * y)

    def by_block(self, values: Array) -> tuple[Array, Array]:
        """Return the sum of values in each block, and how many there are; NaN does not count."""
        known = ~np.isnan(values)
        sums = np.bincount(self.block[known], values[known], self.blocks).astype(np.float64)
        return sums, np.bincount(self.block[known], minlength=self.blocks).astype(np.float64)


@attrs.frozen(eq=False)
class Fitted:
    """A reading, and how well each fitted number is known; by default none is."""

    reading: Reading
    names: tuple[str, ...] = ()
    # Standard error of each, inf where the frames say nothing.
    error: Array = attrs.field(factory=lambda: np.empty(0))


@attrs.frozen
class Noise:
    """Deviations of what agrees."""

    depth: float
    colour: float

    @classmethod
    def of(cls, found: Residuals) -> Noise:
        """Return those of residuals: from their medians, which outliers do not move.

        Sky on sky, which agrees under many readings, tells nothing of it.
        """
        both = (np.abs(differences[~found.sky]) for differences in (found.depth, found.colour))
        return cls(*(max(1.48 * _median(one, math.inf), 1e-4) for one in both))


def cost(found: Residuals, noise: Noise) -> Array:
    """Return the disagreement of each point, NaN where nothing can be said."""
    with np.errstate(invalid="ignore"):
        each = [
            np.log1p(np.minimum(one / deviation, _CUT) ** 2)
            for one, deviation in ((np.abs(found.depth), noise.depth), (np.abs(found.colour), noise.colour))
        ]
    worst = math.log1p(_CUT**2)
    return np.where(found.seen, np.where(np.isnan(each[0]), worst, each[0]) + each[1], 2 * _CHANCE * worst)


def changed(reading: Reading, names: Sequence[str], change: Sequence[float]) -> Reading:
    """Return the reading with other numbers."""
    values: dict[str, Any] = {
        each: getattr(reading, each) * math.exp(one) if name in LOGARITHMS else getattr(reading, each) + one
        for name, one in zip(names, change, strict=True)
        for each in ((WIDE_X, WIDE_Y) if name == WIDE else (name,))
    }
    return attrs.evolve(reading, **values)


def fit(overlap: Overlap, start: Reading, steps: dict[str, float]) -> Fitted:
    """Return the reading for which points agree best.

    steps: of each number that is fitted, a small difference, by which slopes are taken.
    Source: iteratively reweighted least squares; its error by the sandwich formula over blocks,
    whose points err together (White 1980; Liang and Zeger 1986).
    """
    names, change = tuple(steps), np.zeros(len(steps))
    small = np.array(list(steps.values()))
    limit = 60 * small
    prior = np.diag(1 / (_LOOSE * small) ** 2)  # holds what the frames say nothing of
    hessian, spread = np.eye(len(names)), np.eye(len(names))
    for _ in range(_ROUNDS):
        reading = changed(start, names, change.tolist())
        found = overlap.residuals(reading)
        noise = Noise.of(found)
        hessian, spread = prior.copy(), np.zeros((overlap.blocks, len(names)))
        down = prior @ change
        slopes = [overlap.residuals(changed(reading, [name], [1e-3 * steps[name]])) for name in names]
        for kind in ("depth", "colour"):
            deviation = getattr(noise, kind)
            values = getattr(found, kind) / deviation
            slope = np.stack([(getattr(slope, kind) / deviation - values) for slope in slopes], -1) / (1e-3 * small)
            with np.errstate(invalid="ignore"):
                usable = np.isfinite(values) & np.isfinite(slope).all(axis=-1) & (np.abs(values) < _CUT)
            value, slope, block = values[usable], slope[usable], overlap.block[usable]
            weighted = slope / (1 + value**2)[:, None]
            hessian += weighted.T @ slope
            pull = weighted * value[:, None]
            down += pull.sum(axis=0)
            for column in range(len(names)):
                spread[:, column] += np.bincount(block, pull[:, column], overlap.blocks)
        scale = np.sqrt(np.diag(hessian)) + _SMALL
        step = -np.linalg.solve(hessian / np.outer(scale, scale) + 1e-6 * np.eye(len(names)), down / scale) / scale
        change += np.clip(step, -limit, limit)
        if (np.abs(step) < 0.05 * small).all():
            break
    inverse = np.linalg.pinv(hessian)
    error = np.sqrt(np.diag(inverse @ (spread.T @ spread + prior) @ inverse))
    error = np.where(np.diag(hessian - prior) * small**2 > _SMALL, error, math.inf)
    return Fitted(changed(start, names, change.tolist()), names, error)
