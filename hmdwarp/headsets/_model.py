"""A headset as a model: two eyes with a panel and a lens each, or a camera in their place."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar, Self

import attrs
import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from ..base import InputError, Table
from ..geometry import Fov, Hidden, Polygon, Pose, View

MAX_COEFFICIENTS = 9
COLOURS = ("red", "green", "blue")
Array = NDArray[np.float64]
Pair = tuple[float, float]


def _refuse_unless_positive(**values: float) -> None:
    """Raise InputError for a value that is no number above 0."""
    for name, value in values.items():
        if not 0 < value < math.inf:
            raise InputError(f"{name} is {value:g}: expected a number above 0")


_RADII = 1 << 16  # that a lens is checked at: a fold between two of them is a hundredth of a pixel


@attrs.frozen
class _Round:
    """A lens that is round about an axis of each colour."""

    axis_from_centre_m: Pair  # where its axis meets the eye's panel, from the panel's middle
    unit_m: float  # of the radius
    # Where a colour's axis lies beside the lens's own, in units; y up.
    centres: dict[str, Pair] = attrs.field(factory=lambda: dict.fromkeys(COLOURS, (0.0, 0.0)), kw_only=True)

    def scales(self, colour: str, r: Array) -> Array:
        """Return the tangent that it shows at radius r from the colour's axis, over r, or NaN."""
        raise NotImplementedError

    def tangents(self, colour: str, on_lens: Array) -> Array:
        """Return the tangents (..., 2) of places (..., 2) in units; NaN where it shows nothing."""
        from_centre = on_lens - self.centres[colour]
        return np.asarray(from_centre * self.scales(colour, np.hypot(*np.moveaxis(from_centre, -1, 0)))[..., None])

    def mirrored(self) -> Self:
        """Return the other eye's lens."""
        (x, y), centres = self.axis_from_centre_m, {colour: (-a, b) for colour, (a, b) in self.centres.items()}
        return attrs.evolve(self, axis_from_centre_m=(-x, y), centres=centres)

    @np.errstate(all="ignore")
    def _refuse_folds(self, reach: float) -> None:
        """Raise InputError if a colour's tangents do not grow up to that radius."""
        for colour in COLOURS:
            r = np.linspace(0, reach, _RADII)
            for _ in range(2):  # the second time finely around where they stop
                scales = self.scales(colour, r)
                grows = (scales[:-1] > 0) & (np.diff(r * scales) > 0)
                if grows.all():
                    break
                fold = int(grows.argmin())
                at, r = r[fold], np.linspace(r[max(0, fold - 1)], r[fold + 1], _RADII)
            else:
                why = "two panel pixels would show the same direction; correct its coefficients"
                raise InputError(f"the lens of {colour} folds back at r = {at:.4g}, within {reach:.4g}: {why}")


@attrs.frozen
class RadialLens(_Round):
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
    def of(cls, data: Table, axis: Pair, reach_m: float) -> RadialLens:
        """Return the lens of a file's table. reach_m: from the axis to the panel's corner."""
        unit_m, per_unit = data.number("unit_m"), data.number("tangent_per_unit")
        coefficients = {colour: data.numbers(colour) for colour in COLOURS}
        return cls(axis, unit_m, per_unit, coefficients, reach_m / unit_m if unit_m else 0.0)

    def __attrs_post_init__(self) -> None:
        _refuse_unless_positive(unit_m=self.unit_m, tangent_per_unit=self.tangent_per_unit, reach=self.reach)
        for colour, terms in self.coefficients.items():
            if not 1 <= len(terms) <= MAX_COEFFICIENTS:
                raise InputError(f"lens {colour} has {len(terms)} coefficients: expected 1 to {MAX_COEFFICIENTS}")
        self._refuse_folds(self.reach)

    def scales(self, colour: str, r: Array) -> Array:
        return np.asarray(self.tangent_per_unit * polynomial.polyval(r * r, np.array(self.coefficients[colour])))


@attrs.frozen
class TableLens(_Round):
    """Angles from the axis against distances on the panel, joined by a monotone spline.

    Beyond the last distance the lens shows nothing.
    Errors: InputError for a table that does not grow.
    Source: Fritsch and Butland 1984, Local Monotone Piecewise Cubic Interpolants (SciPy's PCHIP).
    """

    model: ClassVar[str] = "table"

    angle_deg: tuple[float, ...]  # from 0 on
    distances: dict[str, tuple[float, ...]]  # of each colour, in unit_m, from 0 on

    @classmethod
    def of(cls, data: Table, axis: Pair, reach_m: float) -> TableLens:
        distances = {colour: data.numbers("distance" if "distance" in data else colour) for colour in COLOURS}
        return cls(axis, data.number("unit_m"), data.numbers("angle_deg"), distances)

    def __attrs_post_init__(self) -> None:
        _refuse_unless_positive(unit_m=self.unit_m)
        for name, values in {"angle_deg": self.angle_deg, **self.distances}.items():
            if len(values) != len(self.angle_deg) or len(values) < 2 or values[0] != 0:
                wanted = f"two or more from 0, as many as angle_deg has ({len(self.angle_deg)})"
                found = f"{len(values)} values from {values[0] if values else 'none'}"
                raise InputError(f"lens table {name} has {found}: expected {wanted}")
            if (falls := np.diff(values) <= 0).any():
                place = self.angle_deg[falls.argmax() + 1]
                raise InputError(f"lens table {name} does not grow at {place:g} degrees")
        if self.angle_deg[-1] >= 89:
            raise InputError(f"lens table angle_deg ends at {self.angle_deg[-1]:g}: expected less than 89 degrees")

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

    focal: float
    coefficients: dict[str, tuple[float, float, float, float]]
    cutoff_r2: float  # beyond it nothing is shown

    def __attrs_post_init__(self) -> None:
        _refuse_unless_positive(focal=self.focal, undistort_r2_cutoff=self.cutoff_r2)
        self._refuse_folds(math.sqrt(self.cutoff_r2))

    def scales(self, colour: str, r: Array) -> Array:
        k1, k2, k3, k4 = self.coefficients[colour]
        return np.asarray((1 / polynomial.polyval(r * r, [1, k1, k2, k3]) + k4) / self.focal)


# Each has a model, the name of the pass that corrects it in client/lens, and of files.
Lens = RadialLens | TableLens | ViveLens
MODELS: dict[str, type[RadialLens] | type[TableLens]] = {"radial": RadialLens, "table": TableLens}


def _whole_pixels(size: Sequence[float]) -> tuple[int, int]:
    if not all(side >= 1 and float(side).is_integer() for side in size):
        raise InputError(f"eye_size_px is {size[0]:g} x {size[1]:g}: expected whole pixels, 1 or more")
    return int(size[0]), int(size[1])


# Of pupils: the range of 3,976 adults, for headsets whose maker states none.
# Source: Dodgson 2004, Variation and extrema of human interpupillary distance.
IPD_RANGE_M = (0.052, 0.078)
_COLUMNS = 512  # of the picture that the hidden share is counted in
_FLAT_MOST = math.tan(math.radians(75))  # to each side of a flat picture
_LEVEL, _LEVEL_COLUMNS = 1e-4, 8192  # half the height, and the columns, of the row at eye level


@attrs.frozen
class HeadsetEye:
    """One eye: its place and direction in the head, its field of view, panel and lens."""

    head_from_eye: Pose
    fov: Fov
    panel_m: tuple[float, float] | None = None  # (w, h); None where it is not known
    lens: Lens | None = None
    hidden: Hidden | None = None  # what of the view cannot be seen

    def __attrs_post_init__(self) -> None:
        if self.panel_m is not None:
            _refuse_unless_positive(eye_width_m=self.panel_m[0], eye_height_m=self.panel_m[1])

    def mirrored(self) -> HeadsetEye:
        """Return the other eye of a symmetric headset."""
        (x, y, z), (qx, qy, qz, qw) = self.head_from_eye.position_m.tolist(), self.head_from_eye.unit_quaternion
        fov, lens = Fov(-self.fov.right, -self.fov.left, self.fov.down, self.fov.up), self.lens and self.lens.mirrored()
        hidden = self.hidden and Hidden(tuple(tuple((-a, b) for a, b in one) for one in self.hidden.polygons), fov)
        return HeadsetEye(Pose((-x, y, z), (qx, 0.0 - qy, 0.0 - qz, qw)), fov, self.panel_m, lens, hidden)

    @property
    def edges_rad(self) -> tuple[float, float]:
        """Left and right end of what is seen at eye level: angles in the head, + is right."""
        left, right = self.fov.tangents[:2].tolist()
        if self.hidden:
            level = attrs.evolve(self.fov, down=-_LEVEL, up=_LEVEL)
            columns = np.flatnonzero(Hidden(self.hidden.polygons, level).seen(level, (_LEVEL_COLUMNS, 1)))
            if not len(columns):
                raise InputError("the hidden area covers all of the view at eye level: expected less than that")
            step = (right - left) / _LEVEL_COLUMNS
            left, right = left + step * float(columns[0]), left + step * float(columns[-1] + 1)
        x, _, z = self.head_from_eye.rotation_matrix @ np.array([(left, right), (0, 0), (-1, -1)])
        first, last = np.arctan2(x, -z).tolist()
        return first, last

    @property
    def turn_rad(self) -> float:
        """How far the view is turned to the right."""
        x, _, z = self.head_from_eye.rotation_matrix[:, 2].tolist()
        return math.atan2(-x, z)

    @property
    def hidden_share(self) -> float:
        """Share of the view that cannot be seen, in tangents."""
        left, right, down, up = self.fov.tangents
        size = _COLUMNS, max(1, round(_COLUMNS * (up - down) / (right - left)))
        return 0.0 if self.hidden is None else 1 - float(self.hidden.seen(self.fov, size).mean())


@attrs.frozen
class Headset:
    """Two eyes in front of two panels. Eye 0 is the left one.

    Errors: InputError for what is no size, rate or distance, and eyes that look past each other.
    """

    name: str
    summary: str
    source: str
    eye_size_px: tuple[int, int] = attrs.field(converter=_whole_pixels)  # one eye's picture
    refresh_hz: float
    eyes: tuple[HeadsetEye, ...]
    ipd_range_m: tuple[float, float] = IPD_RANGE_M
    emulated: str = ""  # what of it is emulated and what is not, where that is not all
    peak_cd_m2: float | None = None  # luminance of white and of black; None where not measured
    black_cd_m2: float | None = None
    is_camera: bool = False  # whether it shows a camera's frames, so that the camera's view is the flat one

    def __attrs_post_init__(self) -> None:
        values = {"refresh_hz": self.refresh_hz, "peak_cd_m2": self.peak_cd_m2, "black_cd_m2": self.black_cd_m2}
        _refuse_unless_positive(**{name: value for name, value in values.items() if value is not None})
        for eye in self.eyes:
            if (share := eye.hidden_share) > 0.9:
                raise InputError(f"the hidden area covers {share:.0%} of the view: expected less than 90 %")
        for side, cant in zip(("left", "right"), self.cants_deg, strict=False):
            way, most = ("outwards", 30.0) if cant >= 0 else ("inwards", 10.0)  # Pimax's 10 are the most on sale
            if abs(cant) > most:
                wanted = f"expected at most {most:g}; outwards is positive"
                raise InputError(f"the {side} eye is turned {way} by {abs(cant):g} degrees: {wanted}")
        if self.overlap_deg <= 0:
            apart = f"they lie {-self.overlap_deg:.1f} degrees apart; left is negative in each eye's own view"
            raise InputError(f"the eyes' views have no direction in common: {apart}")

    @property
    def notes(self) -> tuple[str, ...]:
        """A line on what is emulated and what is not, where that is not all."""
        return (f"Headset {self.name}: {self.emulated}.",) if self.emulated else ()

    @property
    def lens(self) -> Lens | None:
        """The left eye's lens; both eyes have one or none."""
        return self.eyes[0].lens

    @property
    def ipd_m(self) -> float:
        """The distance of the eyes, from left to right."""
        return float(self.eyes[-1].head_from_eye.position_m[0] - self.eyes[0].head_from_eye.position_m[0])

    @property
    def cants_deg(self) -> tuple[float, ...]:
        """How far each eye's view is turned outwards."""
        return tuple(math.degrees(eye.turn_rad) * side + 0.0 for eye, side in zip(self.eyes, (-1, 1), strict=False))

    @property
    def across_deg(self) -> float:
        """What both eyes see together from left to right, level with them."""
        firsts, lasts = zip(*(eye.edges_rad for eye in self.eyes), strict=True)
        return math.degrees(max(lasts) - min(firsts))

    @property
    def overlap_deg(self) -> float:
        """What every eye sees from left to right, level with them; below 0 for none."""
        firsts, lasts = zip(*(eye.edges_rad for eye in self.eyes), strict=True)
        return math.degrees(min(lasts) - max(firsts))

    @property
    def aspect(self) -> float:
        """Width over height of one eye's picture: the panel's, else that of square tangents."""
        if self.eyes[0].panel_m is not None:
            return self.eyes[0].panel_m[0] / self.eyes[0].panel_m[1]
        left, right, down, up = self.eyes[0].fov.tangents.tolist()
        return float((right - left) / (up - down))

    def with_ipd(self, ipd_m: float) -> Headset:
        """Return it set to a distance of the pupils. Errors: InputError outside its range."""
        (least, most), found = (limit * 1e3 for limit in self.ipd_range_m), ipd_m * 1e3
        if not least - 1e-9 <= found <= most + 1e-9:
            raise InputError(f":ipd={found:g}: headset '{self.name}' can be set to {least:g} to {most:g} mm")
        step = (ipd_m - self.ipd_m) / 2
        moved = [
            attrs.evolve(eye, head_from_eye=Pose((side * step, 0, 0)) @ eye.head_from_eye)
            for eye, side in zip(self.eyes, (-1, 1), strict=True)
        ]
        return attrs.evolve(self, name=f"{self.name}:ipd={found:g}", eyes=tuple(moved))

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return the eyes' views for a head pose, the left first."""
        return tuple([view.at(world_from_head @ view.head_from_eye) for view in self._views])

    @cached_property
    def _views(self) -> tuple[View, ...]:
        """The eyes' views for a head at the origin."""
        return tuple(View(eye.head_from_eye, eye.fov, eye.head_from_eye, eye.hidden) for eye in self.eyes)

    @property
    def flat_view(self) -> tuple[Fov, float]:
        """The field of view of one flat picture, and its width over its height.

        Straight ahead, as far to both sides as the eye that sees farthest, 75 degrees at most, and
        as wide for its height as both eyes' pictures side by side.
        """
        if self.is_camera:
            return self.eyes[0].fov, self.aspect
        ends = [np.tan(eye.edges_rad) if eye.turn_rad else eye.fov.tangents[:2] for eye in self.eyes]
        wide, aspect = min(float(np.abs(ends).max()), _FLAT_MOST), 2 * self.aspect
        high = wide / aspect
        return Fov.from_tangents((-wide, wide, -high, high)), aspect

    def lens_from_panel(self, eye: int, panel_size: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (scale, offset), (2,) each: place on the lens = panel pixel * scale + offset."""
        lens, panel_m = self.eyes[eye].lens, self.eyes[eye].panel_m
        assert lens is not None and panel_m is not None
        extent, unit = np.array(panel_m), lens.unit_m
        scale = extent / np.array(panel_size) / unit
        offset = (-extent / 2 - np.array(lens.axis_from_centre_m)) / unit
        return scale, offset

    def through_lens(self, eye: int, places: NDArray[np.float64], colour: str) -> NDArray[np.float64]:
        """Return the tangents (..., 2) of places (..., 2) in 0..1 of a panel, NaN for none."""
        lens = self.eyes[eye].lens
        assert lens is not None
        scale, offset = self.lens_from_panel(eye, (1, 1))
        return lens.tangents(colour, places * scale + offset)


def camera_display(
    source: str, fov: Fov, size: tuple[int, int], refresh_hz: float, eye_distance_m: float, hidden: tuple[Polygon, ...]
) -> Headset:
    """Return the display of a camera: the head and the left eye are where it is.

    source: what recorded it; size: (w, h) of its pictures; eye_distance_m: how far to its right an
    eye with the same field of view is, 0 for none; hidden: as an eye's, of both.
    """
    panel_m = (0.1, 0.1 * size[1] / size[0])
    places = (0.0, eye_distance_m) if eye_distance_m else (0.0,)
    area = Hidden(hidden, fov) if hidden else None
    eyes = tuple(HeadsetEye(Pose((x, 0, 0)), fov, panel_m, hidden=area) for x in places)
    return Headset("camera", f"the camera of {source}", source, size, refresh_hz, eyes, is_camera=True)
