"""Where the names of points and lines go, so that none covers another.

Boxes are (left, bottom, right, top), lengths in points; all functions are pure.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_RADII = (1.5, 4, 7, 11, 16, 22, 29, 37, 48, 62, 80, 105, 140, 190, 260, 340)
_DIRECTIONS = 20
_SWEEPS = 4
_GAP = 1.0  # kept free around every label
# In points of distance: what a fault of a place is worth.
_COVERS, _CUT, _CROSSES, _PASSES, _OVER_LINE, _DOUBTFUL = 1e5, 3e4, 60.0, 40.0, 12.0, 32.0


def place_labels(points: Array, sizes: Array, area: tuple[float, float], *, clearance: float = 4, line: Array | None = None) -> Array:
    """Lower left corners, (n, 2), of labels of `sizes` (n, 2) beside `points` (n, 2) in an area (w, h) with its corner at (0, 0).

    Each label goes as near to its point as it can without covering another label, a point (a square of half side `clearance`) or
    the leader that ties another label to its point, so that leaders cross rarely and it is nearest to its own point; `line`
    (m, 2), a polyline, is avoided where that is cheap. Where there is no room at all, the least bad place is taken. Deterministic.
    """
    points, sizes = np.asarray(points, dtype=np.float64).reshape(-1, 2), np.asarray(sizes, dtype=np.float64).reshape(-1, 2)
    count = len(points)
    markers = np.concatenate([points - clearance, points + clearance], axis=1)
    choices = [_Places.of(i, points, sizes[i], markers, area, clearance, line) for i in range(count)]
    crowd = np.linalg.norm(points[:, None] - points[None], axis=2).clip(max=120).sum(axis=1)
    best, least = np.zeros((count, 2)), np.inf
    for order in (np.argsort(crowd, kind="stable"), np.argsort(-points[:, 0], kind="stable"), np.argsort(points[:, 1], kind="stable")):
        boxes, cost = _settled(choices, order, points)
        if cost < least:
            best, least = boxes[:, :2], cost
    return best


def _settled(choices: list[_Places], order: NDArray, points: Array) -> tuple[Array, float]:
    """Labels placed one after the other, then each anew among all others until none moves: boxes, and what they cost together."""
    count = len(choices)
    boxes, tips, costs = np.full((count, 4), np.nan), np.full((count, 2), np.nan), np.zeros(count)
    for _ in range(_SWEEPS):
        before = boxes.copy()
        for index in order:
            others = np.flatnonzero(~np.isnan(boxes[:, 0]) & (np.arange(count) != index))
            choice = choices[index]
            cost = choice.cost + choice.quarrels(boxes[others], points[others], tips[others])
            chosen = np.argmin(cost)
            boxes[index], tips[index], costs[index] = choice.boxes[chosen], choice.tips[chosen], cost[chosen]
        if np.array_equal(before, boxes):
            break
    return boxes, float(costs.sum())


@attrs.frozen(eq=False)
class _Places:
    """Where one label could go: k boxes, the ends of their leaders, and what each costs whatever the other labels do."""

    point: Array
    boxes: Array
    tips: Array
    cost: Array

    @classmethod
    def of(
        cls, index: int, points: Array, size: Array, markers: Array, area: tuple[float, float], clearance: float, line: Array | None
    ) -> _Places:
        point = points[index]
        corners = _places(point, size, clearance)
        boxes = np.concatenate([corners, corners + size], axis=1)
        tips = leader_tips(point, boxes)
        reach = np.linalg.norm(tips - point, axis=1)
        way = corners + size / 2 - point
        cost = reach + 3 * np.abs(np.arctan2(way[:, 1], way[:, 0]))  # to the right, if all else is nearly equal
        outside = np.maximum(-boxes[:, :2], boxes[:, 2:] - np.asarray(area)).clip(min=0).sum(axis=1)
        cost += np.where(outside > 0, 2 * _COVERS + 100 * outside, 0) + _COVERS * boxes_touch(boxes, markers).sum(axis=1)
        foreign = np.delete(points, index, axis=0)
        foreign = foreign[np.abs(foreign - point).max(axis=1) > 0.5] if len(foreign) else foreign  # nobody can tell those apart
        if len(foreign):
            nearest = np.linalg.norm(np.stack([leader_tips(other, boxes) - other for other in foreign]), axis=2).min(axis=0)
            cost += _DOUBTFUL * (nearest < reach + 3)
        cost += _PASSES * segments_hit(np.broadcast_to(point, tips.shape), tips, np.delete(markers, index, axis=0)).sum(axis=1)
        if line is not None and len(line) > 1:
            cost += _OVER_LINE * segments_hit(line[:-1], line[1:], boxes).sum(axis=0)
        return cls(point, boxes, tips, cost)

    def quarrels(self, boxes: Array, points: Array, tips: Array) -> Array:
        """What each place costs beside labels that stand in `boxes` (n, 4), tied to their points."""
        start = np.broadcast_to(self.point, self.tips.shape)
        cost = _COVERS * boxes_touch(self.boxes, boxes, _GAP).sum(axis=1)
        cost += _CUT * segments_hit(start, self.tips, boxes).sum(axis=1)
        cost += _CUT * segments_hit(points, tips, self.boxes).sum(axis=0)
        return cost + _CROSSES * _segments_cross(start, self.tips, points, tips).sum(axis=1)


def _places(point: Array, size: Array, clearance: float) -> Array:
    angle = np.arange(_DIRECTIONS) * (2 * np.pi / _DIRECTIONS)
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    # Right, left, above and below touch the marker with the middle of a side, the rest with a corner or nearly so.
    half = size / 2 * np.clip(1.4 * way, -1, 1) + clearance * np.clip(1.4 * way, -1, 1)
    centres = point + half[None] + np.asarray(_RADII)[:, None, None] * way[None]
    return (centres - size / 2).reshape(-1, 2)


def leader_tips(point: Array, boxes: Array) -> Array:
    """Of each box (k, 4) the place nearest to the point: where its leader ends."""
    return np.clip(point, boxes[:, :2], boxes[:, 2:])


def boxes_touch(one: Array, other: Array, gap: float = 0.0) -> NDArray[np.bool_]:
    """(m, k): which boxes of one (m, 4) come nearer than `gap` to which of the other (k, 4); sides that only meet do not count."""
    low = np.maximum(one[:, None, :2], other[None, :, :2])
    high = np.minimum(one[:, None, 2:], other[None, :, 2:])
    return (low < high + gap).all(axis=2)


def segments_hit(start: Array, end: Array, boxes: Array) -> NDArray[np.bool_]:
    """(m, k): which segments, start and end (m, 2), pass through the inside of which boxes (k, 4)."""
    step = (end - start)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        to_low, to_high = (boxes[None, :, :2] - start[:, None]) / step, (boxes[None, :, 2:] - start[:, None]) / step
    inside = (start[:, None] > boxes[None, :, :2]) & (start[:, None] < boxes[None, :, 2:])
    # A segment along an axis never reaches the other two sides: it is between them all the way, or nowhere.
    still = step == 0
    enter = np.where(still, np.where(inside, -np.inf, np.inf), np.minimum(to_low, to_high)).max(axis=2)
    leave = np.where(still, np.where(inside, np.inf, -np.inf), np.maximum(to_low, to_high)).min(axis=2)
    return np.maximum(enter, 0) < np.minimum(leave, 1)


def _segments_cross(a: Array, b: Array, c: Array, d: Array) -> NDArray[np.bool_]:
    """(m, k): which segments a-b (m, 2) properly cross which c-d (k, 2)."""

    def side(p: Array, q: Array, r: Array) -> Array:
        return np.sign((q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0]))

    a, b, c, d = a[:, None], b[:, None], c[None], d[None]
    return (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)


def spread(wanted: Array, gap: float, low: float, high: float) -> Array:
    """Heights at least `gap` apart within low..high, in the order of `wanted` and as near to it as can be (least squares).

    Where there is no room for all at that distance, they are as far apart as fits.
    """
    wanted = np.asarray(wanted, dtype=np.float64)
    if not len(wanted):
        return wanted
    gap = min(gap, (high - low) / max(len(wanted) - 1, 1))
    order = np.argsort(wanted, kind="stable")
    steps = gap * np.arange(len(wanted))
    # With the steps taken off, "at least a gap apart" becomes "never falling": pool neighbours that fall into their mean.
    pools: list[list[float]] = []  # [mean, count]
    for value in wanted[order] - steps:
        pools.append([float(value), 1])
        while len(pools) > 1 and pools[-2][0] >= pools[-1][0]:
            (one, m), (other, n) = pools[-2:]
            pools[-2:] = [[(one * m + other * n) / (m + n), m + n]]
    level = np.repeat([mean for mean, _ in pools], [int(count) for _, count in pools])
    out = np.empty_like(wanted)
    out[order] = np.clip(level, low, high - steps[-1]) + steps
    return out
