"""Twin of the splat warp.

Each drawn pixel is a patch of a plane in the world, and each shown ray is met with it.
"""

from __future__ import annotations

from collections.abc import Callable

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import View, WarpMap
from reference._rays import FLOAT32_UNIT, Array, pixel_error_bound, project, world_directions
from reference.picture import HALF_SMALLEST, HALF_UNIT, ReferencePicture, TwinInputs

NEAREST = 2.0**20  # 1/m
WIDEST = 3.0  # rendered pixels averaged over on each axis
SHARPNESS = 0.6667
UNKNOWN = 1e30  # how far off the depth of a pixel without one is
CORNERS = [(-1, -1), (-1, 1), (1, -1), (1, 1)]


def splat(inputs: TwinInputs) -> ReferencePicture:
    """Of all patches that a shown ray meets the nearest.

    Its colours averaged over what the shown pixel covers there.

    Undecided: where rounding decides whether a patch is met, whether two drawn pixels hang
    together, or which ones agree in depth.
    """
    nearest, depth_error, undecided = _met(inputs)
    return attrs.evolve(_fetched(inputs, nearest, depth_error, undecided), inverse_depth=(nearest, depth_error))


# --- depth forward ------------------------------------------------------------------------------


@attrs.frozen(eq=False)
class _Patches:
    """Of each drawn pixel with depth.

    Its centre (n, 2) in rendered pixels, its ray (n, 3) in the world, inverse depth (n,) and its
    steps (n, 2) per pixel, where it lands (n, 2), the error of that in pixels (n,), and whether
    rounding decides its steps (n,).
    """

    centre: Array
    ray: Array
    inverse_depth: Array
    steps: Array
    landing: Array
    error: Array
    shaky: NDArray[np.bool_]

    def __getitem__(self, chosen: NDArray) -> _Patches:
        return _Patches(*(value[chosen] for value in attrs.astuple(self, recurse=False)))


def _met(inputs: TwinInputs) -> tuple[Array, Array, NDArray[np.bool_]]:
    """(h, w) nearest inverse depth of the patches each shown ray meets, -1 for none; its error.

    Where rounding decides.
    """
    wide, high = inputs.shown_size
    patches = _patches(inputs)
    grid = _ray_steps(inputs.rendered, inputs.size)
    number, x, y = _pairs(inputs, patches, grid)
    chosen = patches[number]
    planes = _planes(chosen, grid)
    moved = inputs.shown.pose.position_m - inputs.rendered.pose.position_m
    rays = world_directions(inputs.shown, inputs.shown_size)[y, x]
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = -(planes[:, :3] * rays).sum(1) / (planes[:, :3] @ moved + planes[:, 3])
    inverse = np.where(np.abs(inverse) < 1e12, inverse, np.nan)  # a patch seen edge-on
    place, _, w = project(rays, moved, inverse, inputs.rendered, inputs.size)
    beside = np.abs(place - chosen.centre).max(axis=1)
    margin, per_pixel = _margins(inputs, chosen, grid)
    inverse = np.maximum(inverse, 0)
    depth_error = per_pixel * margin + 16 * FLOAT32_UNIT * np.abs(inverse)
    half = 0.5 + inputs.settings.overlap
    valid = (w > 0) & (inverse <= NEAREST * (1 + 1e-6)) & np.isfinite(beside)
    slot = y * wide + x

    def nearest(side: Array) -> tuple[Array, Array]:
        found, error = np.full(wide * high, -1.0), np.zeros(wide * high)
        inside = valid & (beside <= side)
        order = np.flatnonzero(inside)[np.argsort(inverse[inside], kind="stable")]
        found[slot[order]], error[slot[order]] = inverse[order], depth_error[order]
        return found, error

    found, error = nearest(np.full(len(slot), half))
    undecided = np.zeros(wide * high, bool)
    for side in (half - margin, half + margin):
        other, its_error = nearest(side)
        undecided |= np.abs(other - found) > error + its_error
    undecided[slot[valid & chosen.shaky & (beside <= half + 0.5)]] = True
    return tuple(value.reshape(high, wide) for value in (found, error, undecided))


def _patches(inputs: TwinInputs) -> _Patches:
    depth, rendered, shown, size = inputs.inverse_depth, inputs.rendered, inputs.shown, inputs.size
    known = (depth >= 0) & np.isfinite(depth)
    own = np.where(known, depth, 0)
    rays, back = world_directions(rendered, size), rendered.pose.position_m - shown.pose.position_m
    landing, _, w = project(rays, back, own, shown, inputs.shown_size)

    def opened(other: Array) -> Array:
        """Pixels from where each drawn pixel lands to where it would with another depth."""
        return np.nan_to_num(
            np.abs(project(rays, back, other, shown, inputs.shown_size)[0] - landing).max(axis=-1), nan=np.inf
        )

    steps, shaky = zip(
        *(_steps(np.where(known, depth, np.nan), opened, axis, inputs.settings) for axis in (1, 0)), strict=True
    )
    steps = np.stack(steps, axis=-1)
    steep = np.abs(steps).sum(axis=-1) > own
    steps[steep] *= (own[steep] / np.abs(steps[steep]).sum(axis=-1))[:, None]
    error = pixel_error_bound(WarpMap.between(rendered, size, shown, inputs.shown_size), size, own)
    drawn = known & (w > 0)
    y, x = np.nonzero(drawn)
    return _Patches(
        np.stack([x, y], axis=1) + 0.5, rays[drawn], own[drawn], steps[drawn], landing[drawn], error[drawn],
        (shaky[0] | shaky[1])[drawn],
    )  # fmt: skip


def _steps(
    depth: Array, opened: Callable[[Array], Array], axis: int, settings: object
) -> tuple[Array, NDArray[np.bool_]]:
    """The change of inverse depth to the next pixel along an axis.

    The mean of those that hang together; and close calls.
    """
    edge = [(1, 1) if k == axis else (0, 0) for k in (0, 1)]
    padded = np.pad(depth, edge, constant_values=np.nan)
    total, count, shaky = np.zeros(depth.shape), np.zeros(depth.shape, int), np.zeros(depth.shape, bool)
    for start, sign in ((0, -1), (2, 1)):
        other = np.take(padded, range(start, start + depth.shape[axis]), axis=axis)
        change, most, gap = np.abs(other - depth), settings.tolerance * (depth + settings.floor), opened(other)
        with np.errstate(invalid="ignore"):
            close = (np.abs(change - most) <= 16 * FLOAT32_UNIT * (change + 2 * depth + most)) | (
                np.abs(gap - 1) <= 1e-3
            )
        holds = (change <= most) | (np.isfinite(change) & (gap <= 1))
        total += np.where(holds, sign * (other - depth), 0)
        count += holds
        shaky |= close & np.isfinite(change)
    return total / np.maximum(count, 1), shaky


def _ray_steps(view: View, size: tuple[int, int]) -> Array:
    """(2, 3) how the ray changes in the world from one pixel to the next, on x and on y."""
    left, right, down, up = view.fov.tangents
    return (
        np.array([[(right - left) / size[0], 0, 0], [0, (up - down) / size[1], 0]]) @ view.pose.rotation.as_matrix().T
    )


def _at(patches: _Patches, grid: Array, x: float, y: float) -> tuple[Array, Array]:
    """The rays and inverse depths of the points (x, y) rendered pixels beside the centres, on their
    planes.
    """
    return patches.ray + x * grid[0] + y * grid[1], patches.inverse_depth + patches.steps @ np.array([x, y])


def _planes(patches: _Patches, grid: Array) -> Array:
    """(n, 4) the plane through three points of each patch, as (ray, inverse depth) around the
    rendered eye: what all four minors give.
    """
    points = [
        np.concatenate([ray, r[:, None]], axis=1)
        for ray, r in (_at(patches, grid, *d) for d in ((0, 0), (0.5, 0), (0, 0.5)))
    ]
    stacked = np.stack(points, axis=1)
    return np.stack([(-1) ** k * np.linalg.det(np.delete(stacked, k, axis=2)) for k in range(4)], axis=1)


def _pairs(
    inputs: TwinInputs, patches: _Patches, grid: Array
) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Patch number and shown pixel of all pairs where the patch might be met, at most `reach` from
    where it lands.
    """
    back, half = inputs.rendered.pose.position_m - inputs.shown.pose.position_m, 0.55 + inputs.settings.overlap
    corners = [_at(patches, grid, half * x, half * y) for x, y in CORNERS]
    seen = [project(ray, back, r, inputs.shown, inputs.shown_size)[0] for ray, r in corners]
    extent = np.max([np.abs(place - patches.landing) for place in seen], axis=0)
    reach = float(inputs.settings.reach)
    extent = np.where(np.isnan(extent), reach, np.minimum(extent, reach))
    landing = np.clip(patches.landing, -1e6, 1e6)
    low = np.maximum(np.ceil(landing - extent - 0.5), 0).astype(np.int64)
    high = np.minimum(np.floor(landing + extent - 0.5), np.array(inputs.shown_size) - 1).astype(np.int64)
    spans = np.maximum(high - low + 1, 0)
    counts = spans.prod(axis=1)
    number = np.repeat(np.arange(len(counts)), counts)
    place = np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
    wide = spans[number, 0]
    return number, low[number, 0] + place % np.maximum(wide, 1), low[number, 1] + place // np.maximum(wide, 1)


def _margins(inputs: TwinInputs, patches: _Patches, grid: Array) -> tuple[Array, Array]:
    """How far, in rendered pixels, rounding may move a point within its patch.

    And the change of shown inverse depth per rendered pixel.

    The shader solves for the place from where the centre lands and the derivative there, each off
    by at most the landing's own bound per rendered pixel (derivatives are differences of the same
    terms): 4 of them cover the landing, both columns and the perspective.
    """
    back = inputs.rendered.pose.position_m - inputs.shown.pose.position_m
    ends = [
        project(*_swap(_at(patches, grid, x, y), back), inputs.shown, inputs.shown_size)
        for x, y in ((0.01, 0), (0, 0.01))
    ]
    here = project(patches.ray, back, patches.inverse_depth, inputs.shown, inputs.shown_size)
    columns = np.stack([(end[0] - here[0]) / 0.01 for end in ends], axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        shrinks = np.linalg.norm(columns, axis=(1, 2)) / np.abs(np.linalg.det(columns))
    per_pixel = np.sum([np.abs(end[1] - here[1]) / 0.01 for end in ends], axis=0)
    return np.nan_to_num(4 * patches.error * shrinks + 8 * FLOAT32_UNIT, nan=np.inf), np.nan_to_num(
        per_pixel, nan=np.inf
    )


def _swap(point: tuple[Array, Array], offset: Array) -> tuple[Array, Array, Array]:
    return point[0], offset, point[1]


# --- colour backward ----------------------------------------------------------------------------


def _fetched(inputs: TwinInputs, nearest: Array, depth_error: Array, undecided: NDArray[np.bool_]) -> ReferencePicture:
    """The rendered picture where the shown points are in it, averaged over the area of a shown
    pixel: of the rendered pixels there those that agree in depth, or the one that agrees best of
    those under one rendered pixel's area.
    """
    place, expected, error, half = _looks(inputs, nearest, depth_error)
    covers = nearest >= 0
    low, high = place - half, place + half
    around = np.floor(np.nan_to_num(np.clip(place, -9, 1e6))).astype(int)
    taps = [_Tap.of(inputs, around + np.array([x, y]), low, high, expected) for y in range(-2, 3) for x in range(-2, 3)]
    most = inputs.settings.tolerance * (expected + inputs.settings.floor)
    four = [
        _Tap.of(inputs, around + np.array([x, y]), place - 0.5, place + 0.5, expected)
        for y in (-1, 0, 1)
        for x in (-1, 0, 1)
    ]
    best, *others = (
        np.min([np.where(tap.area > least, tap.off, UNKNOWN) for tap in four], axis=0) for least in (0, error, -error)
    )
    limit = np.maximum(most, best)
    undecided = undecided | (covers & (error >= 1))
    for other in others:
        undecided |= covers & (np.maximum(most, other) != limit)
    slack = 32 * FLOAT32_UNIT * (expected + limit) + depth_error
    chosen = [(tap.area > 0) & (tap.off <= limit) for tap in taps]
    weights = np.stack([np.where(use, tap.area, 0) for tap, use in zip(taps, chosen, strict=True)])
    colours = np.stack([tap.colour for tap in taps])
    total = np.einsum("k...,k...c->...c", weights, colours)
    with np.errstate(divide="ignore", invalid="ignore"):
        mean = np.where((total[..., 3:] > 0) & covers[..., None], total / total[..., 3:], 0)
    for tap in taps:
        at_limit = (np.abs(tap.off - limit) <= slack) & (tap.off != best)
        undecided |= covers & at_limit & (tap.area > -error)
    touched = np.stack([(tap.area > -error) & (tap.off <= limit) for tap in taps])
    apart = np.where(touched, np.abs(colours - mean[None]).max(axis=-1), 0)
    # Both sides of a tap may move by the error; the sides are at most 1 long.
    tolerance = 4 * error * apart.sum(axis=0) / np.maximum(total[..., 3], 1e-6)
    brightest = np.where(touched, np.abs(colours[..., :3]).max(axis=-1), 0).max(axis=0)
    tolerance = (
        tolerance + HALF_UNIT * np.abs(mean[..., :3]).max(axis=-1) + 64 * FLOAT32_UNIT * brightest + HALF_SMALLEST
    )
    return ReferencePicture(mean, np.where(covers, tolerance, 0), undecided)


@attrs.frozen(eq=False)
class _Tap:
    """One rendered pixel near each look.

    How much of it is covered (negative: how far it is from being), how far its depth is off.
    """

    area: Array
    off: Array
    colour: Array

    @classmethod
    def of(cls, inputs: TwinInputs, texel: NDArray[np.int64], low: Array, high: Array, expected: Array) -> _Tap:
        side = np.minimum(high, texel + 1) - np.maximum(low, texel)
        clipped = np.clip(texel, 0, np.array(inputs.size) - 1)
        outside = (clipped != texel).any(axis=-1)
        held, colour = (layer[clipped[..., 1], clipped[..., 0]] for layer in (inputs.inverse_depth, inputs.colour))
        unknown = outside | ~(held >= 0) | ~np.isfinite(held)
        area = np.where((side > 0).all(axis=-1), side.prod(axis=-1), -np.abs(np.minimum(side, 0)).max(axis=-1))
        return cls(
            np.where(unknown | np.isnan(area), -np.inf, area),
            np.where(unknown, UNKNOWN, np.abs(held - expected)),
            np.where(unknown[..., None], 0, colour),
        )


def _looks(inputs: TwinInputs, nearest: Array, depth_error: Array) -> tuple[Array, Array, Array, Array]:
    """Where each shown point is in the rendered picture, its inverse depth there, the error of the
    place, and half the sides (.., 2) of the box that a shown pixel covers around it.
    """
    shown, rendered, size = inputs.shown, inputs.rendered, inputs.size
    moved = shown.pose.position_m - rendered.pose.position_m
    rays, own = world_directions(shown, inputs.shown_size), np.maximum(nearest, 0)
    place, expected, _ = project(rays, moved, own, rendered, size)
    ends = [
        [project(rays + h * step, moved, own, rendered, size)[0] for h in (-1e-3, 1e-3)]
        for step in _ray_steps(shown, inputs.shown_size)
    ]
    columns = [(end[1] - end[0]) / 2e-3 for end in ends]
    half = 0.5 * np.clip(SHARPNESS * np.hypot(*columns), 1, WIDEST)
    small = 1e-6 * (own + 1e-3)
    parallax = np.abs(project(rays, moved, own + small, rendered, size)[0] - place).max(axis=-1) / small
    bound = pixel_error_bound(WarpMap.between(shown, inputs.shown_size, rendered, size), inputs.shown_size, own)
    # The sides of a box larger than a pixel are differences of the place's own terms: its bound
    # once more for each half of a side.
    error = bound * (1 + 2 * (half.max(axis=-1) > 0.5)) + parallax * depth_error + 1e-5 * (half.max(axis=-1) - 0.5)
    return place, np.nan_to_num(expected, nan=-1), np.minimum(np.nan_to_num(error, nan=1), 1), half
