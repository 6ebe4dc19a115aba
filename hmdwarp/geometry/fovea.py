"""Pictures that are sharp in one rectangle and coarser beyond: axis by axis, as streamers encode.

Source: Patney et al. 2016, Towards Foveated Rendering for Gaze-Tracked Virtual Reality (what is
seen of a coarse rim); the axes are those of Oculus' axis-aligned distorted transfer, as in ALVR.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import InputError
from .view import Fov, Size, View

MOST_RIM = 16


@attrs.frozen(order=True)
class Fovea:
    """How large the sharp rectangle is, and how coarse the rim. Errors: InputError."""

    degrees: float = 40.0  # Angle across, as if seen around the view's axis.
    rim: int = 4  # Pixels of the picture on each axis that one of the rim holds.

    def __attrs_post_init__(self) -> None:
        if not 0 < self.degrees < 180:
            raise InputError(f"a sharp region of {self.degrees:g} degrees: expected more than 0 and less than 180")
        if not 2 <= self.rim <= MOST_RIM:
            raise InputError(f"a rim of {self.rim} pixels in one: expected 2 to {MOST_RIM}")

    def __str__(self) -> str:
        return f"{self.degrees:g} degrees sharp, {self.rim} x {self.rim} pixels in one beyond"

    def sharp(self, fov: Fov, drawn: Size, size: Size) -> Size:
        """Return (w, h) of the sharp rectangle, at least, wherever the eye looks.

        fov: a view of (w, h) pixels `drawn`. size: of the picture, as dense, that is made coarser.
        """
        left, right, down, up = fov.tangents.tolist()
        across = 2 * math.tan(math.radians(self.degrees) / 2)
        # 1e-6: a field of view with a guard band is as dense but for its last bits.
        sides = (round(across * drawn[0] / (right - left) - 1e-6), round(across * drawn[1] / (up - down) - 1e-6))
        return min(max(sides[0], 1), size[0]), min(max(sides[1], 1), size[1])

    def small(self, fov: Fov, drawn: Size, size: Size) -> Size:
        """Return (w, h) of what is sent. fov, drawn, size: as of sharp."""
        return self._grid(self.sharp(fov, drawn, size), (0.0, 0.0), size).small

    def grid(self, view: View, size: Size) -> FoveaGrid:
        """Return the grid around where the eye looks, or straight ahead of the head."""
        x, y = view.fov.pixel_from_tangent(size)[:2] @ np.array([*gaze_tangent(view), 1.0])
        return self._grid(self.sharp(view.fov, size, size), (float(x), float(y)), size)

    def _grid(self, least: Size, centre: tuple[float, float], size: Size) -> FoveaGrid:
        coarse = [(side - sharp) // self.rim for side, sharp in zip(size, least, strict=True)]
        before = []
        for at, side, count in zip(centre, size, coarse, strict=True):
            sharp = side - count * self.rim
            before.append(min(max(round((at - sharp / 2) / self.rim), 0), count))
        return FoveaGrid(size, self.rim, (before[0], before[1]), (coarse[0] - before[0], coarse[1] - before[1]))


AHEAD = (0.0, 0.0, -1.0)  # of the head
_ASIDE = 1e-3  # a gaze nearly at a right angle to the view's axis, or behind it, is at its border


def gaze_tangent(view: View) -> tuple[float, float]:
    """Return the tangents of the view's gaze, or of straight ahead of the head."""
    gaze = AHEAD if view.gaze is None else view.gaze
    x, y, z = view.head_from_eye.rotation_matrix.T @ np.array(gaze)
    return float(x / max(-z, _ASIDE)), float(y / max(-z, _ASIDE))


def looking(views: Sequence[View], gaze: tuple[float, float, float] | None) -> Sequence[View]:
    """Return the views of eyes that look that way, see View; the same ones for None."""
    return views if gaze is None else tuple(attrs.evolve(view, gaze=gaze) for view in views)


@attrs.frozen
class FoveaGrid:
    """Which columns and rows of a picture each column and row of the coarser one holds."""

    size: Size  # (w, h) of the picture.
    rim: int
    before: tuple[int, int]  # Columns of the rim at the left, rows below; and at the right, above.
    after: tuple[int, int]

    @property
    def sharp(self) -> tuple[int, int, int, int]:
        """The sharp rectangle: first column, first row, columns, rows, from the bottom left."""
        (w, h), (a, b), (c, d), rim = self.size, self.before, self.after, self.rim
        return a * rim, b * rim, w - (a + c) * rim, h - (b + d) * rim

    @property
    def small(self) -> Size:
        """(w, h) of the coarser picture."""
        columns, rows = (a + b for a, b in zip(self.before, self.after, strict=True))
        return self.size[0] - columns * (self.rim - 1), self.size[1] - rows * (self.rim - 1)

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms of shaders/lib/fovea.glsl."""
        x, y, w, h = self.sharp
        named = {"picture_size": self.size, "small_size": self.small, "before": self.before, "rim": self.rim}
        return {**named, "sharp_from": (x, y), "sharp": (w, h), "of_rim": 1 / self.rim}

    def numbers(self) -> NDArray[np.float64]:
        """Return the grid as a row of numbers."""
        return np.array([[*self.size, self.rim, *self.before, *self.after]], np.float64)


def grid_of(numbers: NDArray[np.float64], small: Size) -> FoveaGrid:
    """Return the grid of a row of numbers. Errors: InputError for one that does not fit `small`."""
    if numbers.shape == (1, 7) and (numbers == np.floor(numbers)).all() and (numbers >= 0).all():
        w, h, rim, a, b, c, d = numbers[0].astype(int).tolist()
        made = FoveaGrid((w, h), rim, (a, b), (c, d))
        if 2 <= rim <= MOST_RIM and min(made.sharp) >= 0 and made.small == small:
            return made
    raise InputError(f"a sharp rectangle of {numbers.tolist()} in a picture of {small[0]}x{small[1]} pixels")
