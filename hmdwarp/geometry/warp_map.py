"""The warp map between two views: a homography plus a parallax term along the epipolar direction."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from .view import View

_FLIP_Z = np.diag([1.0, 1.0, -1.0])  # tangent point (x, y, 1) <-> eye point (x, y, -1)


@attrs.frozen(eq=False)
class WarpMap:
    """`p_to ~ H p_from + e * inverse_depth`, p in homogeneous pixels, inverse_depth in 1/m measured in the from view.

    H: (3, 3). e: (3,). The third component of the result, w, is the ratio of the two depths along -z, so
    `inverse_depth_to = inverse_depth_from / w`; w <= 0 means the point lies beside or behind the `to` eye, where no picture is.
    Exact for inverse_depth 0 (infinitely far), for a zero baseline (e = 0) and far from the world origin.
    Source: McMillan and Bishop 1995, Plenoptic Modeling, eq. 8-10 (the planar form of their warp).
    """

    H: NDArray[np.float64]
    e: NDArray[np.float64]

    @classmethod
    def between(cls, frm: View, frm_size: tuple[int, int], to: View, to_size: tuple[int, int]) -> WarpMap:
        """The map from pixels of `frm` (w, h) to pixels of `to`, computed relative to the eyes in float64."""
        to_from_frm = frm.pose.relative_to(to.pose)
        k_to = to.fov.pixel_from_tangent(to_size) @ _FLIP_Z
        k_frm = frm.fov.pixel_from_tangent(frm_size) @ _FLIP_Z
        return cls(k_to @ to_from_frm.rotation.as_matrix() @ np.linalg.inv(k_frm), k_to @ to_from_frm.position_m)

    def apply(self, pixels: ArrayLike, inverse_depth: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Pixels (..., 2) and inverse depth (...) to pixels (..., 2), inverse depth (...) and w (...) in the other view.

        Where w <= 0 the pixel and the depth are NaN: there is no such point in the picture.
        """
        pixels = np.asarray(pixels, dtype=np.float64)
        inverse_depth = np.asarray(inverse_depth, dtype=np.float64)
        homogeneous = pixels @ self.H[:, :2].T + self.H[:, 2] + inverse_depth[..., None] * self.e
        w = homogeneous[..., 2]
        safe = np.where(w > 0, w, np.nan)
        return homogeneous[..., :2] / safe[..., None], inverse_depth / safe, w

    def moves_whole_pixels(self) -> bool:
        """Whether every pixel centre lands on a pixel centre at any depth: nothing moved, or only a guard band was cut off."""
        shift = np.round(self.H[:2, 2])
        wanted = np.array([[1, 0, shift[0]], [0, 1, shift[1]], [0, 0, 1.0]])
        # 1e-9 px over the widest picture a GPU takes: what rounding leaves of two equal poses, far below any real motion.
        return bool(np.abs(self.H - wanted).max() <= 1e-9 and np.abs(self.e).max() <= 1e-9)
