"""Places for the names of points and lines, so that none covers another.

Boxes are (left, bottom, right, top), lengths in points; all functions are pure.

adjustText 1.4 and textalloc 1.2 were tried on the charts of a bench. The first puts names over
markers and other names, and takes five times as long; the second draws its leaders through both.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_RADII = (1.5, 4, 7, 11, 16, 22, 29, 37, 48, 62, 80, 105, 140, 190, 260, 340)
_DIRECTIONS = 32
_SWEEPS = 4
_GAP = 1.0  # kept free around every label
_LONG = 40.0  # a leader of that length counts twice: its name is hard to find
# A label whose place costs more tries others, and those in its way move on: how many each may try.
_BAD, _TRIES, _KEPT = 40.0, 24, 50
# Penalties of a place, in points of distance.
_COVERS, _CUT, _CROSSES, _PASSES, _OVER_LINE, _DOUBTFUL = 1e5, 3e4, 1e4, 60.0, 400.0, 32.0


def place_labels(
    points: Sequence[Array],
    sizes: Array,
    area: tuple[float, float],
    *,
    clearance: float = 4,
    line: Array | None = None,
    others: Array | None = None,
) -> Array:
    """Return the lower left corners, (n, 2), of n labels in an area (w, h) from (0, 0).

    Each label goes as near to one of its points as it can without covering another label, a point
    (a square of half side `clearance`) or a leader, the line from another label to its point.
    Leaders cross neither each other nor the line if that can be had, and a label is nearest to its
    own point. Where there is no room at all, the least bad place is taken. Deterministic.

    points: for each label (m, 2), the points it names, often one. sizes: (n, 2). line: (k, 2), a
    polyline that is avoided too. others: (k, 2), points without a label.
    """
    points = [np.asarray(own, dtype=np.float64).reshape(-1, 2) for own in points]
    sizes = np.asarray(sizes, dtype=np.float64).reshape(-1, 2)
    if not points:
        return np.zeros((0, 2))
    rest = np.zeros((0, 2)) if others is None else np.asarray(others, dtype=np.float64).reshape(-1, 2)
    choices = [_Places.of(i, points, sizes[i], area, clearance, line, rest) for i in range(len(points))]
    middles = np.stack([own.mean(axis=0) for own in points])
    crowd = np.linalg.norm(middles[:, None] - middles[None], axis=2).clip(max=120).sum(axis=1)
    orders = (crowd, -middles[:, 0], middles[:, 1])
    settled = [_settled(choices, np.argsort(order, kind="stable")) for order in orders]
    chosen, _ = min(settled, key=lambda found: found[1])
    alone = [choice.some(np.array([at])) for choice, at in zip(choices, chosen, strict=True)]
    if not _Costs.of(alone).is_bad():
        return np.concatenate([choice.boxes for choice in alone])[:, :2]
    near = [choice.cheapest(at) for choice, at in zip(choices, chosen, strict=True)]
    return np.concatenate([choice.boxes for choice in near])[_Costs.of(near).exchanged(), :2]


def _settled(choices: list[_Places], order: NDArray[Any]) -> tuple[NDArray[Any], float]:
    """Place one label after the other, then each anew until none moves; return places and cost."""
    chosen, costs = np.full(len(choices), -1), np.zeros(len(choices))
    for _ in range(_SWEEPS):
        before = chosen.copy()
        for index in order:
            others = [choices[i].place(chosen[i]) for i in range(len(choices)) if i != index and chosen[i] >= 0]
            cost = choices[index].cost
            if others:
                cost = cost + choices[index].quarrels(*map(np.stack, zip(*others, strict=True))).sum(axis=1)
            chosen[index] = np.argmin(cost)
            costs[index] = cost[chosen[index]]
        if np.array_equal(before, chosen):
            break
    return chosen, float(costs.sum())


@attrs.frozen(eq=False)
class _Costs:
    """What the places of all labels cost, p of them, by themselves and next to each other."""

    ranges: list[NDArray[Any]]  # the places of each label, the one it has first
    own: Array  # (p)
    pairwise: Array  # (p, p), 0 between places of one label

    @classmethod
    def of(cls, choices: list[_Places]) -> _Costs:
        ends = np.cumsum([len(choice.cost) for choice in choices])
        ranges = np.split(np.arange(ends[-1]), ends[:-1])
        placed = [np.concatenate([getattr(choice, part) for choice in choices]) for part in ("boxes", "starts", "tips")]
        pairwise = np.concatenate([choice.quarrels(*placed) for choice in choices])
        for own in ranges:
            pairwise[np.ix_(own, own)] = 0
        return cls(ranges, np.concatenate([choice.cost for choice in choices]), pairwise)

    def is_bad(self) -> bool:
        """Return whether any label's first place is worth an exchange."""
        return bool(self._of(np.array([own[0] for own in self.ranges])).max() > _BAD)

    def exchanged(self) -> NDArray[Any]:
        """Give labels with bad places better ones where those in the way find others."""
        chosen = np.array([own[0] for own in self.ranges])
        for _ in range(_SWEEPS):
            costs, before = self._of(chosen), chosen
            for label in np.argsort(-costs, kind="stable"):
                if costs[label] <= _BAD:
                    break
                for place in self.ranges[label][1 : 1 + _TRIES]:
                    trial = self._with_room(chosen, int(label), int(place))
                    if self._of(trial).sum() < self._of(chosen).sum():
                        chosen = trial
            if chosen is before:
                break
        return chosen

    def _of(self, chosen: NDArray[Any]) -> Array:
        """Return what each label's place costs next to the others'."""
        costs: Array = self.own[chosen] + self.pairwise[np.ix_(chosen, chosen)].sum(axis=1)
        return costs

    def _with_room(self, chosen: NDArray[Any], label: int, place: int) -> NDArray[Any]:
        """Return the places after a label has moved to one, and those in its way have moved on."""
        trial = chosen.copy()
        trial[label] = place
        for other in np.flatnonzero(self.pairwise[place, trial]):
            own, rest = self.ranges[other], np.delete(trial, other)
            trial[other] = own[np.argmin(self.own[own] + self.pairwise[np.ix_(own, rest)].sum(axis=1))]
        return trial


@attrs.frozen(eq=False)
class _Places:
    """The candidate places of one label."""

    boxes: Array  # (k, 4)
    starts: Array  # (k, 2), of the leaders
    tips: Array
    cost: Array  # (k), without that of other labels

    @classmethod
    def of(
        cls,
        index: int,
        points: list[Array],
        size: Array,
        area: tuple[float, float],
        clearance: float,
        line: Array | None,
        others: Array,
    ) -> _Places:
        corners = np.concatenate([_corners(point, size, clearance) for point in points[index]])
        boxes = np.concatenate([corners, corners + size], axis=1)
        starts, tips = leaders(points[index], boxes)
        reach = np.linalg.norm(tips - starts, axis=1)
        way = corners + size / 2 - starts
        aside = np.abs(np.arctan2(way[:, 1], way[:, 0]))  # to the right, if all else is nearly equal
        cost = reach * (1 + reach / _LONG) + 3 * aside
        outside = np.maximum(-boxes[:, :2], boxes[:, 2:] - np.asarray(area)).clip(min=0).sum(axis=1)
        cost += np.where(outside > 0, 2 * _COVERS + 100 * outside, 0)
        cost += _COVERS * boxes_touch(boxes, _squares(np.concatenate([*points, others]), clearance)).sum(axis=1)
        foreign = np.concatenate([others, *(other for i, other in enumerate(points) if i != index)])
        foreign = foreign[(foreign[:, None] != points[index][None]).any(axis=2).all(axis=1)]
        if len(foreign):
            cost += _PASSES * segments_hit(starts, tips, _squares(foreign, clearance)).sum(axis=1)
            # A point at the very same place is ambiguous wherever the label is.
            apart = foreign[np.abs(foreign[:, None] - points[index][None]).max(axis=2).min(axis=1) > 0.5]
            if len(apart):
                cost += _DOUBTFUL * (np.linalg.norm(np.subtract(*leaders(apart, boxes)), axis=1) < reach + 3)
        if line is not None and len(line) > 1:
            cost += _OVER_LINE * segments_hit(line[:-1], line[1:], boxes).sum(axis=0)
            cost += _OVER_LINE * _segments_cross(starts, tips, line[:-1], line[1:]).sum(axis=1)
        return cls(boxes, starts, tips, cost)

    def place(self, at: int) -> tuple[Array, Array, Array]:
        """Return one of them: box, start and tip."""
        return self.boxes[at], self.starts[at], self.tips[at]

    def cheapest(self, first: int) -> _Places:
        """Return those that cost least, after the one that comes first."""
        order = np.argsort(self.cost, kind="stable")[:_KEPT]
        return self.some(np.concatenate([[first], order[order != first]]))

    def some(self, kept: NDArray[Any]) -> _Places:
        """Return those places alone."""
        return _Places(self.boxes[kept], self.starts[kept], self.tips[kept], self.cost[kept])

    def quarrels(self, boxes: Array, starts: Array, tips: Array) -> Array:
        """Return the cost (k, n) of each place next to n others: boxes (n, 4), leaders (n, 2)."""
        cut = segments_hit(self.starts, self.tips, boxes) + segments_hit(starts, tips, self.boxes).T.astype(np.float64)
        crossed = _segments_cross(self.starts, self.tips, starts, tips)
        costs: Array = _COVERS * boxes_touch(self.boxes, boxes, _GAP) + _CUT * cut + _CROSSES * crossed
        return costs


def _squares(points: Array, half: float) -> Array:
    return np.concatenate([points - half, points + half], axis=1)


def _corners(point: Array, size: Array, clearance: float) -> Array:
    angle = np.arange(_DIRECTIONS) * (2 * np.pi / _DIRECTIONS)
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    # Right, left, above and below touch the marker with the middle of a side, the rest with a
    # corner or nearly so.
    half = (size / 2 + clearance) * np.clip(1.4 * way, -1, 1)
    centres = point + half[None] + np.asarray(_RADII)[:, None, None] * way[None]
    corners: Array = (centres - size / 2).reshape(-1, 2)
    return corners


def leaders(points: Array, boxes: Array) -> tuple[Array, Array]:
    """Return the point (m, 2) nearest to each box (k, 4), and its place in the box: both (k, 2)."""
    tips = np.clip(points[:, None], boxes[None, :, :2], boxes[None, :, 2:])
    nearest = np.linalg.norm(tips - points[:, None], axis=2).argmin(axis=0)
    return points[nearest], tips[nearest, np.arange(len(boxes))]


def boxes_touch(one: Array, other: Array, gap: float = 0.0) -> NDArray[np.bool_]:
    """Return (m, k): the boxes (m, 4) nearer than `gap` to others (k, 4); touching is no hit."""
    low = np.maximum(one[:, None, :2], other[None, :, :2])
    high = np.minimum(one[:, None, 2:], other[None, :, 2:])
    touching: NDArray[np.bool_] = np.all(low < high + gap, axis=2)
    return touching


def segments_hit(start: Array, end: Array, boxes: Array) -> NDArray[np.bool_]:
    """Return (m, k): the segments, start and end (m, 2), that pass through boxes (k, 4)."""
    step = (end - start)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        to_low, to_high = (boxes[None, :, :2] - start[:, None]) / step, (boxes[None, :, 2:] - start[:, None]) / step
    inside = (start[:, None] > boxes[None, :, :2]) & (start[:, None] < boxes[None, :, 2:])
    # A segment along an axis never reaches the other two sides: it is between them all the way, or
    # nowhere.
    still = step == 0
    enter = np.where(still, np.where(inside, -np.inf, np.inf), np.minimum(to_low, to_high)).max(axis=2)
    leave = np.where(still, np.where(inside, np.inf, -np.inf), np.maximum(to_low, to_high)).min(axis=2)
    hit: NDArray[np.bool_] = np.maximum(enter, 0) < np.minimum(leave, 1)
    return hit


def _segments_cross(a: Array, b: Array, c: Array, d: Array) -> NDArray[np.bool_]:
    """Return (m, k): the segments a-b (m, 2) that properly cross c-d (k, 2)."""

    def side(p: Array, q: Array, r: Array) -> Array:
        return np.sign(
            (q[..., 0] - p[..., 0]) * (r[..., 1] - p[..., 1]) - (q[..., 1] - p[..., 1]) * (r[..., 0] - p[..., 0])
        )

    a, b, c, d = a[:, None], b[:, None], c[None], d[None]
    return (side(a, b, c) * side(a, b, d) < 0) & (side(c, d, a) * side(c, d, b) < 0)


def spread(wanted: Array, gap: float, low: float, high: float) -> Array:
    """Return heights at least `gap` apart in low..high, nearest to `wanted` (least squares).

    They keep the order of `wanted`. Where there is no room for all, they are as far apart as fits.
    """
    wanted = np.asarray(wanted, dtype=np.float64)
    if not len(wanted):
        return wanted
    gap = min(gap, (high - low) / max(len(wanted) - 1, 1))
    order = np.argsort(wanted, kind="stable")
    steps = gap * np.arange(len(wanted))
    # With the steps taken off, "at least a gap apart" becomes "never falling": neighbours that fall
    # are pooled into their mean.
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
