"""Culling and order of a scene's chunks for a view: those that may be visible, near ones first."""

from __future__ import annotations

import math
from collections import OrderedDict
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import Fov, Pose
from .projection import clip_from_eye, nearest_first, side_planes, visible

Array = NDArray[np.float64]
Spans = tuple[tuple[int, int], ...]  # (first index, number of indices) of each draw call
Draws = tuple[tuple[int, Spans], ...]  # (batch, its spans), in the order they are drawn


@attrs.frozen(eq=False)
class Chunks:
    """All chunks of a scene, in the order of the index buffer, batch by batch."""

    # (n,) index ranges.
    first: NDArray[np.int64]
    count: NDArray[np.int64]
    # (n,) the batch each belongs to.
    batch: NDArray[np.int64]
    # (7, n) as projection.boxes_of returns them, relative to the scene's origin.
    boxes: NDArray[np.float64]


def draws_of(chunks: Chunks, seen: NDArray[np.bool_], eye: Array) -> Draws:
    """Return the draw calls of the chunks in `seen`: nearest class first, then batch by batch."""
    found = seen.nonzero()[0]
    if not len(found):
        return ()
    group = nearest_first(chunks.boxes, eye)[found] * (int(chunks.batch.max()) + 1) + chunks.batch[found]
    order = group.argsort(kind="stable")
    found, group = found[order], group[order]
    first = chunks.first[found]
    end = first + chunks.count[found]
    breaks = (((first[1:] != end[:-1]) | (group[1:] != group[:-1])).nonzero()[0] + 1).tolist()
    # Plain numbers: a NumPy one costs as much as the rest.
    batches, starts, ends = chunks.batch[found].tolist(), first.tolist(), end.tolist()
    spans = zip([0, *breaks], [*breaks, len(ends)], strict=True)
    runs = [(batches[i], starts[i], ends[j - 1] - starts[i]) for i, j in spans]
    return _by_batch(runs)


def _by_batch(runs: list[tuple[int, int, int]]) -> Draws:
    out: list[tuple[int, list[tuple[int, int]]]] = []
    for batch, first, count in runs:
        if not out or out[-1][0] != batch:
            out.append((batch, []))
        out[-1][1].append((first, count))
    return tuple((batch, tuple(spans)) for batch, spans in out)


# A view is replaced by the middle of its cell: of 1/32 in each part of its quaternion, and of 1/8 m
# in each coordinate of its eye. A head that turns at 30 degrees/s enters a new cell at one refresh
# of ten, and a tenth more triangles are drawn than are visible.
TURN_STEP, EYE_STEP_M = 1 / 32, 1 / 8
# Two unit quaternions within half a step in each of four parts differ by a step at most, those of
# the cell's middle, once normalised, by little more: 1.02 for this step. That is a turn of twice
# the angle, and a chord is no longer than its arc.
TURN_RAD = 2 * 1.05 * TURN_STEP
EYE_OFF_M = math.sqrt(3) / 2 * EYE_STEP_M
KEPT = 64
_Cell = tuple[Any, ...]  # whole steps of the quaternion, then of the eye; the field of view


@attrs.define
class Visibility:
    """The draws of static chunks, computed once for all views of a cell.

    Most refreshes find them cached. They depend on the view and nothing else, so the order, which
    decides between surfaces at the same depth, is reproducible.
    """

    _chunks: Chunks
    _known: OrderedDict[_Cell, Draws] = attrs.field(factory=OrderedDict)

    def near(self, turn: tuple[float, float, float, float], eye: Array, fov: Fov) -> Draws:
        """Return the draw calls for an eye.

        turn: unit quaternion xyzw from eye to chunks. eye: (3,) metres in the space of the chunks.
        """
        x, y, z, w = turn if turn[3] >= 0 else (-turn[0], -turn[1], -turn[2], -turn[3])
        a, b, c = eye.tolist()
        per_turn, per_m = 1 / TURN_STEP, 1 / EYE_STEP_M
        whole = (round(x * per_turn), round(y * per_turn), round(z * per_turn), round(w * per_turn))
        key = (*whole, round(a * per_m), round(b * per_m), round(c * per_m), fov)
        draws = self._known.get(key)
        if draws is None:
            draws = self._known[key] = self._compute(key)
            if len(self._known) > KEPT:
                self._known.popitem(last=False)
        return draws

    def _compute(self, key: _Cell) -> Draws:
        turn, eye, fov = np.array(key[:4]) * TURN_STEP, np.array(key[4:7]) * EYE_STEP_M, key[7]
        middle = Pose(eye, turn)
        eye_from_here = np.eye(4)
        eye_from_here[:3, :3] = middle.rotation_matrix.T
        eye_from_here[:3, 3] = -eye_from_here[:3, :3] @ eye
        boxes = self._chunks.boxes
        clip = clip_from_eye(fov) @ eye_from_here
        return draws_of(
            self._chunks, visible(boxes, clip, self._slack(boxes, eye, side_planes(clip_from_eye(fov)))), eye
        )

    def _slack(self, boxes: Array, eye: Array, planes: Array) -> Array:
        """Return (5, n): how far outside each plane of the middle view a visible box may be.

        For a point p: |n . (R (p - e) - R' (p - e'))| <= |n| (|R - R'| |p - e'| + |e - e'|), e' the
        middle's eye.
        """
        reach = np.sqrt(((boxes[:3] - eye[:, None]) ** 2).sum(axis=0)) + np.sqrt((boxes[4:] ** 2).sum(axis=0))
        steep = np.sqrt((planes[:, :3] ** 2).sum(axis=1))
        slack: Array = steep[:, None] * (TURN_RAD * reach + EYE_OFF_M)
        return slack
