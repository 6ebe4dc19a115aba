"""Where the names of points and lines go, so that none covers another.

Boxes are (left, bottom, right, top), lengths in points; all functions are pure.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_RADII = (1.5, 4, 7, 11, 16, 22, 29, 37, 46, 57, 70, 86, 105, 130, 160, 200, 260, 340)
_DIRECTIONS = 24
_SWEEPS = 4
_GAP = 1.0  # kept free around every label
# In points of distance: what a fault of a place is worth.
_COVERS, _CUT, _CROSSES, _PASSES, _OVER_LINE = 1e5, 3e4, 60.0, 40.0, 8.0


def place_labels(points: Array, sizes: Array, area: tuple[float, float], *, clearance: float = 4, line: Array | None = None) -> Array:
    """Lower left corners, (n, 2), of labels of `sizes` (n, 2) beside `points` (n, 2) in an area (w, h) with its corner at (0, 0).

    Each label goes as near to its point as it can without covering another label, a point (a square of half side `clearance`) or
    the leader that ties another label to its point, and so that leaders cross rarely; `line` (m, 2), a polyline, is
    avoided where that is cheap. Where there is no room at all, the least bad place is taken. Deterministic.
    """
    points, sizes = np.asarray(points, dtype=np.float64).reshape(-1, 2), np.asarray(sizes, dtype=np.float64).reshape(-1, 2)
    count = len(points)
    markers = np.concatenate([points - clearance, points + clearance], axis=1)
    crowd = np.linalg.norm(points[:, None] - points[None], axis=2).clip(max=120).sum(axis=1)
    corners = np.full((count, 2), np.nan)
    for sweep in range(_SWEEPS):
        before = corners.copy()
        for index in np.argsort(crowd, kind="stable"):
            others = np.flatnonzero(~np.isnan(corners[:, 0]) & (np.arange(count) != index))
            places = _places(points[index], sizes[index], clearance)
            corners[index] = places[np.argmin(_cost(places, index, others, points, sizes, corners, markers, area, line))]
        if sweep and np.array_equal(before, corners):
            break
    return corners


def _places(point: Array, size: Array, clearance: float) -> Array:
    angle = np.arange(_DIRECTIONS) * (2 * np.pi / _DIRECTIONS)
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    # Right, left, above and below touch the marker with the middle of a side, the rest with a corner or nearly so.
    half = size / 2 * np.clip(1.4 * way, -1, 1) + clearance * np.clip(1.4 * way, -1, 1)
    centres = point + half[None] + np.asarray(_RADII)[:, None, None] * way[None]
    return (centres - size / 2).reshape(-1, 2)


def _cost(
    places: Array, index: int, others: NDArray, points: Array, sizes: Array, corners: Array, markers: Array,
    area: tuple[float, float], line: Array | None,
) -> Array:  # fmt: skip
    boxes = np.concatenate([places, places + sizes[index]], axis=1)
    tips = leader_tips(points[index], boxes)
    start = np.broadcast_to(points[index], tips.shape)
    cost = np.linalg.norm(tips - points[index], axis=1)
    cost += 0.3 * (tips[:, 0] < points[index][0])  # to the right, if all else is equal
    outside = np.maximum(-boxes[:, :2], boxes[:, 2:] - np.asarray(area)).clip(min=0).sum(axis=1)
    cost += np.where(outside > 0, 2 * _COVERS + 100 * outside, 0)
    cost += _COVERS * boxes_touch(boxes, markers).sum(axis=1)
    beside = np.delete(markers, index, axis=0)
    cost += _PASSES * segments_hit(start, tips, beside).sum(axis=1)
    if len(others):
        placed = np.concatenate([corners[others], corners[others] + sizes[others]], axis=1)
        placed_tips = np.stack([leader_tips(points[i], placed[[n]])[0] for n, i in enumerate(others)])
        cost += _COVERS * boxes_touch(boxes, placed, _GAP).sum(axis=1)
        cost += _CUT * segments_hit(start, tips, placed).sum(axis=1)
        cost += _CUT * segments_hit(points[others], placed_tips, boxes).sum(axis=0)
        cost += _CROSSES * _segments_cross(start, tips, points[others], placed_tips).sum(axis=1)
    if line is not None and len(line) > 1:
        cost += _OVER_LINE * segments_hit(line[:-1], line[1:], boxes).sum(axis=0)
    return cost


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
