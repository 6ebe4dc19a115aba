"""Pixels to rays to pixels, through the world, and how far a float32 evaluation of the warp map may
be off."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from hmdwarp.geometry import View, WarpMap

Array = NDArray[np.float64]
FLOAT32_UNIT = 2.0**-24  # half the distance from 1 to the next float32


@attrs.frozen(eq=False)
class Places:
    """Where in the shown view a picture looks, if not at the pixel centres: pixels (h, w, 2).

    error: how far off a shader's place may be, in pixels; rounding: by how much more than one map's
    its arithmetic may round.
    """

    pixels: Array
    error: Array | float = 0.0
    rounding: float = 1.0


def world_directions(view: View, size: tuple[int, int], at: Array | None = None) -> Array:
    """(h, w, 3) directions in the world through the pixel centres, or the pixels `at`, of length 1
    along the view axis."""
    rays = view.rays(size) if at is None else rays_through(view, size, at)
    return rays @ view.pose.rotation.as_matrix().T


def pixel_centres(size: tuple[int, int]) -> Array:
    """(h, w, 2) of a (w, h) picture."""
    return np.stack(np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5), axis=-1)


def rays_through(view: View, size: tuple[int, int], at: Array) -> Array:
    """(..., 3) directions in the eye through pixels (..., 2) of a (w, h) picture, z = -1."""
    left, right, down, up = view.fov.tangents
    tangents = np.array([left, down]) + at / np.array(size) * np.array([right - left, up - down])
    return np.concatenate([tangents, -np.ones((*tangents.shape[:-1], 1))], axis=-1)


def project(
    directions: Array, offset_m: Array, inverse_depth: Array, view: View, size: tuple[int, int]
) -> tuple[Array, Array, Array]:
    """Where points at eye + direction / inverse_depth appear in `view`, whose eye lies at eye -
    offset_m.

    Returns pixel (..., 2), inverse depth there (...) and w (...), the depth ratio; NaN pixels where
    w <= 0. Points are scaled by inverse_depth, so that infinitely far ones (0) are directions.
    """
    scaled = directions + offset_m * inverse_depth[..., None]
    in_eye = scaled @ view.pose.rotation.as_matrix()  # rotates world to eye: row vectors times R are R^T times columns
    w = -in_eye[..., 2]
    before = np.where(w > 0, w, np.nan)
    tangent = in_eye[..., :2] / before[..., None]
    left, right, down, up = view.fov.tangents
    u = (tangent[..., 0] - left) / (right - left)
    v = (tangent[..., 1] - down) / (up - down)
    return np.stack([u * size[0], v * size[1]], axis=-1), inverse_depth / before, w


def pixel_error_bound(
    warp: WarpMap, size: tuple[int, int], inverse_depth: Array, places: Places | None = None
) -> Array:
    """(h, w).

    How far, in pixels, the float32 evaluation of `warp` may lie from the exact one at each pixel of
    a (w, h) picture.

    Standard model: an inner product of four float32 terms with rounded entries is off by at most 6
    u times the sum of the absolute terms (Higham 2002, section 3.1: 4 for the sum, 1 for the
    product, 1 for the entry); the row stepping of the shaders adds one more addition and one
    product (2 u). Dividing by w adds the relative error of w and 1 u. An error of the place itself
    is carried by the map's derivative, (H_xy - position H_w) / w.
    """
    if places is None:
        places = Places(pixel_centres(size))
    p = np.concatenate([places.pixels, np.ones((*places.pixels.shape[:-1], 1))], axis=-1)
    size_of_terms = p @ np.abs(warp.H).T + inverse_depth[..., None] * np.abs(warp.e)
    q = p @ warp.H.T + inverse_depth[..., None] * warp.e
    error = 8 * places.rounding * FLOAT32_UNIT * size_of_terms
    with np.errstate(divide="ignore", invalid="ignore"):
        w = np.abs(q[..., 2])
        position = np.abs(q[..., :2]) / w[..., None]
        # The denominator may itself be smaller by its error; below that the point is as good as
        # beside the eye.
        safe = np.where(w > 2 * error[..., 2], w - error[..., 2], np.nan)
        bound = (error[..., :2] + position * error[..., 2:]) / safe[..., None] + FLOAT32_UNIT * position
        stretch = (np.abs(warp.H[:2, :2]).sum(axis=-1) + position * np.abs(warp.H[2, :2]).sum()) / safe[..., None]
        bound += stretch * np.asarray(places.error)[..., None]
    return np.nan_to_num(bound.max(axis=-1), nan=np.inf)
