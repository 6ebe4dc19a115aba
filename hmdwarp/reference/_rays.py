"""Pixels to rays to pixels, through the world, and how far a float32 evaluation of the warp map may be off."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry import View, WarpMap

Array = NDArray[np.float64]
FLOAT32_UNIT = 2.0**-24  # half the distance from 1 to the next float32


def world_directions(view: View, size: tuple[int, int]) -> Array:
    """(h, w, 3) directions in the world through the pixel centres, of length 1 along the view axis."""
    return view.rays(size) @ view.pose.rotation.as_matrix().T


def project(directions: Array, offset_m: Array, inverse_depth: Array, view: View, size: tuple[int, int]) -> tuple[Array, Array, Array]:
    """Where points at eye + direction / inverse_depth appear in `view`, whose eye lies at eye - offset_m.

    Returns pixel (..., 2), inverse depth there (...) and w (...), the depth ratio; NaN pixels where w <= 0. Points are scaled by
    inverse_depth, so that infinitely far ones (0) are directions.
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


def pixel_error_bound(warp: WarpMap, size: tuple[int, int], inverse_depth: Array) -> Array:
    """(h, w): how far, in pixels, the float32 evaluation of `warp` may lie from the exact one at each pixel of a (w, h) picture.

    Standard model: an inner product of four float32 terms with rounded entries is off by at most 6 u times the sum of the
    absolute terms (Higham 2002, section 3.1: 4 for the sum, 1 for the product, 1 for the entry); the row stepping of the
    shaders adds one more addition and one product (2 u). Dividing by w adds the relative error of w and 1 u.
    """
    x, y = np.meshgrid(np.arange(size[0]) + 0.5, np.arange(size[1]) + 0.5)
    p = np.stack([x, y, np.ones_like(x)], axis=-1)
    size_of_terms = p @ np.abs(warp.H).T + inverse_depth[..., None] * np.abs(warp.e)
    q = p @ warp.H.T + inverse_depth[..., None] * warp.e
    error = 8 * FLOAT32_UNIT * size_of_terms
    with np.errstate(divide="ignore", invalid="ignore"):
        w = np.abs(q[..., 2])
        position = np.abs(q[..., :2]) / w[..., None]
        # The denominator may itself be smaller by its error; below that the point is as good as beside the eye.
        safe = np.where(w > 2 * error[..., 2], w - error[..., 2], np.nan)
        bound = (error[..., :2] + position * error[..., 2:]) / safe[..., None] + FLOAT32_UNIT * position
    return np.nan_to_num(bound.max(axis=-1), nan=np.inf)
