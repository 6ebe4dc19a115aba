"""Pictures that are sharp in one rectangle and coarser beyond it, in two forms.

The axis-aligned form that streamers encode: columns and rows beside the sharp rectangle hold
several of the picture's. The other one: a coarse picture of everything, and the sharp rectangle
beside it. Source: Patney et al. 2016, Towards Foveated Rendering for Gaze-Tracked Virtual Reality
(what is seen of a coarse rim); Guenter et al. 2012, Foveated 3D Graphics (nested pictures, blended
where they meet); the piecewise-linear axes are those of Oculus' axis-aligned distorted transfer,
which ALVR uses too.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .view import Fov, Size, View

MOST_RIM = 16


@attrs.frozen(order=True)
class Fovea:
    """How large the sharp rectangle is, and how coarse the rim. Errors: InputError."""

    # Angle across, as if seen around the view's axis.
    degrees: float = 40.0
    # Pixels of the picture on each axis that one of the rim holds.
    rim: int = 4
    # Whether the sharp rectangle is a picture of its own, beside a coarse one of everything.
    inset: bool = False

    def __attrs_post_init__(self) -> None:
        if not 0 < self.degrees < 180:
            raise InputError(f"a sharp region of {self.degrees:g} degrees: expected more than 0 and less than 180")
        if not 2 <= self.rim <= MOST_RIM:
            raise InputError(f"a rim of {self.rim} pixels in one: expected 2 to {MOST_RIM}")

    def __str__(self) -> str:
        apart = ", drawn apart" if self.inset else ""
        return f"{self.degrees:g} degrees sharp{apart}, {self.rim} x {self.rim} pixels in one beyond"

    def sharp(self, fov: Fov, drawn: Size, size: Size) -> Size:
        """Return (w, h) of the sharp rectangle, at least, wherever the eye looks.

        fov, drawn: a view, and (w, h) pixels of it. size: of the picture, as dense, that is made
        coarser.
        """
        left, right, down, up = fov.tangents.tolist()
        across = 2 * math.tan(math.radians(self.degrees) / 2)
        # 1e-6: a field of view with a guard band is as dense but for its last bits.
        sides = (round(across * drawn[0] / (right - left) - 1e-6), round(across * drawn[1] / (up - down) - 1e-6))
        return min(max(sides[0], 1), size[0]), min(max(sides[1], 1), size[1])

    def small(self, fov: Fov, drawn: Size, size: Size) -> Size:
        """Return (w, h) of what is sent. fov, drawn, size: as of sharp."""
        return self._grid(self.sharp(fov, drawn, size), (0.0, 0.0), size).small

    def drawn_pixels(self, fov: Fov, drawn: Size, size: Size) -> int:
        """Return how many pixels the server draws. fov, drawn, size: as of sharp."""
        grid = self._grid(self.sharp(fov, drawn, size), (0.0, 0.0), size)
        return math.prod(size) if isinstance(grid, FoveaGrid) else math.prod(grid.coarse) + math.prod(grid.inset)

    def grid(self, view: View, size: Size) -> Grid:
        """Return the grid whose sharp rectangle is around where the eye looks, within the picture.

        view: of the picture of (w, h) pixels; its gaze, or straight ahead of the head.
        """
        x, y = view.fov.pixel_from_tangent(size)[:2] @ np.array([*gaze_tangent(view), 1.0])
        return self._grid(self.sharp(view.fov, size, size), (float(x), float(y)), size)

    def whole(self, size: Size) -> dict[str, object]:
        """Return the uniforms of a picture that came whole, as sharp everywhere."""
        if not self.inset:
            return FoveaGrid(size, 2, (0, 0), (0, 0)).uniforms
        # No width over which the inset would begin.
        return InsetGrid(size, 2, (0, 0), size).uniforms | {"inset_at": (0, 0), "of_rim": 1e6}

    def _grid(self, least: Size, centre: tuple[float, float], size: Size) -> Grid:
        if self.inset:
            w, h = (min(side + 2 * self.rim, most) for side, most in zip(least, size, strict=True))
            ends = zip(centre, (w, h), size, strict=True)
            # Even: GPUs choose a texture's level for two by two pixels at once.
            x, y = (2 * min(max(round((at - side / 2) / 2), 0), (most - side) // 2) for at, side, most in ends)
            return InsetGrid(size, self.rim, (x, y), (w, h))
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

    # (w, h) of the picture.
    size: Size
    rim: int
    # Columns of the rim at the left, rows below; and at the right, above.
    before: tuple[int, int]
    after: tuple[int, int]

    @property
    def sharp(self) -> tuple[int, int, int, int]:
        """The sharp rectangle: first column, first row, columns, rows, from the bottom left."""
        (w, h), (a, b), (c, d), rim = self.size, self.before, self.after, self.rim
        return a * rim, b * rim, w - (a + c) * rim, h - (b + d) * rim

    @property
    def cells(self) -> Size:
        """(w, h) of what shaders/lib/fovea.glsl describes."""
        return self.small

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


@attrs.frozen
class InsetGrid:
    """Where the coarse picture of everything and the inset lie, in one picture.

    The coarse one at the bottom left, the inset right of it or above, whichever is less.
    """

    # (w, h) of the whole picture.
    size: Size
    rim: int
    # The inset's first pixel in the whole picture, and its size.
    at: tuple[int, int]
    inset: Size

    @property
    def sharp(self) -> tuple[int, int, int, int]:
        """The sharp rectangle: first column, first row, columns, rows, from the bottom left.

        Around it the inset has one pixel of the rim, over which both pictures are blended.
        """
        (x, y), (w, h), rim = self.at, self.inset, self.rim
        return x + rim, y + rim, max(w - 2 * rim, 0), max(h - 2 * rim, 0)

    @property
    def coarse(self) -> Size:
        """(w, h) of the coarse picture, which may reach beyond the whole one."""
        return -(-self.size[0] // self.rim), -(-self.size[1] // self.rim)

    @property
    def cells(self) -> Size:
        """(w, h) of what shaders/lib/fovea.glsl describes."""
        return self.coarse

    @property
    def beside(self) -> tuple[int, int]:
        """Where the inset begins; even, as videos have colours of two by two pixels."""
        (w, h), (x, y) = self.coarse, self.inset
        w, h = w + w % 2, h + h % 2
        return (w, 0) if (w + x) * max(h, y) <= max(w, x) * (h + y) else (0, h)

    @property
    def small(self) -> Size:
        """(w, h) of the picture that holds both."""
        (w, h), (x, y) = self.coarse, self.beside
        w, h = max(w, x + self.inset[0]), max(h, y + self.inset[1])
        return w + w % 2, h + h % 2

    @property
    def uniforms(self) -> dict[str, object]:
        """The uniforms of shaders/lib/fovea.glsl for the coarse picture, and where the inset is."""
        named = {"picture_size": self.size, "small_size": self.coarse, "before": self.coarse, "rim": self.rim}
        inset = {"inset_from": self.at, "inset_size": self.inset, "inset_at": self.beside}
        return {**named, "sharp_from": self.size, "sharp": (0, 0), "of_rim": 1 / self.rim, **inset}

    def views(self, view: View) -> tuple[View, View]:
        """Return the views of the coarse picture and of the inset.

        Nothing is hidden of the inset, and a pixel of the coarse picture only if all it holds is.
        """
        (w, h), rim, (x, y) = self.coarse, self.rim, self.inset
        around = self._fov(view.fov, (-rim, -rim), (self.size[0] + 2 * rim, self.size[1] + 2 * rim))
        hidden = view.hidden and view.hidden.within(around)
        coarse = attrs.evolve(view, fov=self._fov(view.fov, (0, 0), (w * rim, h * rim)), hidden=hidden)
        return coarse, attrs.evolve(view, fov=self._fov(view.fov, self.at, (x, y)), hidden=None)

    def _fov(self, fov: Fov, first: tuple[int, int], count: Size) -> Fov:
        """Return the field of view of pixels of the whole picture."""
        left, right, down, up = fov.tangents.tolist()
        across, high = (right - left) / self.size[0], (up - down) / self.size[1]
        x, y = left + first[0] * across, down + first[1] * high
        return Fov.from_tangents((x, x + count[0] * across, y, y + count[1] * high))

    def numbers(self) -> NDArray[np.float64]:
        """Return the grid as a row of numbers."""
        return np.array([[*self.size, self.rim, *self.at, *self.inset, 1]], np.float64)


Grid = FoveaGrid | InsetGrid


def grid_of(numbers: NDArray[np.float64], small: Size) -> Grid:
    """Return the grid of a row of numbers. Errors: InputError for one that does not fit `small`."""
    if numbers.shape in ((1, 7), (1, 8)) and (numbers == np.floor(numbers)).all() and (numbers >= 0).all():
        w, h, rim, a, b, c, d, *apart = numbers[0].astype(int).tolist()
        made: Grid = InsetGrid((w, h), rim, (a, b), (c, d)) if apart else FoveaGrid((w, h), rim, (a, b), (c, d))
        within = a + c <= w and b + d <= h if isinstance(made, InsetGrid) else min(made.sharp) >= 0
        if 2 <= rim <= MOST_RIM and apart in ([], [1]) and within and made.small == small:
            return made
    raise InputError(f"a sharp rectangle of {numbers.tolist()} in a picture of {small[0]}x{small[1]} pixels")
