"""The warp map between two views: a homography plus a parallax term along the epipole."""

from __future__ import annotations

from functools import lru_cache

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .view import Fov, View

_FLIP_Z = np.diag([1.0, 1.0, -1.0])  # tangent point (x, y, 1) <-> eye point (x, y, -1)


@attrs.frozen(eq=False)
class WarpMap:
    """`p_to ~ H p_from + e * inverse_depth`, with p in homogeneous pixels.

    inverse_depth is in 1/m, measured in the from view. The third component of the result, w, is the
    ratio of the two depths along -z, so `inverse_depth_to = inverse_depth_from / w`; w <= 0 means
    the point lies beside or behind the `to` eye, outside any picture. Exact for inverse_depth 0
    (infinitely far), for a zero baseline (e = 0) and far from the world origin.

    Source: McMillan and Bishop 1995, Plenoptic Modeling, eq. 8-10 (the planar form of their warp).
    """

    H: NDArray[np.float64]  # (3, 3), read-only from `between`
    e: NDArray[np.float64]  # (3,), read-only from `between`

    @classmethod
    def between(cls, frm: View, frm_size: tuple[int, int], to: View, to_size: tuple[int, int]) -> WarpMap:
        """Return the map from pixels of `frm` (w, h) to pixels of `to`.

        Computed relative to the eyes in float64.
        """
        to_from_frm = frm.pose.relative_to(to.pose)
        k_to, _ = _cameras(to.fov, to_size)
        _, k_frm_inverse = _cameras(frm.fov, frm_size)
        made = cls(k_to @ to_from_frm.rotation_matrix @ k_frm_inverse, k_to @ to_from_frm.position_m)
        made.H.flags.writeable = made.e.flags.writeable = False
        return made

    def apply(
        self, pixels: ArrayLike, inverse_depth: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return pixels (..., 2), inverse depth (...) and w (...) in the other view.

        pixels: (..., 2); inverse_depth: (...). Where w <= 0 pixel and depth are NaN: the picture
        has no such point.
        """
        pixels = np.asarray(pixels, dtype=np.float64)
        inverse_depth = np.asarray(inverse_depth, dtype=np.float64)
        homogeneous = pixels @ self.H[:, :2].T + self.H[:, 2] + inverse_depth[..., None] * self.e
        w = homogeneous[..., 2]
        safe = np.where(w > 0, w, np.nan)
        return homogeneous[..., :2] / safe[..., None], inverse_depth / safe, w

    def moves_whole_pixels(self) -> bool:
        """Return whether every pixel centre lands on a pixel centre at any depth.

        That is, nothing moved, or only a guard band was cut off.
        """
        (a, b, x), (c, d, y), (f, g, h) = self.H.tolist()
        off = (a - 1, b, x - round(x), c, d - 1, y - round(y), f, g, h - 1, *self.e.tolist())
        # 1e-9 px over the widest picture a GPU takes: what rounding leaves of two equal poses, far
        # below any real motion.
        return bool(max(map(abs, off)) <= 1e-9)


@lru_cache(maxsize=64)  # a few fields of view and sizes, needed at every frame
def _cameras(fov: Fov, size: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return (3x3 from eye points (x, y, -1) to pixels, its inverse), read-only."""
    pixel_from_eye = fov.pixel_from_tangent(size) @ _FLIP_Z
    eye_from_pixel = np.asarray(np.linalg.inv(pixel_from_eye), np.float64)
    pixel_from_eye.flags.writeable = eye_from_pixel.flags.writeable = False
    return pixel_from_eye, eye_from_pixel
