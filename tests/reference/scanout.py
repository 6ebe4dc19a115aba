"""Twin of a warp that follows the scan-out. Every row has a view of its own, by SLERP, and is
handed to the warp's own twin alone."""

from __future__ import annotations

import math
from collections.abc import Callable

import attrs
import numpy as np

from hmdwarp.geometry import View
from reference._rays import Array, Places, pixel_centres, rays_through
from reference.picture import ReferencePicture, TwinInputs

Twin = Callable[[TwinInputs], ReferencePicture]

# A quadratic through t = 0, 1/2 and 1 leaves a function by at most |t (t - 1/2) (t - 1)| / 6 <= 1 /
# (72 sqrt 3) of its third derivative.
PARABOLA = 1 / (72 * math.sqrt(3))


def direction_error(first: View, last: View) -> float:
    """Radians.

    How far the direction of a pixel may be off at any row, for the parabola instead of the great
    arc.

    A direction on the arc is fixed + cos(a t) + sin(a t) parts of length 1 at most, so its third
    derivative is a^3 at most, a being the angle of the turn: 5 degrees (300 a second, 16.7 ms) make
    5.3e-6 rad, half a hundredth of a pixel at 1000 pixels per radian. Positions are linear in time
    and so is what the map makes of them: they have no error.
    """
    return PARABOLA * (first.pose.rotation.inv() * last.pose.rotation).magnitude() ** 3


def row_view(first: View, last: View, row: float, rows: int) -> View:
    """The view of a row counted from the bottom, which lights up last. Row 0 of a display of `rows`
    is shown at (rows - 1/2) / rows."""
    return View(first.pose.towards(last.pose, 1 - (row + 0.5) / rows), first.fov)


def scanned_out(inputs: TwinInputs, last: View, twin: Twin) -> ReferencePicture:
    """The picture of which the first row, at the top, is seen from inputs.shown, and later ones
    from there to `last`.

    Its rows are those of the shown view, or of inputs.places. The parabola of a matrix, with its
    two products and sums, rounds at most twice as far as the matrix itself.
    """
    places = inputs.places or Places(pixel_centres(inputs.shown_size))
    error = places.error + turned_pixels(inputs, places.pixels, direction_error(inputs.shown, last))
    pictures, rows = [], len(places.pixels)
    for row in range(rows):
        here = np.s_[row : row + 1]
        one = Places(places.pixels[here], error[here], 2 * places.rounding)
        pictures.append(twin(attrs.evolve(inputs, shown=row_view(inputs.shown, last, row, rows), places=one)))
    return ReferencePicture(
        *(
            np.concatenate([getattr(picture, part) for picture in pictures])
            for part in ("colour", "tolerance", "undecided")
        )
    )


def turned_pixels(inputs: TwinInputs, places: Array, angle: float) -> Array:
    """(h, w). By how many pixels of the shown view a turn by `angle` (radians, small) may move what
    is seen at `places`."""
    left, right, down, up = inputs.shown.fov.tangents
    per_tangent = np.max(np.array(inputs.shown_size) / np.array([right - left, up - down]))
    rays = rays_through(inputs.shown, inputs.shown_size, places)
    return angle * per_tangent * (rays**2).sum(axis=-1)  # d tan / d angle = 1 + tan^2
