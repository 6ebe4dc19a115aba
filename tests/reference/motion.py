"""Twin of the motion pass.

Rays from the rendered eye against the squares that moving pixels cover, moved in the world.

Each moving pixel is a square on the surface it shows. Its corners are put into the world, moved
there (a body's by its poses, the rest by its velocity), and met by rays; nowhere is a warp map or a
rasteriser.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import Pose, View
from reference._rays import rays_through, world_directions
from reference.picture import HALF_SMALLEST, HALF_UNIT, ReferencePicture
from reference.raycast import cast_triangles

Array = NDArray[np.float64]

# A rasteriser may snap corners to 1/256 pixel, half of it each way in each axis, before it says
# which centres are covered.
SNAP_PX = 1 / 256
# Two surfaces closer than this (1/m) may come out in either order: 24 bits of depth for 0 to 50
# 1/m, twice.
DEPTH_STEP = 2 * 50 * 2.0**-24
TEAR_PX = 2.0  # pixels by which neighbours on one surface may move apart
SOFT = -1  # what the ids of deforming pixels are replaced by


@attrs.frozen(eq=False)
class MotionAsked:
    """A rendered picture and how it moves.

    Colour (h, w, 4), inverse_depth (h, w), ids (h, w) with 0 for what stands still, view.

    poses: of each body when it was drawn and when it is shown. way_m: (h, w, 3) along the eye's
    axes, how far each pixel of what deforms goes by itself; NaN where nothing does. steepest: part
    of itself by which the inverse depth of one surface changes from pixel to pixel.
    """

    colour: Array
    inverse_depth: Array
    ids: NDArray[np.int64]
    view: View
    steepest: tuple[float, float]
    poses: Sequence[tuple[Pose, Pose]] = ()
    way_m: Array | None = None

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) in pixels."""
        return self.colour.shape[1::-1]

    def keys(self) -> NDArray[np.int64]:
        """(h, w) what each pixel moves with: 0 nothing, SOFT, or its body. A body beyond the table
        or at rest is nothing."""
        moves = [not drawn.isclose(shown, 1e-12) for drawn, shown in self.poses]
        known = np.isin(self.ids, 1 + np.flatnonzero(moves))
        keys = np.where(known, self.ids, 0)
        if self.way_m is not None:
            keys = np.where((keys == 0) & (np.abs(np.nan_to_num(self.way_m)).sum(axis=-1) > 0), SOFT, keys)
        return np.where(self.inverse_depth >= 0, keys, 0)


@attrs.frozen(eq=False)
class MovedPicture:
    """What the pass should leave. The picture, and its inverse depth with its own tolerance (h,
    w)."""

    picture: ReferencePicture
    inverse_depth: Array
    depth_tolerance: Array


def moved_picture(inputs: MotionAsked) -> MovedPicture:
    """Everything that moves, moved; holes where it was. What a place within SNAP_PX shows otherwise
    is tolerance, or undecided."""
    squares = _Squares.of(inputs)
    exact = _looked(inputs, squares, np.zeros(2))
    beside = [
        _looked(inputs, squares, SNAP_PX * np.array(offset)) for offset in product((-1, 0, 1), repeat=2) if any(offset)
    ]
    spread = np.max([np.abs(result.colour - exact.colour)[..., :3].max(axis=-1) for result in beside], axis=0)
    deep = np.max([np.abs(result.inverse_depth - exact.inverse_depth) for result in beside], axis=0)
    other = np.any(
        [(result.owner != exact.owner) & ~_touching(result.owner, exact.owner, inputs.size[0]) for result in beside],
        axis=0,
    )
    undecided = other | np.any([result.near_tie for result in (exact, *beside)], axis=0)
    moved = exact.owner >= 0
    rounding = np.where(moved, 2 * HALF_UNIT * np.abs(exact.colour).max(axis=-1) + HALF_SMALLEST, 0)
    picture = ReferencePicture(exact.colour, np.where(moved, 1.5 * spread, 0) + rounding, undecided)
    return MovedPicture(
        picture, exact.inverse_depth, np.where(moved, 1.5 * deep + 1e-5 * np.abs(exact.inverse_depth), 0)
    )


def _touching(a: NDArray[np.int64], b: NDArray[np.int64], wide: int) -> NDArray[np.bool_]:
    """Whether two pixels, by their index, are neighbours, and neither is none."""
    apart = [np.abs(part_a - part_b) for part_a, part_b in zip(np.divmod(a, wide), np.divmod(b, wide), strict=True)]
    return (a >= 0) & (b >= 0) & (np.maximum(*apart) <= 1)


@attrs.frozen(eq=False)
class _Squares:
    """Two triangles for each moving pixel that still face the eye.

    Corners (m, 3, 3) in the world, moved; their rendered pixels (m, 3, 2) and inverse depths (m,
    3); owner (m,) index of the pixel.
    """

    corners: Array
    pixels: Array
    depths: Array
    owner: NDArray[np.int64]

    @classmethod
    def of(cls, inputs: MotionAsked) -> _Squares:
        keys, found = inputs.keys(), []
        for row, column in np.argwhere(keys):
            square = [_corner(inputs, keys, row, column, dx, dy) for dy in (0, 1) for dx in (0, 1)]
            found += [([square[k] for k in ks], row * inputs.size[0] + column) for ks in ((0, 1, 2), (2, 1, 3))]
        parts = [np.array([[corner[k] for corner in three] for three, _ in found]) for k in range(3)]
        world, pixels, depths = (part.reshape(-1, 3, *tail) for part, tail in zip(parts, ((3,), (2,), ()), strict=True))
        owner = np.array([one for _, one in found], np.int64)
        normal = np.cross(world[:, 1] - world[:, 0], world[:, 2] - world[:, 0])
        faces = np.einsum("ij,ij->i", normal, world[:, 0] - inputs.view.pose.position_m) < 0
        return cls(world[faces], pixels[faces], depths[faces], owner[faces])


def _corner(inputs: MotionAsked, keys: NDArray, row: int, column: int, dx: int, dy: int) -> tuple[Array, Array, float]:
    """A corner of a pixel's square. Its place in the world after the motion, its rendered pixel,
    its inverse depth."""
    around = [(row + dy - 1 + b, column + dx - 1 + a) for a in (0, 1) for b in (0, 1)]
    members = _surface(inputs, keys, (row, column), around)
    inverse_depth = float(np.mean([inputs.inverse_depth[at] for at in members]))
    pixel = np.array([column + dx, row + dy], np.float64)
    eye = inputs.view.pose
    point = eye.transform(rays_through(inputs.view, inputs.size, pixel) / inverse_depth)
    key = keys[row, column]
    if key == SOFT:
        point = point + eye.rotation.apply(np.mean([inputs.way_m[at] for at in members], axis=0))
    else:
        drawn, shown = inputs.poses[key - 1]
        point = shown.transform(drawn.inverse().transform(point))
    return point, pixel, inverse_depth


def _surface(
    inputs: MotionAsked, keys: NDArray, start: tuple[int, int], around: list[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Those of the pixels `around` a corner that are reached from `start` over joined sides."""
    reached, waiting = [start], [start]
    while waiting:
        at = waiting.pop()
        for other in around:
            beside = abs(other[0] - at[0]) + abs(other[1] - at[1]) == 1
            if other not in reached and beside and _joined(inputs, keys, at, other):
                reached.append(other)
                waiting.append(other)
    return reached


def _joined(inputs: MotionAsked, keys: NDArray, a: tuple[int, int], b: tuple[int, int]) -> bool:
    wide, high = inputs.size
    if not (0 <= b[0] < high and 0 <= b[1] < wide) or keys[a] == 0 or keys[a] != keys[b]:
        return False
    allowed = inputs.steepest[0] * abs(a[1] - b[1]) + inputs.steepest[1] * abs(a[0] - b[0])
    near, far = inputs.inverse_depth[a], inputs.inverse_depth[b]
    if abs(near - far) > allowed * min(near, far):
        return False
    return keys[a] != SOFT or bool(np.abs(_strain(inputs, a, b)).max() <= TEAR_PX)


def _strain(inputs: MotionAsked, a: tuple[int, int], b: tuple[int, int]) -> Array:
    """(2,) pixels by which two neighbours move apart."""
    left, right, down, up = inputs.view.fov.tangents
    places = []
    for row, column in (a, b):
        at = np.array([column + 0.5, row + 0.5])
        point = (
            rays_through(inputs.view, inputs.size, at) / inputs.inverse_depth[row, column] + inputs.way_m[row, column]
        )
        share = (point[:2] / -point[2] - (left, down)) / (right - left, up - down)
        places.append(share * inputs.size - at)
    return places[1] - places[0]


@attrs.frozen(eq=False)
class _Look:
    """What rays met: colour (h, w, 4), inverse depth (h, w), owner (h, w). Index of the moving
    pixel, -1 for what stands still."""

    colour: Array
    inverse_depth: Array
    owner: NDArray[np.int64]
    near_tie: NDArray[np.bool_]


def _looked(inputs: MotionAsked, squares: _Squares, offset_px: Array) -> _Look:
    keys, (wide, high) = inputs.keys(), inputs.size
    centres = np.stack(np.meshgrid(np.arange(wide) + 0.5, np.arange(high) + 0.5), axis=-1) + offset_px
    rays = world_directions(inputs.view, inputs.size, centres).reshape(-1, 3)
    still = np.where(keys == 0, inputs.inverse_depth, -1.0)
    colour = np.where((keys == 0)[..., None], inputs.colour, 0.0)
    owner = np.full((high, wide), -1, np.int64)
    near_tie = np.zeros((high, wide), bool)
    if not len(squares.owner):
        return _Look(colour, still, owner, near_tie)
    hits = cast_triangles(squares.corners, inputs.view.pose.position_m, rays)
    met = hits.inverse_depth.reshape(high, wide)
    near_tie = (hits.shape.reshape(high, wide) >= 0) & (np.abs(met - still) <= DEPTH_STEP)
    depth = still.copy()
    for index in np.flatnonzero((hits.shape >= 0) & (hits.inverse_depth >= still.ravel())):
        row, column = divmod(int(index), wide)
        which, (u, v) = hits.shape[index], hits.uv[index]
        # Weights in space to weights in the rendered picture: a corner counts there for its inverse
        # depth.
        weights = np.array([1 - u - v, u, v]) / squares.depths[which]
        place = weights @ squares.pixels[which] / weights.sum()
        owner[row, column], depth[row, column] = squares.owner[which], met[row, column]
        colour[row, column] = _bilinear(inputs, keys, divmod(int(squares.owner[which]), wide), place)
    return _Look(colour, depth, owner, near_tie)


def _bilinear(inputs: MotionAsked, keys: NDArray, own: tuple[int, int], place: Array) -> Array:
    """At `place` (x, y), among those of the four nearest pixels that show the owner's surface."""
    x, y = np.clip(place - (own[1] + 0.5, own[0] + 0.5), -0.5, 0.5)
    total, share = np.zeros(4), 0.0
    for dy, dx in product((0, 1), repeat=2):
        at = (own[0] + dy * (-1 if y < 0 else 1), own[1] + dx * (-1 if x < 0 else 1))
        weight = (abs(x) if dx else 1 - abs(x)) * (abs(y) if dy else 1 - abs(y))
        if (dx, dy) == (0, 0) or _joined(inputs, keys, own, at):
            total, share = total + weight * inputs.colour[at], share + weight
    return np.append(total[:3] / share, 1.0)
