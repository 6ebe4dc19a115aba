"""Twin of the search warp: every quarter texel that a ray crosses, in order, without a pyramid."""

from __future__ import annotations

import attrs
import numpy as np
from scipy import ndimage

from reference._rays import FLOAT32_UNIT
from reference._rendered_surface import Array, Bools, RaysInRendered, RenderedSurface
from reference.picture import ReferencePicture, TwinInputs, near_edge

NEAREST = 2.0**11  # 1/m
STRIDE = 1e-3  # pixels by which the shader steps over each border
LEAST_FACING = 1e-3
LEAST_RUN = 1e-9  # pixels per 1/m


def search(inputs: TwinInputs) -> ReferencePicture:
    """Each shown ray to the first quarter texel whose plane it meets within, or `gap` pixels
    beside."""
    settings, size = inputs.settings, inputs.size
    surface = RenderedSurface(inputs.inverse_depth, settings.tolerance, settings.floor)
    rays = RaysInRendered.of(inputs.rendered, size, inputs.shown, inputs.shown_size)
    along = np.nan_to_num(rays.along)
    run = np.where(np.abs(along) < LEAST_RUN, LEAST_RUN, along)
    first, last = _segment(rays, run, size)
    crossed = _crossings(rays, run, size, first, last)
    near, far = crossed[..., :-1], crossed[..., 1:]
    slack = (settings.gap / np.linalg.norm(run, axis=-1))[..., None]
    middle = (
        np.nan_to_num(rays.start)[..., None, :]
        + 0.5 * (near + far)[..., None] * np.nan_to_num(rays.along)[..., None, :]
    )
    found = surface.at(middle, np.zeros(near.shape))
    along, start = (np.nan_to_num(v)[..., None, :] for v in (rays.along, rays.start))
    facing = 1 - (found.slope * along).sum(axis=-1)
    r = (found.depth + (found.slope * (start - middle)).sum(axis=-1)) / np.maximum(facing, LEAST_FACING)
    crosses = (near > far) & ((rays.lead > 0) & (first >= last))[..., None] & found.known
    meets = crosses & (facing > LEAST_FACING) & (r <= near + slack) & (r >= far - slack) & (r * rays.ahead_m < 1)

    pixels_per_r = np.abs(run).max(axis=-1)[..., None]
    reached = np.minimum(first, max(inputs.inverse_depth.max(), 0.0))  # nearer than that nothing is met
    error = 3 * STRIDE + 4 * rays.place_error(reached, np.zeros(first.shape))[..., None]
    margin = np.minimum(np.abs(r - near - slack), np.abs(r - far + slack)) * pixels_per_r
    # A slice thinner than the stride may be stepped over; a plane prolonged into the gap may leave
    # the bounds of its block.
    thin = meets & ((near - far) * pixels_per_r <= error)
    beyond = meets & _beyond_bounds(inputs.inverse_depth, surface.texel(middle), r)
    at_limit = (np.abs(facing - LEAST_FACING) <= 1e-4) | (np.abs(r * rays.ahead_m - 1) <= 1e-5)
    close = crosses & ((margin <= error) | found.unsure | at_limit)
    hit = np.argmax(meets, axis=-1)
    any_hit = meets.any(axis=-1)
    until = np.arange(near.shape[-1]) <= np.where(any_hit, hit, near.shape[-1])[..., None]
    unsure = ((close | thin | beyond) & until).any(axis=-1)
    taken = (_taken(values, hit) for values in (np.maximum(r, 0), found.slope, found.connected, found.centre, facing))
    return _coloured(inputs, rays, _Hits(any_hit, *taken), unsure)


@attrs.frozen(eq=False)
class _Hits:
    """The first meeting of each ray, if there is some: inverse depth, and the surface met."""

    some: Bools
    r: Array
    slope: Array
    connected: Bools
    centre: Array
    facing: Array


def _taken(values: Array, index: Array) -> Array:
    """values (h, w, n[, 2]) at index (h, w)."""
    picked = index[..., None] if values.ndim == 3 else index[..., None, None]
    return np.take_along_axis(values, picked, axis=2)[:, :, 0]


def _segment(rays: RaysInRendered, run: Array, size: tuple[int, int]) -> tuple[Array, Array]:
    """(h, w) each. The largest and the smallest inverse depth at which the ray lies in the rendered
    picture, before the shown eye."""
    start = np.nan_to_num(rays.start)
    borders = np.stack([-start / run, (np.array(size) - start) / run])
    nearest = min(NEAREST, 1 / rays.ahead_m) if rays.ahead_m > 0 else NEAREST
    return np.minimum(borders.max(axis=0).min(axis=-1), nearest), np.maximum(borders.min(axis=0).max(axis=-1), 0)


def _crossings(rays: RaysInRendered, run: Array, size: tuple[int, int], first: Array, last: Array) -> Array:
    """(h, w, n) inverse depths, falling, at which each ray crosses the lines that part texels into
    quarters, from first to last."""
    start = np.nan_to_num(rays.start)
    lines = [(np.arange(2 * n + 1) / 2 - start[..., axis, None]) / run[..., axis, None] for axis, n in enumerate(size)]
    every = np.concatenate([*lines, first[..., None], last[..., None]], axis=-1)
    return -np.sort(-np.clip(every, last[..., None], np.maximum(first, last)[..., None]), axis=-1)


def _beyond_bounds(inverse_depth: Array, texel: Array, r: Array) -> Bools:
    """Whether r is nearer than all, or farther than all, of the 3x3 texels around."""
    valid = inverse_depth >= 0
    nearest = ndimage.maximum_filter(np.where(valid, inverse_depth, -1.0), 3, mode="nearest")
    farthest = ndimage.minimum_filter(np.where(valid, inverse_depth, 1e30), 3, mode="nearest")
    x, y = texel[..., 0], texel[..., 1]
    return (r > nearest[y, x] * (1 + 1e-5)) | (r < farthest[y, x] * (1 - 1e-5))


def _coloured(inputs: TwinInputs, rays: RaysInRendered, hits: _Hits, unsure: Bools) -> ReferencePicture:
    pixels = rays.place(hits.r)
    own_error = rays.place_error(hits.r, np.zeros(hits.r.shape))
    r_error = (4 * FLOAT32_UNIT * np.abs(hits.r) + np.abs(hits.slope).sum(axis=-1) * own_error) / np.maximum(
        hits.facing, LEAST_FACING
    )
    error = rays.place_error(hits.r, 2 * r_error)
    with np.errstate(invalid="ignore"):
        seen = hits.some & ((pixels >= 0) & (pixels < np.array(inputs.size))).all(axis=-1)
    at = np.where(hits.connected, pixels, hits.centre)
    looked = inputs.look(np.where(seen[..., None], at, np.nan), error)
    edge = hits.some & near_edge(pixels, inputs.size, error)
    beside = np.abs(rays.lead) <= 1e-5
    return ReferencePicture(
        looked.colour,
        looked.tolerance,
        (unsure & (rays.lead > 0)) | (looked.undecided & seen) | edge | beside,
        rays.shown_depth(hits.r, 2 * r_error),
    )
