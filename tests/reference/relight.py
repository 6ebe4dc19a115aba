"""Twin of fill `relight`.

Planes by solving for three of their points, blocks by reshaping, samples one after the other over
all holes.
"""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import Fov
from reference._rays import Array

FLOOR = 0.02  # 1/m


@attrs.frozen(eq=False)
class Relit:
    """What the fill goes by; all pictures (h, w, ..) bottom row first, rgb linear.

    warped: (h, w, 4), coverage in alpha. inverse_depth: its depth, -1 unknown. albedo, lit,
    model_inverse_depth: the model's. offsets: (n, 2) whole pixels. The rest: as the shader's
    uniforms of these names.
    """

    fov: Fov
    warped: Array
    inverse_depth: Array
    albedo: Array
    lit: Array
    model_inverse_depth: Array
    offsets: NDArray[np.integer]
    block: int
    same_depth: float
    same_surface: float
    near: float
    off_plane: float
    model_weight: float

    @property
    def tangents(self) -> Array:
        """(h, w, 2) of the pixel centres."""
        left, right, down, up = self.fov.tangents
        high, wide = self.inverse_depth.shape
        x, y = (
            left + (np.arange(wide) + 0.5) * (right - left) / wide,
            down + (np.arange(high) + 0.5) * (up - down) / high,
        )
        return np.stack(np.meshgrid(x, y), axis=-1)


def relight(inputs: Relit) -> Array:
    """(h, w, 4) without holes."""
    lights = _lights(inputs)
    rows, columns = np.nonzero(inputs.warped[..., 3] == 0)
    depth = inputs.model_inverse_depth[rows, columns]
    tangent = inputs.tangents[rows, columns]
    normal = _normals(tangent, depth, *_beside(inputs, rows, columns))
    point = _points(tangent, depth)
    seen, plain = np.zeros((len(rows), 3)), np.zeros((len(rows), 3))
    high, wide = inputs.inverse_depth.shape
    for x, y in inputs.offsets:
        inside = (rows + y >= 0) & (rows + y < high) & (columns + x >= 0) & (columns + x < wide)
        at = np.where(inside, rows + y, 0) // inputs.block, np.where(inside, columns + x, 0) // inputs.block
        way = (lights.point[at] - point) * (depth + FLOOR)[:, None]
        distance, off = np.linalg.norm(way, axis=1) / inputs.near, (way * normal).sum(axis=1) / inputs.off_plane
        weight = (
            inside
            * np.maximum((normal * lights.normal[at]).sum(axis=1), 0) ** 4
            / (1 + distance**2) ** 2
            / (1 + off**2)
        )
        seen += weight[:, None] * lights.seen[at]
        plain += weight[:, None] * lights.plain[at]
    out = inputs.warped.copy()
    of_model = inputs.model_weight * inputs.lit[rows, columns, :3]
    out[rows, columns, :3] = (inputs.albedo[rows, columns, :3] * seen + of_model) / (plain + inputs.model_weight)
    out[rows, columns, 3] = 1
    return out


@attrs.frozen(eq=False)
class _Lights:
    """Of each block: mean colour, mean albedo, (x, y, z) in metres, unit normal.

    (rows, columns, 3) each.
    """

    seen: Array
    plain: Array
    point: Array
    normal: Array


def _lights(inputs: Relit) -> _Lights:
    shown, model = inputs.inverse_depth, inputs.model_inverse_depth
    agree = (shown >= 0) & (np.abs(shown - model) <= inputs.same_depth * (np.minimum(shown, model) + FLOOR))
    depth = _blocks(np.where(agree, model, np.nan), inputs.block, np.nan)
    with np.errstate(all="ignore"):
        farthest = np.where(np.isnan(depth), np.inf, depth).min(axis=(2, 3), keepdims=True)
        counts = depth <= farthest + inputs.same_surface * (farthest + FLOOR)
    depth = np.where(counts, depth, np.nan)
    number = np.maximum(counts.sum(axis=(2, 3)), 1)[..., None]

    def total(picture: Array) -> Array:
        return np.where(counts[..., None], _blocks(picture, inputs.block, 0.0), 0).sum(axis=(2, 3))

    tangent = total(inputs.tangents) / number
    mean = np.nansum(depth, axis=(2, 3)) / number[..., 0]
    step = inputs.tangents[-1, -1] - inputs.tangents[0, 0]
    high, wide = shown.shape
    step = step / np.maximum([wide - 1, high - 1], 1) if min(wide, high) > 1 else _one_pixel(inputs)
    ahead, above = (_mean_slope(np.diff(depth, axis=axis)) for axis in (3, 2))
    normal = _normals(tangent, mean, (step[0], mean + ahead), (step[1], mean + above))
    area = inputs.block**2
    return _Lights(
        total(inputs.warped[..., :3]) / area, total(inputs.albedo[..., :3]) / area, _points(tangent, mean), normal
    )


def _one_pixel(inputs: Relit) -> Array:
    left, right, down, up = inputs.fov.tangents
    high, wide = inputs.inverse_depth.shape
    return np.array([(right - left) / wide, (up - down) / high])


def _blocks(picture: Array, block: int, empty: float) -> Array:
    """(h, w, ..) to (rows, columns, block, block, ..)."""
    high, wide = picture.shape[:2]
    rest = ((0, 0),) * (picture.ndim - 2)
    padded = np.pad(picture, ((0, -high % block), (0, -wide % block), *rest), constant_values=empty)
    return padded.reshape(
        padded.shape[0] // block, block, padded.shape[1] // block, block, *picture.shape[2:]
    ).swapaxes(1, 2)


def _mean_slope(steps: Array) -> Array:
    """Of the steps between neighbours that both count; 0 where there are none."""
    return np.nansum(steps, axis=(2, 3)) / np.maximum((~np.isnan(steps)).sum(axis=(2, 3)), 1)


def _points(tangent: Array, depth: Array) -> Array:
    return np.concatenate([tangent, -np.ones((*depth.shape, 1))], axis=-1) / (depth + FLOOR)[..., None]


def _beside(inputs: Relit, rows: Array, columns: Array) -> tuple[tuple[float, Array], tuple[float, Array]]:
    """For x and y.

    The way to the neighbour whose inverse depth is nearer to the pixel's own, and what that is,
    prolonged through it.
    """
    found = []
    for axis, (at, step) in enumerate(zip((columns, rows), _one_pixel(inputs), strict=True)):
        picture = inputs.model_inverse_depth if axis == 0 else inputs.model_inverse_depth.T
        across = rows if axis == 0 else columns
        own, last = picture[across, at], picture.shape[1] - 1
        back, ahead = own - picture[across, np.maximum(at - 1, 0)], picture[across, np.minimum(at + 1, last)] - own
        take = (at == 0) | ((at < last) & (np.abs(ahead) <= np.abs(back)))
        found.append((step, own + np.where(take, ahead, back)))
    return found[0], found[1]


def _normals(tangent: Array, depth: Array, beside: tuple[float, Array], above: tuple[float, Array]) -> Array:
    """Unit normals of planes through three points each: m .

    (x, y, -1) is their inverse depth, so m solves three equations.
    """
    corner = np.concatenate([tangent, -np.ones((*depth.shape, 1))], axis=-1)
    rows = np.stack([corner, corner + [beside[0], 0, 0], corner + [0, above[0], 0]], axis=-2)
    solved = np.linalg.solve(rows, np.stack([depth, beside[1], above[1]], axis=-1)[..., None])[..., 0]
    size = np.linalg.norm(solved, axis=-1, keepdims=True)
    return np.where(size > 1e-9, solved / np.maximum(size, 1e-30), (0.0, 0.0, -1.0))
