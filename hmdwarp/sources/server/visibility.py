"""Culling and order of a scene's chunks for a view: those that may be visible, near ones first."""

from __future__ import annotations

import math
from collections import OrderedDict
from functools import lru_cache
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import Fov, Pose, View

NEAR_M = 0.02  # closer than an eye comes to anything but its own lens
_IDENTITY = np.eye(4)

Array = NDArray[np.float64]


def eye_from_scene(view: View, origin_m: Array) -> Array:
    """Return 4x4: metres relative to `origin_m`, subtracted before rotating, to the eye."""
    out = _IDENTITY.copy()
    out[:3, :3] = view.pose.rotation_matrix.T
    out[:3, 3] = out[:3, :3] @ (origin_m - view.pose.position_m)
    return out


@lru_cache(maxsize=64)  # few fields of view, used at every frame
def clip_from_eye(fov: Fov, near_m: float = NEAR_M) -> Array:
    """Return the read-only 4x4 projection with an infinite far plane; w is metres along -z."""
    left, right, down, up = fov.tangents
    return _read_only(
        [
            [2 / (right - left), 0, (right + left) / (right - left), 0],
            [0, 2 / (up - down), (up + down) / (up - down), 0],
            [0, 0, -1, -2 * near_m],
            [0, 0, -1, 0],
        ]
    )


def world_from_ndc(view: View) -> Array:
    """Return 3x3: device coordinates (x, y, 1) to a direction of length 1 along -z."""
    return view.pose.rotation_matrix @ _eye_from_ndc(view.fov)


@lru_cache(maxsize=64)
def _eye_from_ndc(fov: Fov) -> Array:
    left, right, down, up = fov.tangents
    return _read_only([[(right - left) / 2, 0, (right + left) / 2], [0, (up - down) / 2, (up + down) / 2], [0, 0, -1]])


def _read_only(rows: list[list[float]]) -> Array:
    array = np.array(rows)
    array.flags.writeable = False
    return array


def boxes_of(centres: Array, half_sizes: Array) -> Array:
    """Return (7, n) boxes for `visible` and `nearest_first`: centre x, y, z, 1, half sizes."""
    return np.concatenate([centres.T, np.ones((1, len(centres))), half_sizes.T])


def boxes_around(low: Array, high: Array) -> Array:
    """Return (7, n) boxes between (n, 3) corners."""
    return boxes_of((low + high) / 2, (high - low) / 2)


def side_planes(clip: Array) -> Array:
    """Return planes (5, 4), n . (x, y, z, 1) >= 0 inside. Source: Gribb and Hartmann 2001."""
    planes = np.empty((5, 4))
    np.add(clip[3], clip[:3], out=planes[:3])
    np.subtract(clip[3], clip[:2], out=planes[3:])
    return planes


def visible(boxes: Array, clip: Array, slack: Array | float = 0.0) -> NDArray[np.bool_]:
    """Return which boxes may reach into `clip` (4x4 clip_from_scene).

    slack: (5, n) how far each may lie outside each plane. A box is culled only if it lies wholly
    behind one of the four sides or the near plane; some boxes near the corners pass needlessly.
    """
    planes = side_planes(clip)
    inside: NDArray[np.bool_] = (np.concatenate([planes, np.abs(planes[:, :3])], axis=1) @ boxes + slack).min(
        axis=0
    ) >= 0
    return inside


def nearest_first(boxes: Array, eye: Array, classes: int = 4) -> NDArray[np.intp]:
    """Return a class 0 .. classes - 1 for each box, as many in each, by its farthest corner."""
    # Near surfaces drawn first occlude others before they are textured: 1.6 textured pixels per
    # pixel of the room become 1.3. Finer classes mean more draw calls and gained nothing.
    corner = np.abs(boxes[:3] - eye[:, None])
    corner += boxes[4:]
    x, y, z = corner * corner
    farthest = np.sqrt(x + y + z)
    # The borders between classes of equal size: np.quantile's numbers without its 65 us of checks.
    ordered, edges = np.sort(farthest).tolist(), []
    for k in range(1, classes if ordered else 0):
        place = (len(ordered) - 1) * (k / classes)
        below = int(place)
        low, high, share = ordered[below], ordered[min(below + 1, len(ordered) - 1)], place - below
        edges.append(high - (high - low) * (1 - share) if share >= 0.5 else low + (high - low) * share)
    found: NDArray[np.intp] = np.array(edges).searchsorted(farthest, side="left")
    return found


Spans = tuple[tuple[int, int], ...]  # (first index, number of indices) of each draw call
Draws = tuple[tuple[int, Spans], ...]  # (batch, its spans), in the order they are drawn


@attrs.frozen(eq=False)
class Chunks:
    """All chunks of a scene, in the order of the index buffer, batch by batch."""

    first: NDArray[np.int64]  # (n,) index ranges, with the next
    count: NDArray[np.int64]
    batch: NDArray[np.int64]  # (n,) the batch each belongs to
    boxes: NDArray[np.float64]  # (7, n) as projection.boxes_of returns them, relative to the scene's origin


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
    out: list[tuple[int, list[tuple[int, int]]]] = []
    for i, j in spans:
        if not out or out[-1][0] != batches[i]:
            out.append((batches[i], []))
        out[-1][1].append((starts[i], ends[j - 1] - starts[i]))
    return tuple([(batch, tuple(spans)) for batch, spans in out])


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
    """The draws of static chunks, computed once for all views of a cell, so reproducible."""

    _chunks: Chunks
    _known: OrderedDict[_Cell, Draws] = attrs.field(factory=OrderedDict)

    def near(self, turn: tuple[float, float, float, float], eye: Array, fov: Fov) -> Draws:
        """Return the draws for an eye: quaternion xyzw to the chunks' space, (3,) metres in it."""
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
        boxes, clip = self._chunks.boxes, clip_from_eye(fov)
        # How far outside each plane of the middle view a visible box may be, (5, n). Of a point p:
        # |n . (R (p - e) - R' (p - e'))| <= |n| (|R - R'| |p - e'| + |e - e'|), e' the middle's.
        reach = np.sqrt(((boxes[:3] - eye[:, None]) ** 2).sum(axis=0)) + np.sqrt((boxes[4:] ** 2).sum(axis=0))
        steep = np.sqrt((side_planes(clip)[:, :3] ** 2).sum(axis=1))
        slack = steep[:, None] * (TURN_RAD * reach + EYE_OFF_M)
        return draws_of(self._chunks, visible(boxes, clip @ eye_from_here, slack), eye)
