"""Twin of fill `composite`: one hole after the other, with NumPy's own mean and median.

Moves go through the world; normals are cross products of homogeneous points.
"""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import View
from reference._rays import Array, pixel_centres, project, rays_through, world_directions

FLOOR = 0.02  # 1/m
NOTHING = 1e-9


@attrs.frozen(eq=False)
class Composited:
    """What the fill goes by; pictures bottom row first.

    warped: (h, w, 4), coverage in alpha. inverse_depth: its depth, -1 unknown. unlit (h, w, 4) and
    model_inverse_depth (h, w): the client's picture. offsets: (n, 2). The rest: the settings, and
    the least move in pixels.
    """

    rendered: View
    shown: View
    warped: Array
    inverse_depth: Array
    unlit: Array
    model_inverse_depth: Array
    offsets: NDArray[np.integer]
    frame_seed: int
    settings: Any
    least_move: float

    @property
    def size(self) -> tuple[int, int]:
        high, wide = self.model_inverse_depth.shape
        return wide, high


def composite(inputs: Composited) -> tuple[Array, Array]:
    """(h, w, 4) and (h, w): colour and inverse depth, with what stays a hole."""
    colour, depth = inputs.warped.copy(), inputs.inverse_depth.copy()
    chosen, average = inputs.settings, {"mean": np.mean, "median": np.median}[inputs.settings.average]
    moves, normals, own = _moves(inputs), _normals(inputs), inputs.model_inverse_depth
    wide, high = inputs.size
    for y, x in np.argwhere(inputs.warped[..., 3] == 0):
        numbers = _mixed(_mixed(x + _mixed(y + _mixed(inputs.frame_seed))) + np.arange(chosen.samples))
        offsets = inputs.offsets[numbers % len(inputs.offsets)]
        offsets = np.where((offsets @ moves[y, x] > 0)[:, None], -offsets, offsets)
        places = [(y + dy, x + dx) for dx, dy in offsets if 0 <= y + dy < high and 0 <= x + dx < wide]
        light = [
            inputs.warped[place][:3]
            for place in places
            if inputs.warped[place][3] > 0
            and abs(own[place] - own[y, x]) <= chosen.depth * (min(own[place], own[y, x]) + FLOOR)
            and normals[place] @ normals[y, x] >= np.cos(np.radians(chosen.normal))
        ]
        if light:
            colour[y, x] = *(inputs.unlit[y, x, :3] * average(light, axis=0)), 1
            depth[y, x] = own[y, x]
    return colour, depth


def _moves(inputs: Composited) -> Array:
    """(h, w, 2).

    By how much each pixel has moved since it was rendered, both eyes looking through the shown
    field of view.
    """
    rendered = View(inputs.rendered.pose, inputs.shown.fov)
    apart = inputs.shown.pose.position_m - inputs.rendered.pose.position_m
    directions = world_directions(inputs.shown, inputs.size)
    was, _, _ = project(directions, apart, inputs.model_inverse_depth, rendered, inputs.size)
    moves = np.nan_to_num(pixel_centres(inputs.size) - was)
    return np.where(np.linalg.norm(moves, axis=-1, keepdims=True) >= inputs.least_move, moves, 0)


def _normals(inputs: Composited) -> Array:
    """(h, w, 3) unit normals of the planes through each pixel and a neighbour on both axes."""
    own, centres = inputs.model_inverse_depth, pixel_centres(inputs.size)
    depths = (own, own + _gentler_step(own, 1), own + _gentler_step(own, 0))
    points = [rays_through(inputs.shown, inputs.size, centres + step) for step in ((0, 0), (1, 0), (0, 1))]
    # The plane through points p_i / r_i, times the product of all r_i, which may be 0.
    around = sum(depths[i][..., None] * np.cross(points[(i + 1) % 3], points[(i + 2) % 3]) for i in range(3))
    planes = around / (points[0] * np.cross(points[1], points[2])).sum(axis=-1, keepdims=True)
    size = np.linalg.norm(planes, axis=-1, keepdims=True)
    return np.where(size > NOTHING, planes / np.maximum(size, NOTHING), (0.0, 0.0, -1.0))


def _gentler_step(depth: Array, axis: int) -> Array:
    """Of the steps from the pixel before and to the one behind, the smaller; 0 without either."""
    none = np.full_like(np.take(depth, [0], axis), np.inf)
    steps = np.diff(depth, axis=axis)
    before, behind = np.concatenate([none, steps], axis), np.concatenate([steps, none], axis)
    gentler = np.where(np.abs(behind) <= np.abs(before), behind, before)
    return np.where(np.isfinite(gentler), gentler, 0)


def _mixed(number: Any) -> NDArray[np.uint32]:
    """PCG's permutation of 32-bit numbers (O'Neill 2014)."""
    state = np.atleast_1d(number).astype(np.uint32) * np.uint32(747796405) + np.uint32(2891336453)
    word = ((state >> ((state >> np.uint32(28)) + np.uint32(4))) ^ state) * np.uint32(277803737)
    return (word >> np.uint32(22)) ^ word
