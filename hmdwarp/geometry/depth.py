"""Depth in other conventions to inverse depth (1/m along -z, 0 infinitely far) and back."""

from __future__ import annotations

import math

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import InputError
from .pose import floats, real

HALF_STEP = 0.5 / (2**16 - 1)  # of a 16-bit buffer, the coarsest in use


def inverse_depth_from_metres(depth_m: ArrayLike) -> NDArray[np.float64]:
    """Return the inverse depth of metres along -z.

    inf gives 0; 0, negative and NaN (no depth) give NaN, which is never spread.
    """
    depth = np.asarray(depth_m, dtype=np.float64)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        inverse = 1.0 / depth
    # A depth below 1/float32 max would be an infinite inverse depth on the GPU: it counts as none.
    return np.where((depth > 0) & (inverse <= np.finfo(np.float32).max), inverse, np.nan)


def metres_from_inverse_depth(inverse_depth: ArrayLike) -> NDArray[np.float64]:
    """Return metres along -z; 0 gives inf, NaN stays NaN."""
    inverse = np.asarray(inverse_depth, dtype=np.float64)
    with np.errstate(divide="ignore"):
        return np.where(inverse == 0, np.inf, 1.0 / inverse)


@attrs.frozen
class DepthLayer:
    """How a depth buffer encodes distance: the four numbers of XR_KHR_composition_layer_depth.

    The value d runs linearly in 1/z from min_depth, at near_z, to max_depth, at far_z. OpenGL with
    a 0..1 buffer is (0, 1, near, far); -1..1 NDC is (-1, 1, near, far); reversed with infinite far
    is (0, 1, inf, near).

    Source: OpenXR 1.1 specification, XrCompositionLayerDepthInfoKHR.

    Parameters
    ----------
    min_depth, max_depth : float
        The range of values, within 0 to 1, or -1 to 1 for NDC.
    near_z, far_z : float
        Metres, above 0; near_z > far_z means reversed; either may be inf.

    Raises
    ------
    InputError
        For planes that are equal, negative or NaN, and for an empty range.
    """

    min_depth: float = attrs.field(default=0.0, converter=real)
    max_depth: float = attrs.field(default=1.0, converter=real)
    near_z: float = attrs.field(default=0.1, converter=real)
    far_z: float = attrs.field(default=math.inf, converter=real)

    def __attrs_post_init__(self) -> None:
        if not (self.near_z > 0 and self.far_z > 0) or self.near_z == self.far_z:
            wanted = "expected two different positive distances (inf allowed)"
            raise InputError(f"depth planes near {self.near_z}, far {self.far_z}: {wanted}")
        if not (-1 <= self.min_depth < self.max_depth <= 1):
            wanted = "expected min < max within 0..1 (or -1..1 for clip space)"
            raise InputError(f"depth range {self.min_depth}..{self.max_depth}: {wanted}")

    def inverse_depth(self, d: ArrayLike) -> NDArray[np.float64]:
        """Return the inverse depth, in 1/m, of buffer values.

        Values outside min_depth..max_depth and NaN give NaN (no depth). An end of the range that a
        16-bit or float32 buffer has rounded outwards still counts as that end.
        """
        span = self.max_depth - self.min_depth
        share = (floats(d) - self.min_depth) / span
        slack = min(HALF_STEP / span, 0.01)
        within = np.clip(share, 0, 1)
        inverse = (1 - within) / self.near_z + within / self.far_z
        return np.where((share >= -slack) & (share <= 1 + slack), inverse, np.nan)

    def encode(self, inverse_depth: ArrayLike) -> NDArray[np.float64]:
        """Return the buffer values of inverse depths, clamped to the planes as clipping would."""
        near, far = 1 / self.near_z, 1 / self.far_z
        share = (near - floats(inverse_depth)) / (near - far)
        return self.min_depth + np.clip(share, 0, 1) * (self.max_depth - self.min_depth)
