"""Fields of view and views: one eye at one instant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property, lru_cache
from typing import Protocol

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import InputError
from .guard_band import GuardBand
from .pose import Pose

Guard = float | tuple[float, float] | GuardBand
_MAX_ANGLE = math.radians(89.5)  # tan = 114.6: beyond this a plane at z = -1 is no longer a picture


@attrs.frozen
class Fov:
    """Four half angles in radians, as in XrFovf; left and down are negative; may be asymmetric.

    Errors: InputError unless left < right, down < up and each within +-89.5 degrees.
    """

    left: float = attrs.field(converter=float)
    right: float = attrs.field(converter=float)
    down: float = attrs.field(converter=float)
    up: float = attrs.field(converter=float)

    def __attrs_post_init__(self) -> None:
        angles = (self.left, self.right, self.down, self.up)
        if not all(abs(a) <= _MAX_ANGLE for a in angles) or self.left >= self.right or self.down >= self.up:
            shown = ", ".join(f"{a:.6g}" for a in angles)
            raise InputError(
                f"no field of view: left, right, down, up = {shown} rad; needs left < right, down < up, within +-1.562"
            )

    @classmethod
    def symmetric(cls, horizontal_rad: float, vertical_rad: float) -> Fov:
        """Return the field of view of two full angles in radians."""
        return cls(-horizontal_rad / 2, horizontal_rad / 2, -vertical_rad / 2, vertical_rad / 2)

    @classmethod
    def from_tangents(cls, tangents: ArrayLike) -> Fov:
        """Return the field of view of the four tangents left, right, down, up."""
        return cls(*np.arctan(np.asarray(tangents, dtype=np.float64)))

    @classmethod
    def from_intrinsics(
        cls, fx: float, fy: float, cx: float, cy: float, width: int, height: int, *, centre: float = 0.0
    ) -> Fov:
        """Return the field of view of a camera without lens distortion.

        fx, fy: focal lengths in pixels; cx, cy: principal point, x to the right and y down. centre:
        the coordinate of the first pixel's middle: 0 as OpenCV, ROS and TUM have it; 0.5 where
        (0, 0) is the picture's corner, as for COLMAP, nerfstudio and OpenGL.
        Errors: InputError for focal lengths or sizes that are not above 0, and for a field of view
        that ends beyond +-89.5 degrees.
        Source: Hartley and Zisserman 2004, Multiple View Geometry, section 6.1.
        """
        numbers = (fx, fy, cx, cy, width, height, centre)
        if not all(math.isfinite(number) for number in numbers) or min(fx, fy, width, height) <= 0:
            shown = f"fx {fx:g}, fy {fy:g}, cx {cx:g}, cy {cy:g}, {width:g}x{height:g} pixels"
            raise InputError(f"no camera: {shown}: expected finite numbers, with fx, fy and the size above 0")
        left, up = cx + 0.5 - centre, cy + 0.5 - centre  # pixels from the picture's corner
        return cls.from_tangents((-left / fx, (width - left) / fx, -(height - up) / fy, up / fy))

    def intrinsics(self, size: tuple[int, int], *, centre: float = 0.0) -> tuple[float, float, float, float]:
        """Return (fx, fy, cx, cy) in pixels of a (w, h) picture: the inverse of from_intrinsics."""
        left, right, down, up = self.tangents.tolist()
        fx, fy = size[0] / (right - left), size[1] / (up - down)
        return fx, fy, -left * fx - 0.5 + centre, up * fy - 0.5 + centre

    @cached_property
    def tangents(self) -> NDArray[np.float64]:
        """(4,) left, right, down, up on the plane z = -1; read-only."""
        tangents = np.tan([self.left, self.right, self.down, self.up])
        tangents.flags.writeable = False
        return tangents

    def pixel_from_tangent(self, size: tuple[int, int]) -> NDArray[np.float64]:
        """Return the 3x3 matrix from tangent (x, y, 1) to pixel (px, py, 1) of a (w, h) picture.

        The origin is bottom left, pixel centres lie at i + 0.5.
        """
        left, right, down, up = self.tangents
        width, height = size
        sx, sy = width / (right - left), height / (up - down)
        return np.array([[sx, 0, -left * sx], [0, sy, -down * sy], [0, 0, 1.0]])

    def pixels_per_degree(self, size: tuple[int, int]) -> float:
        """Return the mean of both axes at the view's centre.

        The centre is tangent 0, or the nearest tangent inside.
        """
        left, right, down, up = self.tangents
        x, y = np.clip(0, left, right), np.clip(0, down, up)
        per_rad = [size[0] / (right - left) * (1 + x * x), size[1] / (up - down) * (1 + y * y)]
        return float(np.mean(per_rad) * math.pi / 180)

    def guarded(
        self, guard: Guard, size: tuple[int, int], least: tuple[int, int] = (0, 0)
    ) -> tuple[Fov, tuple[int, int]]:
        """Return a field of view enlarged by the guard band, and its size in pixels.

        Pixels per tangent stay the same. Whole pixels are added on each side (factors round up), so
        the pixel centres of the unguarded view are pixel centres of the guarded one, and an unmoved
        head loses nothing.
        guard: a factor in tangents, one for each axis, or a GuardBand.
        least: pad to this size, on the right and at the top.
        Errors: as GuardBand; InputError if the view leaves 89.5 degrees.
        """
        left, right, down, up = self.tangents.tolist()
        per_x, per_y = size[0] / (right - left), size[1] / (up - down)
        pad = GuardBand.of(guard).pads((left, right, down, up), size)
        pad[1] += max(0, least[0] - size[0] - pad[0] - pad[1])
        pad[3] += max(0, least[1] - size[1] - pad[2] - pad[3])
        if not any(pad):
            return self, size
        grown = (left - pad[0] / per_x, right + pad[1] / per_x, down - pad[2] / per_y, up + pad[3] / per_y)
        return Fov.from_tangents(grown), (size[0] + pad[0] + pad[1], size[1] + pad[2] + pad[3])


@attrs.frozen(eq=False)
class View:
    """One eye at one instant."""

    pose: Pose  # world_from_eye
    fov: Fov
    # head-locked content is seen with this; the head's origin is half way between the eyes
    head_from_eye: Pose = attrs.field(factory=Pose)

    def rays(self, size: tuple[int, int]) -> NDArray[np.float64]:
        """Return (h, w, 3) directions in eye space through the pixel centres.

        z = -1; the bottom row comes first.
        """
        left, right, down, up = self.fov.tangents
        x = left + (np.arange(size[0]) + 0.5) * (right - left) / size[0]
        y = down + (np.arange(size[1]) + 0.5) * (up - down) / size[1]
        xx, yy = np.meshgrid(x, y)
        return np.stack([xx, yy, -np.ones_like(xx)], axis=-1)


class Eyes(Protocol):
    """The places of the eyes in the head, and their fields of view.

    A headset's, or a runtime's, which may change.
    """

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return the view of each eye, the left one first."""


def guarded_eyes(views: Sequence[View], guard: Guard, size: tuple[int, int]) -> tuple[tuple[Fov, ...], tuple[int, int]]:
    """Return the fields of view of all eyes with a guard band, and the one size they share.

    Symmetric pairs have one size anyway; otherwise the smaller one is padded on the right and at
    the top.
    Errors: as Fov.guarded.
    """
    return _guarded_fovs(tuple(view.fov for view in views), GuardBand.of(guard), size)


@lru_cache(maxsize=64)  # every frame needs it for the same eyes
def _guarded_fovs(
    fovs: tuple[Fov, ...], guard: GuardBand, size: tuple[int, int]
) -> tuple[tuple[Fov, ...], tuple[int, int]]:
    sizes = [fov.guarded(guard, size)[1] for fov in fovs]
    largest = (max(w for w, _ in sizes), max(h for _, h in sizes))
    return tuple(fov.guarded(guard, size, largest)[0] for fov in fovs), largest
