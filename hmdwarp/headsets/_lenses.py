"""Lenses: which direction of the view each place on a panel shows, for each colour."""

from __future__ import annotations

import math
from typing import ClassVar, Self

import attrs
import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import Fov
from ..options import Table

MAX_COEFFICIENTS = 9
MOST_POINTS = 257  # on a side of a mesh
COLOURS = ("red", "green", "blue")
Array = NDArray[np.float64]
Pair = tuple[float, float]


def refuse_unless_positive(**values: float) -> None:
    """Raise InputError for a value that is no number above 0."""
    for name, value in values.items():
        if not 0 < value < math.inf:
            raise InputError(f"{name} is {value:g}: expected a number above 0")


class _Round:
    """A lens that is round about an axis of each colour."""

    def centre(self, colour: str) -> Pair:
        """Return where a colour's axis lies beside the lens's own, in units."""
        return 0.0, 0.0

    def scales(self, colour: str, r: Array) -> Array:
        """Return the tangent that it shows at radius r from the colour's axis, over r, or NaN."""
        raise NotImplementedError

    def tangents(self, colour: str, on_lens: Array) -> Array:
        """Return the tangents (..., 2) of places (..., 2) in units; NaN where it shows nothing."""
        from_centre = on_lens - self.centre(colour)
        return np.asarray(from_centre * self.scales(colour, np.hypot(*np.moveaxis(from_centre, -1, 0)))[..., None])


@attrs.frozen
class _OneAxis(_Round):
    """A lens with one axis for all colours."""

    axis_from_centre_m: Pair  # where it meets the eye's panel, from the panel's middle
    unit_m: float  # of the radius

    def mirrored(self) -> Self:
        """Return the other eye's lens."""
        x, y = self.axis_from_centre_m
        return attrs.evolve(self, axis_from_centre_m=(-x, y))


@attrs.frozen
class RadialLens(_OneAxis):
    """Radial distortion: tangent = on_lens * tangent_per_unit * (k0 + k1 r^2 + k2 r^4 ..).

    The coefficients k differ by colour. r = |on_lens|; on_lens is the panel position from the lens
    axis in units of unit_m metres.

    Errors: InputError with the radius where the polynomial folds back.
    Source: Brown 1966, Decentering Distortion of Lenses, the radial part.
    """

    model: ClassVar[str] = "radial"

    tangent_per_unit: float
    coefficients: dict[str, tuple[float, ...]]
    reach: float  # the largest r on the panel, up to which the polynomial must grow

    @classmethod
    def of(cls, data: Table, axis: Pair, reach_m: float, fov: Fov, panel_m: Pair) -> RadialLens:
        """Return the lens of a file's table. reach_m: from the axis to the panel's corner."""
        unit_m, per_unit = data.number("unit_m"), data.number("tangent_per_unit")
        coefficients = {colour: data.numbers(colour) for colour in COLOURS}
        return cls(axis, unit_m, per_unit, coefficients, reach_m / unit_m if unit_m else 0.0)

    def scales(self, colour: str, r: Array) -> Array:
        return np.asarray(self.tangent_per_unit * polynomial.polyval(r * r, np.array(self.coefficients[colour])))

    def __attrs_post_init__(self) -> None:
        refuse_unless_positive(unit_m=self.unit_m, tangent_per_unit=self.tangent_per_unit, reach=self.reach)
        for colour in COLOURS:
            if not 1 <= len(self.coefficients[colour]) <= MAX_COEFFICIENTS:
                raise InputError(
                    f"lens colour {colour} has {len(self.coefficients[colour])} coefficients; "
                    f"expected 1 to {MAX_COEFFICIENTS}"
                )
            fold = self.folds_at(colour)
            if fold is not None:
                raise InputError(
                    f"the lens polynomial of {colour} folds back at r = {fold:.4g}, "
                    f"inside the panel (r up to {self.reach:.4g}): "
                    "two panel pixels would show the same direction; correct its coefficients"
                )

    def folds_at(self, colour: str) -> float | None:
        """Return the smallest r <= reach at which r times the polynomial stops growing, or None."""
        # d/dr of r (k0 + k1 r^2 + ..) as a polynomial in t = r^2 / reach^2, so that what matters
        # lies in 0..1.
        slope = [(2 * i + 1) * k * self.reach ** (2 * i) for i, k in enumerate(self.coefficients[colour])]
        if slope[0] <= 0:
            return 0.0
        while abs(slope[-1]) < 1e-13 * max(map(abs, slope)):  # polyroots divides by the last one
            slope.pop()
        roots = polynomial.polyroots(slope)
        turns = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0) & (roots.real <= 1)]
        # Next to a very large root polyroots may lose a very small one; a coarse scan along the
        # radius does not.
        t = np.linspace(0, 1, 1025)
        turns = np.append(turns, t[polynomial.polyval(t, slope) <= 0])
        return float(np.sqrt(turns.min())) * self.reach if len(turns) else None


@attrs.frozen
class TableLens(_OneAxis):
    """Angles from the axis against distances on the panel, joined by a monotone spline.

    Beyond the last distance the lens shows nothing.
    Errors: InputError for a table that does not grow.
    Source: Fritsch and Butland 1984, A Method for Constructing Local Monotone Piecewise Cubic
    Interpolants (SciPy's PCHIP).
    """

    model: ClassVar[str] = "table"

    angle_deg: tuple[float, ...]  # from 0 on
    distances: dict[str, tuple[float, ...]]  # of each colour, in unit_m, from 0 on

    def __attrs_post_init__(self) -> None:
        refuse_unless_positive(unit_m=self.unit_m)
        for name, values in {"angle_deg": self.angle_deg, **self.distances}.items():
            if len(values) != len(self.angle_deg) or len(values) < 2 or values[0] != 0:
                raise InputError(
                    f"lens table {name} has {len(values)} values from {values[0] if values else 'none'}: expected "
                    f"two or more from 0, as many as angle_deg has ({len(self.angle_deg)})"
                )
            for place, (low, high) in enumerate(zip(values, values[1:], strict=False)):
                if high <= low:
                    raise InputError(f"lens table {name} does not grow at {self.angle_deg[place + 1]:g} degrees")
        if self.angle_deg[-1] >= 89:
            raise InputError(f"lens table angle_deg ends at {self.angle_deg[-1]:g}: expected less than 89 degrees")

    @classmethod
    def of(cls, data: Table, axis: Pair, reach_m: float, fov: Fov, panel_m: Pair) -> TableLens:
        """Return the lens of a file's table: one `distance`, or one for each colour."""
        distances = {colour: data.numbers("distance" if "distance" in data else colour) for colour in COLOURS}
        return cls(axis, data.number("unit_m"), data.numbers("angle_deg"), distances)

    @property
    def reach(self) -> float:
        """The largest distance at which a colour is seen."""
        return max(values[-1] for values in self.distances.values())

    def scales(self, colour: str, r: Array) -> Array:
        from scipy.interpolate import PchipInterpolator

        spline = PchipInterpolator(self.distances[colour], np.radians(self.angle_deg), extrapolate=False)
        least = np.maximum(r, 1e-9)  # on the axis the slope, to 1e-9 of it
        return np.asarray(np.tan(spline(least)) / least)


@attrs.frozen
class ViveLens(_Round):
    """A rational polynomial around one centre for each colour, as SteamVR keeps it.

    tangent = place (1 / (1 + k1 r^2 + k2 r^4 + k3 r^6) + k4) / focal; the place is counted from the
    colour's centre, in half widths of the panel.
    Errors: InputError with the radius where it folds back within the cutoff.
    Source: Valve's description of "tracking_to_eye_transform" (DISTORT_DPOLY3).
    """

    model: ClassVar[str] = "vive"
    axis_from_centre_m: ClassVar[Pair] = (0.0, 0.0)  # centres are counted from the panel's middle
    unit_m: ClassVar[float] = 1.0

    focal: float
    centres: dict[str, Pair]  # y up
    coefficients: dict[str, tuple[float, float, float, float]]
    cutoff_r2: float  # beyond it nothing is shown

    def __attrs_post_init__(self) -> None:
        refuse_unless_positive(focal=self.focal, undistort_r2_cutoff=self.cutoff_r2)
        r = np.linspace(0, math.sqrt(self.cutoff_r2), 1025)
        for colour in COLOURS:
            k1, k2, k3, _ = self.coefficients[colour]
            shown = r * self.scales(colour, r)
            folds = (np.diff(shown) <= 0) | (polynomial.polyval(r[1:] ** 2, [1, k1, k2, k3]) <= 0)
            if folds.any():
                raise InputError(
                    f"the lens of {colour} folds back at r = {r[1:][folds][0]:.4g}, within its cutoff "
                    f"{r[-1]:.4g}: two panel pixels would show the same direction; correct its coeffs"
                )

    def centre(self, colour: str) -> Pair:
        return self.centres[colour]

    def mirrored(self) -> ViveLens:
        return attrs.evolve(self, centres={colour: (-x, y) for colour, (x, y) in self.centres.items()})

    def scales(self, colour: str, r: Array) -> Array:
        k1, k2, k3, k4 = self.coefficients[colour]
        return np.asarray((1 / polynomial.polyval(r * r, [1, k1, k2, k3]) + k4) / self.focal)


@attrs.frozen
class MeshLens:
    """The tangent that each point of a grid over the panel shows, bilinear between points.

    Errors: InputError for a mesh that folds back.
    Source: OpenVR, IVRSystem::ComputeDistortion, sampled on a grid.
    """

    model: ClassVar[str] = "mesh"
    axis_from_centre_m: ClassVar[Pair] = (0.0, 0.0)
    unit_m: ClassVar[float] = 1.0

    panel_m: Pair
    # Of each colour: rows from below, in them points from the left.
    points: dict[str, tuple[tuple[Pair, ...], ...]]

    @classmethod
    def of(cls, data: Table, axis: Pair, reach_m: float, fov: Fov, panel_m: Pair) -> MeshLens:
        """Return the lens of a file's table: one `uv` of the eye's view, or one for each colour."""
        columns, rows = (data.whole(side, 2, MOST_POINTS) for side in ("columns", "rows"))
        low, high = fov.tangents[::2], fov.tangents[1::2]
        points = {}
        for colour in COLOURS:
            numbers = data.numbers("uv" if "uv" in data else colour, 2 * columns * rows)
            points[colour] = _as_tuples(low + np.reshape(numbers, (rows, columns, 2)) * (high - low))
        return cls(panel_m, points)

    def __attrs_post_init__(self) -> None:
        for colour, points in self.points.items():
            grid = np.array(points)
            across, up = np.diff(grid, axis=1), np.diff(grid, axis=0)
            for right in (slice(None, -1), slice(1, None)):
                for above in (slice(None, -1), slice(1, None)):
                    x, y = across[above], up[:, right]
                    # Of a bilinear cell it is linear: above 0 at its corners, it is so everywhere.
                    folds = np.argwhere(x[..., 0] * y[..., 1] <= x[..., 1] * y[..., 0])
                    if len(folds):
                        row, column = folds[0]
                        raise InputError(
                            f"the lens mesh of {colour} folds back in the cell of row {row}, column {column}: "
                            "two panel pixels would show the same direction; correct its uv"
                        )

    def mirrored(self) -> MeshLens:
        turned = {colour: np.array(points)[:, ::-1] * (-1, 1) for colour, points in self.points.items()}
        return MeshLens(self.panel_m, {colour: _as_tuples(grid) for colour, grid in turned.items()})

    def tangents(self, colour: str, on_lens: Array) -> Array:
        """Return the tangents of places, in metres from the panel's middle."""
        grid = np.array(self.points[colour])
        at = (on_lens / self.panel_m + 0.5) * (grid.shape[1] - 1, grid.shape[0] - 1)
        low = np.clip(np.floor(at), 0, (grid.shape[1] - 2, grid.shape[0] - 2)).astype(int)
        (x, y), (s, t) = np.moveaxis(low, -1, 0), np.moveaxis(at - low, -1, 0)[..., None]
        below, above = ((1 - s) * grid[y + up, x] + s * grid[y + up, x + 1] for up in (0, 1))
        return np.asarray((1 - t) * below + t * above)


def _as_tuples(grid: Array) -> tuple[tuple[Pair, ...], ...]:
    return tuple(tuple((float(x), float(y)) for x, y in row) for row in grid)


# Each has a model, the name of the pass that corrects it in client/lens; the axis and the unit of
# places on it; mirrored(), the other eye's; and tangents() of places.
Lens = RadialLens | TableLens | ViveLens | MeshLens
# By what a file calls them.
MODELS: dict[str, type[RadialLens] | type[TableLens] | type[MeshLens]] = {
    "radial": RadialLens,
    "table": TableLens,
    "mesh": MeshLens,
}
