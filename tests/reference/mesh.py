"""Twins of the mesh warps: each shown ray is met with every triangle it may hit, in the world.

The nearest hit is seen.

A triangle's corners are points at eye + direction / inverse depth; scaled by their inverse depths
they are vectors that exist for infinitely far corners too. A ray that is the sum of the three with
weights of one sign hits it, and the weights say where.
"""

from __future__ import annotations

import attrs
import numpy as np
from scipy import ndimage

from hmdwarp.geometry import View, WarpMap
from reference._rays import FLOAT32_UNIT, Array, project
from reference._surface import OVERLAP, Surface, grid_surface, known_depth, surface
from reference.picture import ReferencePicture, TwinInputs, sample_covered

# The rasteriser moves corners to 1/256 of a pixel (GL asks for 1/16, all that exists has 1/256 and
# rounds), each axis by half of that, and the corners themselves are float32: in all less than 1/256
# on each axis.
EDGE_PIXELS = 1 / 256
# The depth buffer keeps 19 bits of the significand, and what was interpolated in float32 is off by
# less than that again.
DEPTH_RELATIVE, DEPTH_LEAST = 2.0**-17, 2.0**-19
DEPTH_MOST = 2.0**11  # 1/m; what is nearer is as near to it
LEAST_ALPHA = 0.5


def mesh(inputs: TwinInputs) -> ReferencePicture:
    """The nearest triangle on each shown ray, and the rendered colour where it is hit."""
    if inputs.settings.grid:
        return _hit(inputs, grid_surface(inputs.inverse_depth, inputs.settings.grid, inputs.settings.ring))
    return _seen(inputs, inputs.settings.cut)


def mesh_adaptive(inputs: TwinInputs) -> ReferencePicture:
    """As mesh.

    What merging may move, the tolerance, is added to what a place and an edge may be off by.

    Where large cells reach over pieces of cut ones, by at most twice the tolerance and 1/32, the
    colour may be the large cell's.
    """
    tolerance = inputs.settings.tolerance
    return _seen(inputs, "slope", tolerance, min(2 * tolerance + 1 / 32, 0.5))


@attrs.frozen(eq=False)
class _Hits:
    """Pairs of a triangle and a shown pixel whose ray hits it.

    pixel, triangle (n,): indices. place (n, 2): rendered pixels, where the colour is. depth (n,):
    shown inverse depth, slope (n,): what it changes by in a shown pixel on both axes. scale (n,):
    rendered pixels per shown one. doubtful (n,): rounding may unmake it. sure (n,): the ray stays
    within it however the rasteriser moves its edges.
    """

    pixel: np.ndarray
    triangle: np.ndarray
    place: Array
    depth: Array
    slope: Array
    scale: Array
    doubtful: np.ndarray
    sure: np.ndarray

    def only(self, which: np.ndarray) -> _Hits:
        return _Hits(*(getattr(self, field.name)[which] for field in attrs.fields(_Hits)))

    def coloured_by_owner(self, triangles: Surface) -> _Hits:
        """Places on pieces of a cut cell move to where the colour may be taken.

        Their pixel's centre, or along a joined edge from it.
        """
        owner, towards = triangles.owner[self.triangle], triangles.towards[self.triangle]
        away = towards * np.maximum((self.place - owner) * towards, 0)
        away[np.arange(len(away)), np.argmin(np.abs(away), axis=1)] = 0
        return attrs.evolve(self, place=np.where(np.isnan(owner), self.place, owner + away))


def _seen(inputs: TwinInputs, cut: str, tolerance: float = 0.0, overlap: float = 0.0) -> ReferencePicture:
    rendered, size = inputs.rendered, inputs.size
    limits = _steepest(rendered, size, inputs.settings.steepest_deg)
    triangles = surface(inputs.inverse_depth, limits, cut_by_slope=cut != "vertex")
    return _hit(inputs, triangles, limits if cut != "slope" else None, tolerance, overlap)


def _hit(
    inputs: TwinInputs,
    triangles: Surface,
    sheets_beyond: tuple[float, float] | None = None,
    tolerance: float = 0.0,
    overlap: float = 0.0,
) -> ReferencePicture:
    """What the rays hit of these triangles; sheets_beyond: the steepest that is no sheet."""

    def hits(offset: tuple[float, float], grown: float = 0.0, reach: float = 0.0) -> _Hits:
        found = _hits(inputs, triangles, cast, np.array(offset), grown, reach)
        if sheets_beyond is not None:
            return _nearest_first(
                _coloured(inputs.colour, _without_sheets(inputs, triangles, found, sheets_beyond, np.array(offset)))
            )
        return _nearest_first(_coloured(inputs.colour, found.coloured_by_owner(triangles)))

    cast, edge = _cast(inputs, triangles), EDGE_PIXELS + tolerance
    # Where merging moves nothing the rasteriser still does, and a crack may be narrower than what
    # merging may move.
    beside = [hits((x, y)) for far in sorted({EDGE_PIXELS, edge}) for x in (-far, far) for y in (-far, far)]
    centre = hits((0.0, 0.0))
    pieces = ~np.isnan(triangles.owner[centre.triangle, 0])
    picture = _picture(inputs, centre, beside, edge, centre.scale * tolerance + pieces * overlap)
    around = hits((0.0, 0.0), edge, overlap)
    unsure = _grazed(inputs, centre, around, edge) | _ajar(inputs, centre, around, triangles)
    return attrs.evolve(picture, undecided=picture.undecided | unsure.reshape(picture.undecided.shape))


def _steepest(rendered: View, size: tuple[int, int], angle_deg: float) -> tuple[float, float]:
    """Tangent of the angle times a pixel's share of the field of view's tangents."""
    left, right, down, up = rendered.fov.tangents
    return tuple(np.tan(np.deg2rad(angle_deg)) * np.array([(right - left) / size[0], (up - down) / size[1]]))


def _in_shown_pixels(inputs: TwinInputs, corners: Array) -> Array:
    """(n, 3, 3) corners as homogeneous pixels of the shown view, through the world."""
    left, right, down, up = inputs.rendered.fov.tangents
    x = left + (right - left) * corners[..., 0] / inputs.size[0]
    y = down + (up - down) * corners[..., 1] / inputs.size[1]
    directions = np.stack([x, y, -np.ones_like(x)], axis=-1) @ inputs.rendered.pose.rotation.as_matrix().T
    moved = inputs.rendered.pose.position_m - inputs.shown.pose.position_m
    eye = (directions + corners[..., 2:] * moved) @ inputs.shown.pose.rotation.as_matrix()
    left, right, down, up = inputs.shown.fov.tangents
    w = -eye[..., 2]
    u, v = (eye[..., 0] - left * w) / (right - left), (eye[..., 1] - down * w) / (up - down)
    return np.stack([u * inputs.shown_size[0], v * inputs.shown_size[1], w], axis=-1)


@attrs.frozen(eq=False)
class _Cast:
    """What of each triangle (n,) does not depend on where a ray is moved to.

    corners, lines (n, 3, 3): homogeneous shown pixels, and the lines through the edges, each
    opposite its corner. volume (n,), turned (n,): rounding may turn it away. a_pixel (n, 3): what
    weights change by in a pixel. along (n, 2, 2), summed (n, 2): for what places change by in one.
    slope (n,): what inverse depth does. whole (n,): no piece of a cut cell.
    """

    corners: Array
    lines: Array
    volume: Array
    turned: np.ndarray
    a_pixel: Array
    along: Array
    summed: Array
    slope: Array
    whole: np.ndarray


def _cast(inputs: TwinInputs, triangles: Surface) -> _Cast:
    corners, values = _in_shown_pixels(inputs, triangles.corners), triangles.corners
    a, b, c = (corners[:, k] for k in range(3))
    lines = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    volume = np.einsum("nk,nk->n", a, lines[:, 0])
    turned = np.abs(volume) <= _volume_error(inputs, values, corners, lines)
    across = lines[..., :2]
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.abs(np.einsum("nec,ne->nc", across, values[..., 2]) / volume[:, None]).sum(axis=1)
    along = np.einsum("nec,nek->nkc", across, values[..., :2])
    whole = np.isnan(triangles.owner[:, 0])
    return _Cast(corners, lines, volume, turned, np.abs(across).sum(axis=2), along, across.sum(axis=1), slope, whole)


def _hits(
    inputs: TwinInputs, triangles: Surface, cast: _Cast, offset: Array, grown: float = 0.0, reach: float = 0.0
) -> _Hits:
    """Rays through the shown pixels' centres moved by `offset` pixels.

    Triangles with each edge `grown` pixels farther out, and whole cells as if each were part of a
    large one, which reaches `reach` rendered pixels over its border.
    """
    which, pixels = _pairs(cast.corners, inputs.shown_size, offset, grown, reach * cast.whole)
    spans = np.einsum("nek,nk->ne", cast.lines[which], _rays(inputs, pixels, offset))  # weights times volume
    faces = (cast.volume > 0) | (cast.turned & (grown > 0))
    within = (spans >= -grown * cast.a_pixel[which]).all(axis=1)
    near = faces[which] & (spans.sum(axis=1) > 0) & (within | (cast.whole[which] & (reach > 0)))
    which, pixels, spans, within = which[near], pixels[near], spans[near], within[near]
    total, values = spans.sum(axis=1), triangles.corners[which]
    with np.errstate(divide="ignore", invalid="ignore"):
        place = np.einsum("ne,nek->nk", spans, values[..., :2]) / total[:, None]
        slopes = cast.along[which] - place[..., None] * cast.summed[which][:, None, :]
        scale = np.abs(slopes / total[:, None, None]).sum(axis=2).max(axis=1)
        depth = np.einsum("ne,ne->n", spans, values[..., 2]) / np.abs(cast.volume[which])
        beyond = np.maximum(values[..., :2].min(axis=1) - place, place - values[..., :2].max(axis=1)).max(axis=1)
        kept = within | (beyond <= reach + grown * scale)
        kept &= np.isfinite(place).all(axis=1) & np.isfinite(scale) & ~np.isnan(depth) & ~np.isnan(cast.slope[which])
        sure = (spans >= EDGE_PIXELS * cast.a_pixel[which]).all(axis=1)
    doubtful = triangles.doubtful[which] | cast.turned[which]
    return _Hits(pixels, which, place, depth, cast.slope[which], scale, doubtful, sure).only(kept)


def _volume_error(inputs: TwinInputs, points: Array, corners: Array, lines: Array) -> Array:
    """(n,): what a triangle's volume may be off by, whose sign says which way it faces.

    Each corner's error, of float32 as in docs/hard-cases.md and of the rasteriser, times the area
    that the other two span.
    """
    warp = WarpMap.between(inputs.rendered, inputs.size, inputs.shown, inputs.shown_size)
    places = np.concatenate([points[..., :2], np.ones((*points.shape[:-1], 1))], axis=-1)
    error = 8 * FLOAT32_UNIT * (places @ np.abs(warp.H).T + points[..., 2:] * np.abs(warp.e))
    error[..., :2] += EDGE_PIXELS * np.abs(corners[..., 2:])
    return np.einsum("nek,nek->n", error, np.abs(lines))


def _rays(inputs: TwinInputs, pixels: np.ndarray, offset: Array) -> Array:
    """Homogeneous shown pixels."""
    wide = inputs.shown_size[0]
    return np.stack([pixels % wide + 0.5 + offset[0], pixels // wide + 0.5 + offset[1], np.ones(len(pixels))], axis=-1)


def _pairs(
    corners: Array, shown_size: tuple[int, int], offset: Array, grown: float, reach: Array
) -> tuple[np.ndarray, np.ndarray]:
    """Triangles and the pixels of the box around each, grown by pixels and by twice (perspective)
    `reach` (n,) times itself; all pixels where a corner lies behind the eye.
    """
    wide, high = shown_size
    before = (corners[..., 2] > 0).all(axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        places = corners[..., :2] / corners[..., 2:]
        grown = grown + 2 * reach[:, None] * (places.max(axis=1) - places.min(axis=1))
    low = np.where(before[:, None], places.min(axis=1) - offset - 0.5 - grown, 0)
    upper = np.where(before[:, None], places.max(axis=1) - offset - 0.5 + grown, np.array([wide, high]))
    first = np.ceil(np.clip(low, 0, [wide, high])).astype(int)
    last = np.floor(np.clip(upper, -1, [wide - 1, high - 1])).astype(int)
    some = (corners[..., 2] > 0).any(axis=1)
    counts = np.where(some[:, None], np.maximum(last - first + 1, 0), 0)
    number = counts[:, 0] * counts[:, 1]
    which = np.repeat(np.arange(len(corners)), number)
    within = np.arange(number.sum()) - np.repeat(np.cumsum(number) - number, number)
    columns = np.maximum(counts[which, 0], 1)
    x, y = first[which, 0] + within % columns, first[which, 1] + within // columns
    return which, y * wide + x


def _without_sheets(
    inputs: TwinInputs, triangles: Surface, hits: _Hits, limits: tuple[float, float], offset: Array
) -> _Hits:
    """Without what has another depth than its nearest pixel and lies more than half a pixel from it
    at that pixel's own depth; what has another depth and is nearer than that gets the pixel's own
    colour.
    """
    rendered, size = inputs.rendered, inputs.size
    pixel = np.clip(np.floor(hits.place).astype(int), 0, np.array(size) - 1)
    own = known_depth(inputs.inverse_depth)[pixel[:, 1], pixel[:, 0]]
    # The surface's rendered depth at the hit, from the shown one: by the ray's length along both
    # views' axes.
    left, right, down, up = inputs.shown.fov.tangents
    places = _rays(inputs, hits.pixel, offset)[:, :2] / np.array(inputs.shown_size)
    tangents = places * np.array([right - left, up - down]) + np.array([left, down])
    rays = np.concatenate([tangents, -np.ones((len(tangents), 1))], axis=1) @ inputs.shown.pose.rotation.as_matrix().T
    moved = inputs.shown.pose.position_m - rendered.pose.position_m
    axis = rendered.pose.rotation.as_matrix() @ np.array([0.0, 0.0, -1.0])
    _, surface_depth, _ = project(rays, moved, hits.depth, rendered, size)
    with np.errstate(divide="ignore", invalid="ignore"):
        own_length = (rays @ axis) * own / (1 - own * (moved @ axis))
        away_point, _, _ = project(rays, moved, own_length, rendered, size)
        away = np.abs(away_point - pixel - 0.5).max(axis=1)
        slack = np.abs(hits.place - pixel - 0.5) @ np.array(limits) * np.minimum(own, surface_depth)
        difference = np.abs(surface_depth - own)
    error = 64 * FLOAT32_UNIT * (np.nan_to_num(surface_depth) + np.nan_to_num(own))
    far = 1e-3 * (1 + hits.scale)
    sheet = (difference > slack) & ~(away <= 0.5)
    unsure = (np.abs(difference - slack) <= error + far * max(limits) * np.nan_to_num(own)) | (
        np.abs(away - 0.5) <= far
    )
    border = np.abs(hits.place - np.round(hits.place)).min(axis=1) <= far  # which pixel is nearest
    doubtful = hits.doubtful | ((unsure | border) & (difference > 0))
    coloured = hits.coloured_by_owner(triangles).place
    place = np.where((difference > slack)[:, None], pixel + 0.5, coloured)
    return attrs.evolve(hits, place=place, doubtful=doubtful).only(~sheet | doubtful)


def _coloured(colour: Array, hits: _Hits) -> _Hits:
    """Without hits on what the rendered picture did not draw."""
    looked = ndimage.map_coordinates(
        colour[..., 3], [hits.place[:, 1] - 0.5, hits.place[:, 0] - 0.5], order=1, mode="nearest"
    )
    return hits.only(looked >= LEAST_ALPHA)


def _nearest_first(hits: _Hits) -> _Hits:
    """By pixel, then by depth; of equals the triangle that is drawn first."""
    return hits.only(np.lexsort((hits.triangle, -hits.depth, hits.pixel)))


def _winners(hits: _Hits, count: int) -> np.ndarray:
    """Index of each pixel's nearest hit, -1 for none."""
    leads = np.r_[True, hits.pixel[1:] != hits.pixel[:-1]] if len(hits.pixel) else np.zeros(0, bool)
    winner = np.full(count, -1)
    winner[hits.pixel[leads]] = np.flatnonzero(leads)
    return winner


def _picture(inputs: TwinInputs, hits: _Hits, beside: list[_Hits], edge: float, merged: Array) -> ReferencePicture:
    """What the rays hit.

    Undecided where a ray moved by what edges may be off hits another surface, or the next is as
    near.

    merged (n,): by how many rendered pixels each hit's place may be off where cells were merged.
    """
    shape = inputs.shown_size[::-1]
    count = shape[0] * shape[1]
    winner = _winners(hits, count)
    seen = winner >= 0
    place, scale = np.full((count, 2), np.nan), np.zeros(count)
    triangle = np.full(count, -1)
    place[seen], scale[seen], triangle[seen] = (
        hits.place[winner[seen]],
        hits.scale[winner[seen]],
        hits.triangle[winner[seen]],
    )
    # Places are interpolated as place / w and 1 / w from the picture's corner: a few roundings of
    # the place itself and of its slope times the shown place, in each.
    # Corners snapped by up to s in each axis move what is interpolated between them as far, in both
    # axes at once: 2 s of the slope.
    error = 16 * FLOAT32_UNIT * (max(inputs.size) + max(inputs.shown_size) * scale) + 2 * inputs.snap_pixels * scale
    error[seen] += merged[winner[seen]]
    undecided, beneath = _nearly_as_near(hits, winner, edge, count)
    error = np.maximum(error, beneath)
    for moved in beside:
        other = _winners(moved, count)
        hit = other >= 0
        apart, alike = np.zeros(count), np.zeros(count)
        both = hit & seen
        apart[both] = np.abs(moved.place[other[both]] - place[both]).max(axis=1)
        alike[both] = 2 * edge * (moved.scale[other[both]] + scale[both]) + 1e-3
        undecided |= (hit != seen) | (apart > alike)
        undecided[hit] |= moved.doubtful[other[hit]]
        error = np.maximum(error, _nearly_as_near(moved, other, edge, count)[1])
        changed = both & (triangle != moved.triangle[np.maximum(other, 0)] if len(moved.pixel) else both)
        error = np.where(changed, np.maximum(error, apart), error)
    out = sample_covered(inputs.colour, place.reshape(*shape, 2), error.reshape(shape), inputs.sampler_pixels)
    # Where nothing is hit nothing is near the rendered picture's border either.
    unsure = out.undecided & seen.reshape(shape)
    return ReferencePicture(out.colour, out.tolerance, undecided.reshape(shape) | unsure)


def _nearly_as_near(hits: _Hits, winner: np.ndarray, edge: float, count: int) -> tuple[np.ndarray, Array]:
    """Pixels where a hit elsewhere in the rendered picture, or a doubtful one, is as near as the
    nearest to the depth buffer; and how far from the nearest's place others are that lie on the
    same surface, where pieces of it overlap.
    """
    best = winner[hits.pixel]
    apart = np.abs(hits.place - hits.place[best]).max(axis=1)
    elsewhere = _elsewhere(apart, hits.scale, hits.scale[best], edge)
    near = _as_near(hits, hits, best, edge)
    marked = np.zeros(count, bool)
    marked[hits.pixel[near & (hits.doubtful | elsewhere)]] = True
    beneath = np.zeros(count)
    np.maximum.at(beneath, hits.pixel[near & ~elsewhere], apart[near & ~elsewhere])
    return marked, beneath


def _elsewhere(apart: Array, scale: Array, other_scale: Array, edge: float) -> np.ndarray:
    """Whether two places of the rendered picture are not one that was moved.

    A tolerance covers two pixels around, so one at the most.
    """
    return apart > np.minimum(2 * edge * (scale + other_scale) + 1e-3, 1.0)


def _as_near(hits: _Hits, others: _Hits, index: np.ndarray, edge: float) -> np.ndarray:
    """Whether the depth buffer may find a hit as near as another, others[index].

    A triangle that is moved takes its depth along, and is off by what the depth changes by in as
    much.
    """
    least = (others.depth - edge * others.slope)[index] * (1 - DEPTH_RELATIVE) - DEPTH_LEAST
    return hits.depth + edge * hits.slope >= np.minimum(least, DEPTH_MOST)


def _grazed(inputs: TwinInputs, hits: _Hits, around: _Hits, edge: float) -> np.ndarray:
    """(h * w,).

    Pixels that a triangle beside them may reach, though the four moved rays may miss it: slivers
    are thinner than the box between them.
    """
    count = inputs.shown_size[0] * inputs.shown_size[1]
    winner = _winners(hits, count)
    best = winner[around.pixel]
    out = np.zeros(count, bool)
    out[around.pixel[best < 0]] = True
    both = around.only(best >= 0)
    best = best[best >= 0]
    apart = np.abs(both.place - hits.place[best]).max(axis=1)
    elsewhere = _elsewhere(apart, both.scale, hits.scale[best], edge)
    out[both.pixel[_as_near(both, hits, best, edge) & (elsewhere | both.doubtful)]] = True
    return out


def _ajar(inputs: TwinInputs, hits: _Hits, around: _Hits, triangles: Surface) -> np.ndarray:
    """(h * w,): pixels at a seam that may stand open.

    Pieces share no corners with what is beside them and reach over it by OVERLAP rendered pixels,
    which closes the seam only where that is more than the rasteriser moves both.
    """
    count = inputs.shown_size[0] * inputs.shown_size[1]
    closed = np.zeros(count, bool)
    closed[hits.pixel[hits.sure]] = True
    open_ = ~np.isnan(triangles.owner[around.triangle, 0]) & (2 * EDGE_PIXELS * around.scale >= OVERLAP)
    out = np.zeros(count, bool)
    out[around.pixel[open_]] = True
    return out & ~closed
