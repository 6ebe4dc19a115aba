"""The search for the reading under which frames agree: one convention first, then two."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence

import attrs
import numpy as np

from .overlap import (
    ALONG,
    BEND,
    DEPTH_SHIFT,
    DEPTH_WIDE,
    FACTOR,
    LATE,
    OFFSET,
    PIXEL_X,
    PIXEL_Y,
    TURN,
    WIDE,
    WIDE_X,
    WIDE_Y,
    Fitted,
    Noise,
    Overlap,
    cost,
    fit,
)
from .stated_frames import AXES, BUFFER, METRES, Array, Reading, Stated

PAIRS, COARSE_POINTS, FINE_POINTS = 16, 160, 400  # compared pairs of frames; points of each
SURE = 3.5  # standard errors by which the better of two readings has to be better
_LONG = 8  # frames of a track whose ends are not compared
_FEWEST = 4  # blocks that say something together
_STEP = 1.25  # from one factor of the grid to the next
_PARALLAX_PX = (0.3, 100.0)  # in pictures of COARSE_PX: less says nothing, more would be no picture
# Inverse depth of the far plane, and of the farthest pixel, over what the median pixel has more.
_FARTHEST, _FARTHEST_SEEN = (0.0, 0.1, 0.3), (0.0, 0.5, 1.0, 2.0, 4.0, 8.0)
_LATE = (-0.8, -0.4, 0.4, 0.8)  # instants of the picture after the pose's, in frames
_WIDE = (0.58, 0.69, 0.83, 1.2, 1.44, 1.73)  # tangents over those stated
_CENTRES = (-0.15, -0.05, 0.0, 0.05, 0.15)  # places of the principal point, of a side
_FAR_CENTRE = 0.2  # of a side from the middle: intrinsics of another size of picture
_OTHER_SIZE = tuple(map(float, np.geomspace(0.4, 2.5, 16)))  # factors of the field of view then
_OFFSETS = (-0.6, -0.3, -0.15, 0.15, 0.3, 0.6)  # of the inverse depth, in its median


@attrs.frozen(eq=False)
class Candidate:
    """A reading, and how it does on the fine pictures."""

    reading: Reading
    cost: Array  # of each block
    changes: int  # conventions that differ from what is stated
    fitted: Fitted | None = None

    @property
    def total(self) -> float:
        """Its cost in all blocks."""
        return float(self.cost.sum())


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
        self.coarse = Overlap(stated, stated.coarse, pairs, COARSE_POINTS * points, between=False)
        self.middle = Overlap(stated, stated.coarse, pairs, FINE_POINTS * points, between=True)
        same = stated.coarse.numbers.shape == stated.fine.numbers.shape
        self.fine = self.middle if same else Overlap(stated, stated.fine, pairs, FINE_POINTS * points, between=True)
        self._scores: dict[Reading, float] = {}

    def score(self, reading: Reading) -> float:
        """Return the agreement on the coarse pictures, 0 to 1."""
        if reading not in self._scores:
            sums, counts = self.coarse.by_block(self.coarse.score(reading))
            self._scores[reading] = float(sums.sum() / max(counts.sum(), 1))
        return self._scores[reading]

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
        yield from self.rows(start)
        if start.along == 0:
            yield attrs.evolve(start, along=1.0)

    @staticmethod
    def rows(start: Reading) -> Iterator[Reading]:
        """Yield the reading with rows the other way round."""
        for colour, depth in itertools.product((False, True), repeat=2):
            if (colour, depth) != (start.colour_rows_up, start.depth_rows_up):
                yield attrs.evolve(start, colour_rows_up=colour, depth_rows_up=depth)

    def usual_numbers(self, start: Reading) -> list[list[Reading]]:
        """Return readings of depth in other units, and of depth buffers; a list for each kind."""
        middle = float(np.median(_near(self.stated.coarse.inverse)))
        ways = [[attrs.evolve(start, factor=factor) for factor in self._factors(start, middle)]]
        if self.stated.may_be_buffer:
            for end, sign in ((1.0, -1.0), (-1.0 if self.stated.signed else 0.0, 1.0)):
                buffer = attrs.evolve(start, kind=BUFFER, end=end)
                middle = float(np.median(np.abs(_near(self.stated.coarse.numbers - end))))
                ways.append(self._encoded(buffer, sign, middle, _FARTHEST))
        return ways

    def numbers(self, start: Reading) -> list[list[Reading]]:
        """Return the same, and of distances that were made of a buffer with other planes."""
        base = _near(self.stated.coarse.inverse)
        middle, most = float(np.median(base)), float(np.percentile(base, 99.9))
        ways = self.usual_numbers(start)
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
        return [attrs.evolve(start, late_s=share * interval_s) for share in _LATE] if interval_s else []

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
        moved = self.moved_m(start)
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

    def moved_m(self, reading: Reading) -> float:
        """Return how far the eye moves between two compared frames, in the median."""
        place = reading.poses(self.stated)[1]
        return float(np.median(np.linalg.norm(np.diff(place[self.coarse.pairs], axis=1), axis=-1)))

    def span(self, reading: Reading) -> float:
        """Return what the inverse depth of the median pixel is over that of the farthest."""
        base = self.stated.coarse.inverse if reading.kind == METRES else self.stated.coarse.numbers
        return abs(float(np.median(_near(base - reading.end)) * reading.factor))

    def farthest(self, reading: Reading) -> float:
        """Return the inverse depth that all but a few pixels exceed, without the offset."""
        return abs(float(np.percentile(_near(self.stated.coarse.inverse), 5) * reading.factor))

    def steps(self, reading: Reading) -> dict[str, float]:
        """Return the numbers that may be fitted, each with a small difference."""
        steps = {FACTOR: 1e-3, OFFSET: 1e-3 * self.span(reading), ALONG: 0.02, PIXEL_X: 0.05, PIXEL_Y: 0.05}
        steps |= {WIDE_X: 2e-3, WIDE_Y: 2e-3, WIDE: 2e-3, DEPTH_WIDE: 2e-3, BEND: 5e-3}
        steps |= {**dict.fromkeys(TURN, 1e-3), **dict.fromkeys(DEPTH_SHIFT, 0.05)}
        if self.stated.interval_s is not None:
            steps[LATE] = 0.05 * self.stated.interval_s
        return steps

    def fitted(self, start: Reading, names: Sequence[str]) -> Fitted:
        """Return the reading with these numbers as the pictures have them."""
        steps = {name: step for name, step in self.steps(start).items() if name in names}
        found = fit(self.middle, start, steps)
        return found if self.fine is self.middle else fit(self.fine, found.reading, steps)

    def candidate(self, reading: Reading, noise: Noise, changes: int, fitted: Fitted | None = None) -> Candidate:
        """Return the reading with its disagreement, block by block."""
        sums, _ = self.fine.by_block(cost(self.fine.residuals(reading), noise))
        return Candidate(reading, sums, changes, fitted)


def standard_errors(differences: Array) -> float:
    """Return the sum of what blocks differ by, in its standard errors; blocks are independent."""
    differs = differences[differences != 0]
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
