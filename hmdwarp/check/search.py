"""How well frames agree under a reading, and the search for the one under which they do."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from .conventions import differences
from .stated_frames import AXES, BUFFER, METRES, Array, Reading, Sheet, Stated

Indices = NDArray[np.int64]
Place = tuple[float, float]
_TILES = 3  # a side: parts of a picture that err together
WIDE = "wide"  # both wide_x and wide_y by one factor: pixels are as square as stated
TURN, DEPTH_SHIFT = ("turn_x", "turn_y", "turn_z"), ("depth_x", "depth_y")  # of faults that are no convention
LOGARITHMS = ("factor", "wide_x", "wide_y", WIDE, "depth_wide")  # fitted as such
_ROUNDS = 5
_SHARED = 64  # of what is known of readings, kept
_CUT = 6.0  # standard deviations: what disagrees more is no evidence of how much
_CHANCE = 0.8  # of the worst disagreement: what points have that meet by chance, and those out of view
_SMALL = 1e-9
_LOOSE = 1000  # small differences: how far a number may lie from where it started, without evidence
_DEPTH, _COLOUR = 0.04, 0.7  # differences that count half: of the depth; of the brightness, in its deviation


@attrs.frozen(eq=False)
class _Residuals:
    """Of all points, (pairs, points); NaN where there is nothing to compare."""

    depth: Array  # relative difference of the inverse depths
    colour: Array  # difference of the brightness
    brightness: Array  # of the one frame; the other has `colour` more
    seen: NDArray[np.bool_]  # whether the point lies in the other picture
    sky: NDArray[np.bool_]  # whether both frames have it infinitely far
    column: Array  # where, in pixels
    line: Array


def _median(values: Array, default: float) -> float:
    known = values[~np.isnan(values)]
    if not (half := len(known) // 2):
        return float(known[0]) if len(known) else default
    known.partition(half)  # np.median takes four times as long
    return float(known[half] if len(known) % 2 else (known[:half].max() + known[half]) / 2)


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
        row, column = at * _TILES // sides[:, None, None]
        self.block = (np.arange(len(pairs))[:, None] * _TILES + row) * _TILES + column
        self.blocks = len(pairs) * _TILES**2
        # Readings come again, and share brightness, depth and rays of the points.
        kept = lru_cache(_SHARED)
        self.residuals, self._rays = kept(self._residuals_of), kept(self._rays_of)
        self._brightness, self._numbers = kept(self._brightness_of), kept(self._numbers_of)

    def _residuals_of(self, reading: Reading) -> _Residuals:
        """Return how each point disagrees with what the other frame has there."""
        turn, place = reading.poses(self.stated)
        one, other = self.pairs.T
        back = turn[other].transpose(0, 2, 1)
        across = np.einsum("pij,pj->pi", back, place[one] - place[other])
        shift = reading.depth_wide, reading.depth_x, reading.depth_y
        colour_up, depth_up = reading.colour_rows_up, reading.depth_rows_up
        base = self.sheet.inverse if reading.kind == METRES else self.sheet.numbers
        here, numbers = self._brightness(colour_up, depth_up), self._numbers(reading.kind, shift)
        pixel, wide = (reading.pixel_x, reading.pixel_y), (reading.wide_x, reading.wide_y)
        ahead, ray = self._rays(depth_up, pixel, wide, reading.bend)
        inverse, apart = reading.inverse_depth(numbers, ray), np.exp(reading.scales)
        if reading.scales:
            inverse = inverse * apart[self._from]
        turned = (ahead @ (back @ turn[one]).transpose(0, 2, 1)).transpose(2, 0, 1)
        x, y, z = (ray_part + inverse * way[:, None] for ray_part, way in zip(turned, across.T, strict=True))
        w = -z
        left, right, down, up = self.stated.tangents[self._to].transpose(2, 0, 1)
        with np.errstate(divide="ignore", invalid="ignore"):
            x, y, expected = x / w, y / w, inverse / w
            bent = 1 + reading.bend * (x * x + y * y) if reading.bend else 1.0
            across_x, across_y = x / bent / wide[0], y / bent / wide[1]
            column = (across_x - left) / (right - left) * self._width - 0.5 - pixel[0] / self._per_pixel
            line = (up - across_y) / (up - down) * self._height - 0.5 - pixel[1] / self._per_pixel
            seen = (w > 1e-6) & (column >= 0) & (column <= self._width - 1) & (line >= 0) & (line <= self._height - 1)
            seen &= inverse >= -1e-9
        column, line = np.where(seen, column, 0), np.where(seen, line, 0)
        there, target = self._in_depth(column, self._turned(line, depth_up), shift), self._turned(line, colour_up)
        if there[0] is column and colour_up == depth_up:  # one place in both pictures
            sampled, pictured = self._values(self._to, *there, base, self.sheet.picture)
        else:
            (sampled,) = self._values(self._to, *there, base)
            (pictured,) = self._values(self._to, column, target, self.sheet.picture)
        if self._between:
            at = (self._to * self._height + there[1].astype(np.intp)) * self._width + there[0].astype(np.intp)
            sampled = np.where(self.sheet.smooth.take(at), sampled, np.nan)
        # Compared as numbers that were measured: what a fit may change must not change their noise.
        size = np.abs(sampled - reading.end)
        # In its own size and, so that what is far counts less, that of the median without the sky.
        with np.errstate(invalid="ignore", divide="ignore"):
            ray = np.sqrt(1 + np.where(seen, x * x + y * y, 0)) if reading.along else ray
            depth = reading.base(expected / apart[self._to] if reading.scales else expected, ray) - sampled
            depth /= 0.5 * (size + _median(size[size > 0], 1.0))
        colour, sky = pictured - here, seen & (size == 0) & (depth == 0)
        return _Residuals(np.where(seen, depth, np.nan), np.where(seen, colour, np.nan), here, seen, sky, column, line)

    def score(self, reading: Reading) -> Array:
        """Return the agreement of each point, 0 to 1; NaN where nothing can be said."""
        found = self.residuals(reading)
        with np.errstate(invalid="ignore"):
            score = 1 / ((1 + (found.depth / _DEPTH) ** 2) * (1 + (found.colour / _COLOUR) ** 2))
        return np.where(found.seen, score, 0)

    def _brightness_of(self, colour_up: bool, depth_up: bool) -> Array:
        line = self._turned(self._turned(self.row, depth_up), colour_up)
        return self._values(self._from, self.column, line, self.sheet.picture)[0]

    def _numbers_of(self, kind: str, shift: tuple[float, float, float]) -> Array:
        base = self.sheet.inverse if kind == METRES else self.sheet.numbers
        return self._values(self._from, *self._in_depth(self.column, self.row, shift), base)[0]

    def _rays_of(self, depth_up: bool, pixel: Place, wide: Place, bend: float) -> tuple[Array, Array]:
        """Return (pairs, points, 3) rays to the plane z = -1, and their lengths."""
        left, right, down, up = self.stated.tangents[self._from].transpose(2, 0, 1)
        x = left + (self.column + 0.5 + pixel[0] / self._per_pixel) / self._width * (right - left)
        y = up - (self._turned(self.row, depth_up) + 0.5 + pixel[1] / self._per_pixel) / self._height * (up - down)
        x, y = x * wide[0], y * wide[1]
        bent = 1 + bend * (x * x + y * y) if bend else 1.0
        x, y = x * bent, y * bent
        return np.stack([x, y, -np.ones_like(x)], axis=-1), np.sqrt(1 + x * x + y * y)

    def _turned(self, line: Array, is_up: bool) -> Array:
        return self._height - 1 - line if is_up else line

    def _in_depth(self, column: Array, line: Array, shift: tuple[float, float, float]) -> tuple[Array, Array]:
        """Return where the picture of depth has these pixels of the colour's."""
        if shift == (1, 0, 0):
            return column, line
        (x, y), (wide, right, down) = ((self._width - 1) / 2, (self._height - 1) / 2), shift
        column = (column - x) / wide + x + right / self._per_pixel
        line = (line - y) / wide + y + down / self._per_pixel
        return column.clip(0, self._width - 1), line.clip(0, self._height - 1)

    def _values(self, frame: Indices, column: Array, line: Array, *pictures: Array) -> list[Array]:
        """Return values of pictures at those places: of the nearest pixel, or between pixels."""
        if not self._between:
            at = ((frame * self._height + np.rint(line)) * self._width + np.rint(column)).astype(np.intp)
            return [picture.take(at) for picture in pictures]
        left = np.minimum(column.astype(np.intp), self._width - 2)
        top = np.minimum(line.astype(np.intp), self._height - 2)
        at, x, y = (frame * self._height + top) * self._width + left, column - left, line - top
        after, below, before_x, before_y = at + 1, at + self._width, 1 - x, 1 - y
        corners, found = (at, after, below, below + 1), []
        for picture in pictures:
            first, second, third, fourth = (picture.take(place) for place in corners)
            found.append((first * before_x + second * x) * before_y + (third * before_x + fourth * x) * y)
        return found

    def by_block(self, values: Array) -> Array:
        """Return the sum of values in each block; NaN does not count."""
        known = ~np.isnan(values)
        return np.bincount(self.block[known], values[known], self.blocks).astype(np.float64)


# The deviations of what agrees, of depth and of brightness; a reading with the standard error of
# each fitted number, inf where the frames say nothing.
Noise = tuple[float, float]
Fitted = tuple[Reading, dict[str, float]]


def noise_of(found: _Residuals) -> Noise:
    """Return the noise from medians, which outliers do not move.

    Sky on sky, which agrees under many readings, tells nothing of it.
    """
    both = (np.abs(apart[~found.sky]) for apart in (found.depth, found.colour))
    depth, colour = (max(1.48 * _median(one, math.inf), 1e-4) for one in both)
    return depth, colour


def cost(found: _Residuals, noise: Noise) -> Array:
    """Return the disagreement of each point, NaN where nothing can be said."""
    with np.errstate(invalid="ignore"):
        each = [
            np.log1p(np.minimum(one / deviation, _CUT) ** 2)
            for one, deviation in zip((np.abs(found.depth), np.abs(found.colour)), noise, strict=True)
        ]
    worst = math.log1p(_CUT**2)
    return np.where(found.seen, np.where(np.isnan(each[0]), worst, each[0]) + each[1], 2 * _CHANCE * worst)


def changed(reading: Reading, names: Sequence[str], change: Sequence[float]) -> Reading:
    """Return the reading with other numbers."""
    values: dict[str, Any] = {
        each: getattr(reading, each) * math.exp(one) if name in LOGARITHMS else getattr(reading, each) + one
        for name, one in zip(names, change, strict=True)
        for each in (("wide_x", "wide_y") if name == WIDE else (name,))
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
        noise = noise_of(found)
        hessian, spread = prior.copy(), np.zeros((overlap.blocks, len(names)))
        down = prior @ change
        slopes = [overlap.residuals(changed(reading, [name], [1e-3 * steps[name]])) for name in names]
        for kind, deviation in zip(("depth", "colour"), noise, strict=True):
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
    return changed(start, names, change.tolist()), dict(zip(names, error.tolist(), strict=True))


PAIRS, _COARSE_POINTS, FINE_POINTS = 16, 160, 400  # compared pairs of frames; points of each
SURE = 3.5  # standard errors by which the better of two readings has to be better
_LONG = 8  # frames of a track whose ends are not compared
_FEWEST = 4  # blocks that say something together
_STEP = 1.25  # from one factor of the grid to the next
_PARALLAX_PX = (0.3, 100.0)  # in pictures of COARSE_PX: less says nothing, more would be no picture
# Inverse depth of the far plane, and of the farthest pixel, over what the median pixel has more.
_FARTHEST, _FARTHEST_SEEN = (0.0, 0.1, 0.3), (0.0, 0.5, 1.0, 2.0, 4.0, 8.0)
_LATE_SHARES = (-0.8, -0.4, 0.4, 0.8)  # instants of the picture after the pose's, in frames
_WIDE = (0.58, 0.69, 0.83, 1.2, 1.44, 1.73)  # tangents over those stated
_CENTRES = (-0.15, -0.05, 0.0, 0.05, 0.15)  # places of the principal point, of a side
_FAR_CENTRE = 0.2  # of a side from the middle: intrinsics of another size of picture
_OTHER_SIZE = tuple(map(float, np.geomspace(0.4, 2.5, 16)))  # factors of the field of view then
_OFFSETS = (-0.6, -0.3, -0.15, 0.15, 0.3, 0.6)  # of the inverse depth, in its median


@attrs.frozen(eq=False)
class Candidate:
    """A reading, and how it does on the fine pictures."""

    reading: Reading
    error: dict[str, float]  # as Fitted has them
    cost: Array  # of each block
    total: float  # of all blocks
    changes: int  # conventions that differ from what is stated


class Search:
    """Frames, and what is known of the readings that were tried."""

    def __init__(self, stated: Stated) -> None:
        self.stated = stated
        is_long = min(map(len, stated.tracks)) >= _LONG  # its ends are not compared
        ends = {int(track[end]) for track in stated.tracks for end in (0, -1)} if is_long else set()
        frames = [k for k in range(len(stated.frames)) if k not in ends]
        # Near and far from each other, each way round in turn.
        every = sorted(itertools.combinations(range(len(frames)), 2), key=lambda pair: (pair[1] - pair[0], pair[0]))
        every = [pair for pair in every if pair[1] - pair[0] <= max(8, len(frames) // 2)]
        chosen = [every[round(place)] for place in np.linspace(0, len(every) - 1, min(PAIRS, len(every)))]
        chosen *= 2 if len(chosen) == 1 else 1
        pairs = np.array([[frames[at] for at in pair[:: 1 if k % 2 else -1]] for k, pair in enumerate(chosen)])
        points = max(1, PAIRS // len(pairs))
        self.coarse = Overlap(stated, stated.coarse, pairs, _COARSE_POINTS * points, between=False)
        self.middle = Overlap(stated, stated.coarse, pairs, FINE_POINTS * points, between=True)
        same = stated.coarse.numbers.shape == stated.fine.numbers.shape
        self.fine = self.middle if same else Overlap(stated, stated.fine, pairs, FINE_POINTS * points, between=True)
        self.score, self._middle = lru_cache(None)(self._score_of), lru_cache(None)(self._middle_of)
        self._low = float(np.percentile(_near(stated.coarse.inverse), 5))
        self._fits: dict[tuple[Reading, tuple[str, ...]], Fitted] = {}

    def _score_of(self, reading: Reading) -> float:
        """Return the agreement on the coarse pictures, 0 to 1."""
        score = self.coarse.score(reading)
        return float(self.coarse.by_block(score).sum() / max((~np.isnan(score)).sum(), 1))

    def best(self, readings: Sequence[Reading]) -> Reading:
        """Return that of the highest agreement, the first of equals."""
        return max(readings, key=self.score)

    # What may be otherwise, one convention at a time.

    def discrete(self, start: Reading) -> Iterator[Reading]:
        """Yield the reading with one convention that has no number changed."""
        yield attrs.evolve(start, order="wxyz" if start.order == "xyzw" else "xyzw")
        yield attrs.evolve(start, inverse=not start.inverse)
        yield from (attrs.evolve(start, axes=name) for name in AXES if name != start.axes)
        if self.stated.other_eye is not None:
            yield attrs.evolve(start, eyes_swapped=not start.eyes_swapped)
        for colour, depth in itertools.product((False, True), repeat=2):
            if (colour, depth) != (start.colour_rows_up, start.depth_rows_up):
                yield attrs.evolve(start, colour_rows_up=colour, depth_rows_up=depth)
        if start.along == 0:
            yield attrs.evolve(start, along=1.0)

    def numbers(self, start: Reading, *, usual: bool = False) -> list[list[Reading]]:
        """Return readings of depth in other units, and of depth buffers; a list for each kind.

        And, but for `usual` ones, of distances that were made of a buffer with other planes.
        """
        base = _near(self.stated.coarse.inverse)
        middle, most = float(np.median(base)), float(np.percentile(base, 99.9))
        ways = [[attrs.evolve(start, factor=factor) for factor in self._factors(start, middle)]]
        if self.stated.may_be_buffer:
            for end, sign in ((1.0, -1.0), (-1.0 if self.stated.signed else 0.0, 1.0)):
                apart = float(np.median(np.abs(_near(self.stated.coarse.numbers - end))))
                ways.append(self._encoded(attrs.evolve(start, kind=BUFFER, end=end), sign, apart, _FARTHEST))
        if usual:
            return ways
        if not self.stated.may_be_buffer:  # near 1 a buffer and one over it differ by a plane
            both = itertools.product(_OFFSETS, (0.7, 1.0, 1.4))
            ways.append([attrs.evolve(start, offset=share * middle, factor=factor) for share, factor in both])
        return [*ways, self._encoded(attrs.evolve(start, end=most), -1.0, most - middle, _FARTHEST_SEEN)]

    def _encoded(self, start: Reading, sign: float, middle: float, farthest: Sequence[float]) -> list[Reading]:
        """Return readings whose inverse depth rises from that of the far plane or pixel."""
        return [
            attrs.evolve(start, factor=sign * factor, offset=factor * far * middle)
            for factor in (self._factors(start, middle) if middle > 0 else ())
            for far in farthest
        ]

    def late(self, start: Reading) -> list[Reading]:
        """Return the reading with pictures of other instants than their poses."""
        interval_s = self.stated.interval_s
        return [attrs.evolve(start, late_s=share * interval_s) for share in _LATE_SHARES] if interval_s else []

    def cameras(self, start: Reading) -> list[list[Reading]]:
        """Return the reading with other focal lengths, and with other principal points.

        And, where the stated one is far from the middle of the picture, as intrinsics of another
        size are, with one in the middle and other focal lengths.
        """
        height, width = self.stated.frames[0].depth.shape
        wide = [(x, y) for share in _WIDE for x, y in ((share, share), (share, 1.0), (1.0, share))]
        centres = [(x, y) for x, y in itertools.product(_CENTRES, repeat=2) if x or y]
        left, right, down, up = self.stated.tangents[0]
        off_x, off_y = -left / (right - left) - 0.5, up / (up - down) - 0.5
        centred = attrs.evolve(start, pixel_x=off_x * width, pixel_y=off_y * height)
        ways = [
            [attrs.evolve(start, wide_x=start.wide_x * x, wide_y=start.wide_y * y) for x, y in wide],
            [attrs.evolve(start, pixel_x=x * width, pixel_y=y * height) for x, y in centres],
        ]
        if max(abs(off_x), abs(off_y)) > _FAR_CENTRE:
            ways.append([attrs.evolve(centred, wide_x=share, wide_y=share) for share in _OTHER_SIZE])
        return ways

    def _factors(self, start: Reading, middle: float) -> list[float]:
        """Return factors that give `middle` an inverse depth at which pictures shift visibly."""
        place = start.poses(self.stated)[1]
        # How far the eye moves between two compared frames.
        moved = float(np.median(np.linalg.norm(np.diff(place[self.coarse.pairs], axis=1), axis=-1)))
        if not moved > 0:
            return []
        left, right = self.stated.tangents[0, :2]
        per_tangent = self.stated.coarse.numbers.shape[2] / (right - left)
        low, high = (pixels / (per_tangent * moved * middle) for pixels in _PARALLAX_PX)
        return list(map(float, np.geomspace(low, high, math.ceil(math.log(high / low) / math.log(_STEP)))))

    def sharpened(self, reading: Reading) -> Reading:
        """Return the reading with the factor, and offset, for which coarse pictures agree best."""
        for step in (1.12, 1.05, 1.02):
            numbers = ((reading.factor * by, reading.offset * by) for by in (1 / step, step))
            reading = self.best([reading, *(attrs.evolve(reading, factor=a, offset=b) for a, b in numbers)])
        return reading

    # What has a number that the fine pictures tell.

    def farthest(self, reading: Reading) -> float:
        """Return the inverse depth that all but a few pixels exceed, without the offset."""
        return abs(self._low * reading.factor)

    def steps(self, reading: Reading) -> dict[str, float]:
        """Return the numbers that may be fitted, each with a small difference."""
        # What the inverse depth of the median pixel is over that of the farthest.
        span = abs(self._middle(reading.kind, reading.end) * reading.factor)
        steps = {"factor": 1e-3, "offset": 1e-3 * span, "along": 0.02, "pixel_x": 0.05, "pixel_y": 0.05}
        steps |= {"wide_x": 2e-3, "wide_y": 2e-3, WIDE: 2e-3, "depth_wide": 2e-3, "bend": 5e-3}
        steps |= {**dict.fromkeys(TURN, 1e-3), **dict.fromkeys(DEPTH_SHIFT, 0.05)}
        if self.stated.interval_s is not None:
            steps["late_s"] = 0.05 * self.stated.interval_s
        return steps

    def _middle_of(self, kind: str, end: float) -> float:
        base = self.stated.coarse.inverse if kind == METRES else self.stated.coarse.numbers
        return float(np.median(_near(base - end)))

    def fitted(self, start: Reading, names: Sequence[str]) -> Fitted:
        """Return the reading with these numbers as the pictures have them."""
        steps = {name: step for name, step in self.steps(start).items() if name in names}
        if not steps:
            return start, {}
        if (key := (start, tuple(steps))) not in self._fits:
            found = fit(self.middle, start, steps)
            self._fits[key] = found if self.fine is self.middle else fit(self.fine, found[0], steps)
        return self._fits[key]

    def candidate(self, noise: Noise, reading: Reading, error: dict[str, float] | None = None) -> Candidate:
        """Return the reading with its disagreement, block by block."""
        costs = self.fine.by_block(cost(self.fine.residuals(reading), noise))
        return Candidate(reading, error or {}, costs, float(costs.sum()), len(differences(reading)))


def standard_errors(apart: Array) -> float:
    """Return the sum of what blocks differ by, in its standard errors; blocks are independent."""
    differs = apart[apart != 0]
    if len(differs) < _FEWEST:
        return 0.0
    spread = math.sqrt(len(differs)) * float(differs.std(ddof=1))
    return float(differs.sum() / max(spread, 1e-9))


def margin(worse: Candidate, better: Candidate) -> float:
    """Return by how many standard errors one reading disagrees more than the other."""
    return standard_errors(worse.cost - better.cost)


def _near(inverse: Array) -> Array:
    """Return what is known and not infinitely far, as the sky is; 0 alone where nothing is."""
    known = inverse[np.isfinite(inverse) & (inverse != 0)]
    return known if len(known) else np.zeros(1)
