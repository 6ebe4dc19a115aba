"""A headset as a model: two eyes, two panels, and a lens; or a camera in their place.

All code that assumes two eyes and a panel is here.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import Fov, Hidden, Polygon, Pose, View
from ._lenses import Lens, refuse_unless_positive


def _whole_pixels(size: Sequence[float]) -> tuple[int, int]:
    if not all(side >= 1 and float(side).is_integer() for side in size):
        raise InputError(f"eye_size_px is {size[0]:g} x {size[1]:g}: expected whole pixels, 1 or more")
    return int(size[0]), int(size[1])


# A view turned farther than this has a wrong sign or a wrong unit: Pimax's 10 degrees are the
# most on the market.
MOST_CANT_DEG = {"inwards": 10.0, "outwards": 30.0}
# Of pupils: the range of 3,976 adults, for headsets whose maker states none.
# Source: Dodgson 2004, Variation and extrema of human interpupillary distance.
IPD_RANGE_M = (0.052, 0.078)
_COLUMNS = 512  # of the picture that the hidden share is counted in
_LEVEL, _LEVEL_COLUMNS = 1e-4, 8192  # half the height, and the columns, of the row at eye level


@attrs.frozen
class HeadsetEye:
    """One eye: its place and direction in the head, its field of view, its panel and its lens.

    Errors: InputError for a panel without size.
    """

    head_from_eye: Pose
    fov: Fov
    panel_m: tuple[float, float] | None = None  # (w, h); None where it is not known
    lens: Lens | None = None
    hidden: tuple[Polygon, ...] = ()  # Parts of the view that cannot be seen, as polygons of tangents.

    def __attrs_post_init__(self) -> None:
        if self.panel_m is not None:
            refuse_unless_positive(eye_width_m=self.panel_m[0], eye_height_m=self.panel_m[1])

    def mirrored(self) -> HeadsetEye:
        """Return the other eye of a symmetric headset."""
        (x, y, z), (qx, qy, qz, qw) = self.head_from_eye.position_m.tolist(), self.head_from_eye.unit_quaternion
        return HeadsetEye(
            Pose((-x, y, z), (qx, 0.0 - qy, 0.0 - qz, qw)),
            Fov(-self.fov.right, -self.fov.left, self.fov.down, self.fov.up),
            self.panel_m,
            self.lens and self.lens.mirrored(),
            tuple(tuple((-a, b) for a, b in polygon) for polygon in self.hidden),
        )

    @property
    def edges_rad(self) -> tuple[float, float]:
        """Left and right end of what is seen at eye level: angles in the head, + is right."""
        left, right = self.fov.tangents[:2].tolist()
        if self.hidden:
            level = HeadsetEye(Pose(), attrs.evolve(self.fov, down=-_LEVEL, up=_LEVEL), hidden=self.hidden)
            columns = np.flatnonzero(level.seen((_LEVEL_COLUMNS, 1)))
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

    def seen(self, size: tuple[int, int]) -> NDArray[np.bool_]:
        """Return (h, w): which pixels of the view can be seen, the bottom row first."""
        area = self.hidden_area
        return np.ones(size[::-1], bool) if area is None else area.seen(self.fov, size)

    @functools.cached_property
    def hidden_area(self) -> Hidden | None:
        """What of its views is hidden, None for nothing."""
        return Hidden(self.hidden, self.fov) if self.hidden else None

    @property
    def hidden_share(self) -> float:
        """Share of the view that cannot be seen, in tangents."""
        left, right, down, up = self.fov.tangents
        size = _COLUMNS, max(1, round(_COLUMNS * (up - down) / (right - left)))
        return 1 - float(self.seen(size).mean()) if self.hidden else 0.0


@attrs.frozen
class Headset:
    """Two eyes in front of two panels. Eye 0 is the left one.

    Errors: InputError for a panel without pixels, a refresh rate of 0, a negative pupil distance,
    and eyes that look past each other.
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

    def __attrs_post_init__(self) -> None:
        given = {"peak_cd_m2": self.peak_cd_m2, "black_cd_m2": self.black_cd_m2}
        refuse_unless_positive(
            refresh_hz=self.refresh_hz, **{name: value for name, value in given.items() if value is not None}
        )
        for eye in self.eyes:
            if (share := eye.hidden_share) > 0.9:
                raise InputError(f"the hidden area covers {share:.0%} of the view: expected less than 90 %")
        for side, cant in zip(("left", "right"), self.cants_deg, strict=False):
            way = "outwards" if cant >= 0 else "inwards"
            if abs(cant) > MOST_CANT_DEG[way]:
                raise InputError(
                    f"the {side} eye is turned {way} by {abs(cant):g} degrees: "
                    f"expected at most {MOST_CANT_DEG[way]:g}; outwards is positive"
                )
        if self.overlap_deg <= 0:
            raise InputError(
                f"the eyes' views have no direction in common: they lie {-self.overlap_deg:.1f} degrees apart; "
                "left is negative in each eye's own view"
            )

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
            raise InputError(f"--ipd {found:g}: headset '{self.name}' can be set to {least:g} to {most:g} mm")
        step = (ipd_m - self.ipd_m) / 2
        moved = [
            attrs.evolve(eye, head_from_eye=Pose((side * step, 0, 0)) @ eye.head_from_eye)
            for eye, side in zip(self.eyes, (-1, 1), strict=True)
        ]
        return attrs.evolve(self, name=f"{self.name}:ipd={found:g}", eyes=tuple(moved))

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return the eyes' views for a head pose, the left first."""
        return tuple([view.at(world_from_head @ view.head_from_eye) for view in self._views])

    @functools.cached_property
    def _views(self) -> tuple[View, ...]:
        """The eyes' views for a head at the origin."""
        return tuple(View(eye.head_from_eye, eye.fov, eye.head_from_eye, eye.hidden_area) for eye in self.eyes)

    @property
    def flat_view(self) -> tuple[Fov, float]:
        """The field of view of one flat picture, and its width over its height.

        It looks straight ahead, sees to both sides as far as the eye that sees farthest, but 75
        degrees at most, and has the shape of both eyes' pictures side by side.
        """
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
        """Return the tangents (..., 2) that places (..., 2) in 0..1 of an eye's panel show.

        NaN where the lens shows nothing.
        """
        lens = self.eyes[eye].lens
        assert lens is not None
        scale, offset = self.lens_from_panel(eye, (1, 1))
        return lens.tangents(colour, places * scale + offset)


_FLAT_MOST = math.tan(math.radians(75))
NAME = "camera"


@attrs.frozen
class CameraDisplay(Headset):
    """The display of a camera's frames.

    The head and the left eye are where the camera is. A right eye is to its right, with the same
    field of view, or there is none.
    """

    @property
    def flat_view(self) -> tuple[Fov, float]:
        """The camera's own view."""
        return self.eyes[0].fov, self.aspect


def camera_display(
    source: str,
    fov: Fov,
    size: tuple[int, int],
    refresh_hz: float,
    eye_distance_m: float = 0.0,
    hidden: tuple[Polygon, ...] = (),
) -> CameraDisplay:
    """Return the display of a camera.

    source: what recorded it; size: (w, h) of its pictures; hidden: as an eye's, of both.
    """
    panel_m = (0.1, 0.1 * size[1] / size[0])
    places = (0.0, eye_distance_m) if eye_distance_m else (0.0,)
    eyes = tuple(HeadsetEye(Pose((x, 0, 0)), fov, panel_m, hidden=hidden) for x in places)
    return CameraDisplay(NAME, f"the camera of {source}", source, size, refresh_hz, eyes)
