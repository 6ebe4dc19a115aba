"""Twin of the iterative warp: guesses along rays through the world."""

from __future__ import annotations

import attrs
import numpy as np
from scipy import ndimage

from hmdwarp.client.warps.iterative import IterativeSettings
from hmdwarp.geometry import WarpMap
from reference._rays import FLOAT32_UNIT, project
from reference._rendered_surface import LEAST_RUN, Array, Bools, RaysInRendered, RenderedSurface, run_of
from reference.picture import ReferencePicture, TwinInputs, near_edge

BLOCK = 4
SAME_SURFACE = 0.9
LEAST_RUN_PIXELS = 1e-6  # per 1/m
MOST_CELLS = 8
FARTHEST_BITS, NEAREST_BITS = (
    int(np.float32(x).view(np.uint32)) for x in (2.0**-20, np.nextafter(np.float32(2**11), np.float32(0)))
)


def iterative(inputs: TwinInputs) -> ReferencePicture:
    """Each shown ray meets the rendered surface where its guess no longer moves. What still moves
    is a hole."""
    settings, size = inputs.settings, inputs.size
    if settings.fringe == "front":
        inputs = attrs.evolve(inputs, inverse_depth=with_fringes_moved(inputs.inverse_depth, settings))
    surface = RenderedSurface(inputs.inverse_depth, settings.tolerance, settings.floor)
    rays = RaysInRendered.of(inputs.rendered, size, inputs.shown, inputs.shown_size)
    r, r_error, unsure = first_guess(inputs, surface) if settings.seed == "forward" else _nothing(rays.lead)
    for _ in range(settings.steps - settings.slanted):
        r, r_error, unsure = _plain_look(surface, rays, r, r_error, unsure)
    reach = np.maximum(np.linalg.norm(rays.along, axis=-1), LEAST_RUN_PIXELS)
    joined = settings.sheet / reach
    for _ in range(settings.slanted):
        place = rays.place(r)
        place_error = rays.place_error(r, r_error)
        found = surface.at(place, place_error, joined, joined * (rays.along_error / reach + 4 * FLOAT32_UNIT))
        run = run_of(found, rays)
        change = np.where(found.known, (found.depth - r) / run, 0.0)
        depth_error = np.abs(found.slope).sum(axis=-1) * place_error + 4 * FLOAT32_UNIT * np.abs(found.depth)
        r_error = 2 * (r_error + depth_error / run)
        r = np.maximum(r + change, 0)
        unsure |= found.unsure
    pixels, error = rays.place(r), rays.place_error(r, r_error)
    length = np.linalg.norm(rays.along, axis=-1)
    moved = np.abs(change) * length
    met = found.known & (moved <= settings.converged)
    unsure |= found.known & (np.abs(moved - settings.converged) <= 2 * length * r_error + 16 * FLOAT32_UNIT * moved)
    looked = _coloured(inputs, rays, r, met, np.where(found.connected, pixels, found.centre), pixels, error, unsure)
    return attrs.evolve(looked, inverse_depth=rays.shown_depth(r, r_error))


def with_fringes_moved(inverse_depth: Array, settings: IterativeSettings) -> Array:
    """The depth (h, w) where pixels beside a nearer surface have that of the nearest of their four
    neighbours; in float32, as the shader compares."""
    own = inverse_depth.astype(np.float32)
    cross = ndimage.generate_binary_structure(2, 1)
    nearest = ndimage.maximum_filter(own, footprint=cross, mode="constant")
    limit = np.float32(settings.tolerance) * (own + np.float32(settings.floor))
    return np.where((own >= 0) & (nearest - own > limit), nearest, own).astype(float)


def _coloured(
    inputs: TwinInputs,
    rays: RaysInRendered,
    r: Array,
    met: Bools,
    at: Array,
    pixels: Array,
    error: Array,
    unsure: Bools,
) -> ReferencePicture:
    size = inputs.size
    with np.errstate(invalid="ignore"):
        ahead = (rays.lead > 0) & (r * rays.ahead_m < 1)
        inside = ((pixels >= 0) & (pixels < np.array(size))).all(axis=-1)
    # Beside the rendered eye, and beside the shown one, float32 may take either side.
    beside = (np.abs(rays.lead) <= 1e-5) | (np.abs(r * rays.ahead_m - 1) <= 1e-5)
    seen = met & ahead & inside
    looked = inputs.look(np.where(seen[..., None], at, np.nan), error)
    edge = near_edge(pixels, size, error) & (rays.lead > 0)
    return ReferencePicture(
        looked.colour, looked.tolerance, (unsure & (rays.lead > 0)) | (looked.undecided & seen) | edge | beside
    )


def _nothing(like: Array) -> tuple[Array, Array, Bools]:
    return np.zeros(like.shape), np.zeros(like.shape), np.zeros(like.shape, bool)


def _plain_look(
    surface: RenderedSurface, rays: RaysInRendered, r: Array, r_error: Array, unsure: Bools
) -> tuple[Array, Array, Bools]:
    """The depth of the texel where the guess appears, unless the guess agrees with it."""
    place, error = rays.place(r), rays.place_error(r, r_error)
    seen = surface.held(surface.texel(place))
    limit = surface.tolerance * (r + surface.floor)
    takes = (seen >= 0) & (np.abs(seen - r) > limit)
    close = (seen >= 0) & (np.abs(np.abs(seen - r) - limit) <= 2 * r_error + 16 * FLOAT32_UNIT * (seen + r + limit))
    return (
        np.where(takes, seen, r),
        np.where(takes, 0.0, r_error),
        unsure | close | surface.near_other_texel(place, error),
    )


def first_guess(inputs: TwinInputs, surface: RenderedSurface) -> tuple[Array, Array, Bools]:
    """(h, w) per shown pixel. The guess of its cell, its error, and whether another block may win
    there."""
    keys, texels, unsure = _in_front(inputs)
    high, wide = keys.shape
    left, right, down, up = inputs.shown.fov.tangents
    w, h = inputs.shown_size
    across, upwards = ((np.arange(n) + 0.5) * BLOCK for n in (wide, high))
    x, y = np.meshgrid(left + across * (right - left) / w, down + upwards * (up - down) / h)
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1) @ inputs.shown.pose.rotation.as_matrix().T
    rays = RaysInRendered.of(inputs.rendered, inputs.size, inputs.shown, inputs.shown_size, directions)
    place = texels + np.where(texels % BLOCK < BLOCK // 2, 0.75, 0.25)
    found = surface.at(place, np.zeros(keys.shape))
    # Where the ray through the cell's centre meets the plane through the texel.
    off = rays.start - place
    r = (found.depth + (found.slope * off).sum(axis=-1)) / run_of(found, rays)
    steep = np.abs(found.slope).sum(axis=-1)
    rounding = 8 * FLOAT32_UNIT * (np.abs(r) + steep * np.abs(off).max(axis=-1))
    r_error = (steep * (rays.start_error + np.abs(r) * rays.along_error) + rounding) / LEAST_RUN
    some = (keys > 0) & (r > 0)
    per_pixel = np.ix_(np.arange(h) // BLOCK, np.arange(w) // BLOCK)
    unsure |= (found.unsure | (np.abs(rays.lead) <= 1e-5)) & (keys > 0)
    return np.where(some, r, 0.0)[per_pixel], np.where(some, r_error, 0.0)[per_pixel], unsure[per_pixel]


def _in_front(inputs: TwinInputs) -> tuple[Array, Array, Bools]:
    """Per cell of shown pixels. The largest key of the blocks that land there (0: none), its
    rendered texel, whether rounding may change it."""
    wide, high = inputs.size
    cells = tuple(-(-n // BLOCK) for n in inputs.shown_size)
    padded = np.zeros((-(-high // BLOCK) * BLOCK, -(-wide // BLOCK) * BLOCK))
    padded[:high, :wide] = inputs.inverse_depth
    bits = [(n - 1).bit_length() for n in inputs.size]
    least, most = np.zeros((2, cells[1], cells[0]), np.int64)
    for row in range(0, padded.shape[0], BLOCK):
        for column in range(0, padded.shape[1], BLOCK):
            block = padded[row : row + BLOCK, column : column + BLOCK]
            _splat_block(inputs, block, column, row, bits, cells, least, most)
    texel = most & (2 ** sum(bits) - 1)
    return most, np.stack([texel & (2 ** bits[0] - 1), texel >> bits[0]], axis=-1), least != most


def _splat_block(
    inputs: TwinInputs,
    block: Array,
    column: int,
    row: int,
    bits: list[int],
    cells: tuple[int, ...],
    least: Array,
    most: Array,
) -> None:
    nearest = block.max()
    code = min(int(np.float32(nearest).view(np.uint32)), NEAREST_BITS) if nearest > 0 else 0
    if code < FARTHEST_BITS:
        return
    farthest = max(block[block >= 0].min(), SAME_SURFACE * nearest)
    y, x = np.unravel_index(block.argmax(), block.shape)
    key = ((code - FARTHEST_BITS) << 4) >> sum(bits) << sum(bits) | (int(y + row) << bits[0]) | int(x + column)
    low, high, error, sure = _box(inputs, column, row, nearest, farthest)
    if low is None:
        if not sure:
            most[:] = np.maximum(most, key)
        return
    for where, grow in ((least, -error), (most, error)):
        start = np.maximum(np.floor((low - grow) / BLOCK).astype(int), 0)
        stop = np.minimum(
            np.minimum(np.floor((high + grow) / BLOCK).astype(int), np.array(cells) - 1), start + MOST_CELLS - 1
        )
        if (stop >= start).all():
            part = where[start[1] : stop[1] + 1, start[0] : stop[0] + 1]
            np.maximum(part, key, out=part)


def _box(inputs: TwinInputs, column: int, row: int, nearest: float, farthest: float):
    """What a block covers of the shown picture: lowest and highest pixel, their error. None where
    it reaches beside the shown eye."""
    rendered, wide, high = inputs.rendered, *inputs.size
    left, right, down, up = rendered.fov.tangents
    corners = np.array([(column + dx, row + dy) for dy in (0, BLOCK) for dx in (0, BLOCK)], float)
    tangents = np.stack(
        [left + corners[:, 0] * (right - left) / wide, down + corners[:, 1] * (up - down) / high, -np.ones(4)], axis=-1
    )
    rays = np.tile(tangents @ rendered.pose.rotation.as_matrix().T, (2, 1))
    own = np.repeat([nearest, farthest], 4)
    pixels, _, w = project(
        rays, rendered.pose.position_m - inputs.shown.pose.position_m, own, inputs.shown, inputs.shown_size
    )
    if (w <= 0).any():
        return None, None, None, bool((w < -1e-4).any())
    warp = WarpMap.between(rendered, inputs.size, inputs.shown, inputs.shown_size)
    terms = np.tile(np.column_stack([corners, np.ones(4)]), (2, 1)) @ np.abs(warp.H).T + own[:, None] * np.abs(warp.e)
    pixels = np.clip(pixels, -BLOCK, np.array([-(-n // BLOCK) * BLOCK + BLOCK for n in inputs.shown_size]))
    # As pixel_error_bound; what is cut off beyond the shown picture needs no digits.
    error = 10 * FLOAT32_UNIT * (terms[:, :2] + np.abs(pixels) * terms[:, 2:]) / w[:, None]
    return pixels.min(axis=0), pixels.max(axis=0), error.max(), bool((w > 1e-4).all())
