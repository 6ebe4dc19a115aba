"""A headset as a model, from its .toml file.

Two eyes, two panels, and a lens with its inverse; or a camera in their place. All code that assumes
two eyes and a panel is here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from pathlib import Path

import attrs
import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from ..errors import InputError, unknown_name
from ..geometry import Fov, Pose, View
from ..options.tables import Table, parsed, text_of

MAX_COEFFICIENTS = 9
COLOURS = ("red", "green", "blue")


def _refuse_unless_positive(**values: float) -> None:
    for name, value in values.items():
        if not 0 < value < math.inf:
            raise InputError(f"{name} is {value:g}: expected a number above 0")


def _whole_pixels(size: Sequence[float]) -> tuple[int, int]:
    if not all(side >= 1 and float(side).is_integer() for side in size):
        raise InputError(f"eye_size_px is {size[0]:g} x {size[1]:g}: expected whole pixels, 1 or more")
    return int(size[0]), int(size[1])


@attrs.frozen
class RadialLens:
    """Radial distortion: tangent = on_lens * tangent_per_unit * (k0 + k1 r^2 + k2 r^4 ..).

    The coefficients k differ by colour. r = |on_lens|; on_lens is the panel position from the lens
    axis in units of unit_m metres.

    Errors: InputError with the radius where the polynomial folds back.
    Source: Brown 1966, Decentering Distortion of Lenses, the radial part.
    """

    # axis of the left eye's lens on its panel, from the panel's centre; mirrored for the right eye
    axis_from_centre_m: tuple[float, float]
    unit_m: float
    tangent_per_unit: float
    coefficients: dict[str, tuple[float, ...]]
    reach: float  # the largest r on the panel, up to which the polynomial must grow

    def __attrs_post_init__(self) -> None:
        _refuse_unless_positive(unit_m=self.unit_m, tangent_per_unit=self.tangent_per_unit, reach=self.reach)
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
class Headset:
    """Two eyes in front of two panels. Eye 0 is the left one.

    Errors: InputError for a panel without pixels or size, a refresh rate of 0, a negative pupil
    distance.
    """

    name: str
    summary: str
    source: str
    eye_size_px: tuple[int, int] = attrs.field(converter=_whole_pixels)  # one eye's panel
    eye_size_m: tuple[float, float]
    refresh_hz: float
    ipd_m: float
    left_fov: Fov  # the left eye's; the right eye's is its mirror image
    lens: RadialLens | None
    peak_cd_m2: float | None = None  # luminance of white and of black; None where not measured
    black_cd_m2: float | None = None

    def __attrs_post_init__(self) -> None:
        _refuse_unless_positive(
            eye_width_m=self.eye_size_m[0], eye_height_m=self.eye_size_m[1], refresh_hz=self.refresh_hz
        )
        given = {"peak_cd_m2": self.peak_cd_m2, "black_cd_m2": self.black_cd_m2}
        _refuse_unless_positive(**{name: value for name, value in given.items() if value is not None})
        if not 0 <= self.ipd_m < math.inf:
            raise InputError(f"ipd_m is {self.ipd_m:g}: expected the distance of the pupils in metres, 0 or more")

    def fov(self, eye: int) -> Fov:
        """Return the field of view of eye 0 (left) or 1 (right)."""
        left = self.left_fov
        return left if eye == 0 else Fov(-left.right, -left.left, left.down, left.up)

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return the eyes' views for a head pose, the left first, each half the ipd to its side."""
        return tuple(View(world_from_head @ head_from_eye, fov, head_from_eye) for head_from_eye, fov in self._eyes)

    @cached_property
    def _eyes(self) -> tuple[tuple[Pose, Fov], ...]:
        return tuple((Pose((x, 0, 0)), self.fov(eye)) for eye, x in enumerate(self.places_m))

    @property
    def places_m(self) -> tuple[float, ...]:
        """How far each eye sits to the right of the head's origin."""
        return -self.ipd_m / 2, self.ipd_m / 2

    @property
    def flat_view(self) -> tuple[Fov, float]:
        """The field of view of one flat picture, and its width over its height.

        It sees to both sides as far as the left eye to its wider side, and has the shape of both
        eyes' panels side by side.
        """
        wide, aspect = float(np.abs(self.left_fov.tangents[:2]).max()), 2 * self.eye_size_m[0] / self.eye_size_m[1]
        high = wide / aspect
        return Fov.from_tangents((-wide, wide, -high, high)), aspect

    def lens_from_panel(self, eye: int, panel_size: tuple[int, int]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (scale, offset), (2,) each: place on the lens = panel pixel * scale + offset."""
        assert self.lens is not None
        mirror = np.array([1.0 if eye == 0 else -1.0, 1.0])
        extent, unit = np.array(self.eye_size_m), self.lens.unit_m
        scale = extent / np.array(panel_size) / unit
        offset = (-extent / 2 - np.array(self.lens.axis_from_centre_m) * mirror) / unit
        return scale, offset


NAME = "camera"


@attrs.frozen
class CameraDisplay(Headset):
    """The display of a camera's frames.

    The head and the left eye are where the camera is. A right eye is ipd_m to its right, with the
    same field of view; for 0 there is none.
    """

    def fov(self, eye: int) -> Fov:
        """Return the field of view, the same for all eyes."""
        return self.left_fov

    @property
    def places_m(self) -> tuple[float, ...]:
        """How far each eye sits to the right of the camera."""
        return (0.0, self.ipd_m) if self.ipd_m else (0.0,)

    @property
    def flat_view(self) -> tuple[Fov, float]:
        """The camera's own view."""
        return self.left_fov, self.eye_size_m[0] / self.eye_size_m[1]


def camera_display(
    source: str, fov: Fov, size: tuple[int, int], refresh_hz: float, eye_distance_m: float = 0.0
) -> CameraDisplay:
    """Return the display of a camera. source: what recorded it; size: (w, h) of its pictures."""
    panel_m = (0.1, 0.1 * size[1] / size[0])
    return CameraDisplay(NAME, f"the camera of {source}", source, size, panel_m, refresh_hz, eye_distance_m, fov, None)


_FOLDER = Path(__file__).parent


def headset_names() -> list[str]:
    """Return the names of the shipped headsets, sorted."""
    return sorted(p.stem for p in _FOLDER.glob("*.toml"))


def load_headset(name: str) -> Headset:
    """Load a shipped headset by name, or the user's own .toml file by path.

    Errors: InputError naming the file and its fault.
    """
    path = Path(name) if name.endswith(".toml") else _FOLDER / f"{name}.toml"
    if not name.endswith(".toml") and not path.is_file():
        raise unknown_name("headset", name, [*headset_names(), "FILE.toml"])
    text, example = text_of(path, "a headset, as a .toml file"), "hmdwarp/headsets/rift-dk1.toml"
    try:
        return parsed(text, path, _headset, example)
    except InputError as error:  # the model's own name no file
        raise error if str(error).startswith(str(path)) else InputError(f"{path}: {error}") from error


def _headset(data: Table) -> Headset:
    panel, fov_deg = data.table("panel"), data.table("fov_deg")
    width_m, height_m = panel.numbers("eye_size_m", 2)
    size_m = width_m, height_m
    lens = data.table("lens") if "lens" in data else None
    return Headset(
        name=data.text("name"),
        summary=data.text("summary"),
        source=data.text("source"),
        eye_size_px=panel.numbers("eye_size_px", 2),
        eye_size_m=size_m,
        refresh_hz=panel.number("refresh_hz"),
        ipd_m=data.table("eyes").number("ipd_m"),
        left_fov=Fov(*(math.radians(fov_deg.number(side)) for side in ("left", "right", "down", "up"))),
        lens=_lens(lens, size_m) if lens else None,
        peak_cd_m2=panel.number("peak_cd_m2") if "peak_cd_m2" in panel else None,
        black_cd_m2=panel.number("black_cd_m2") if "black_cd_m2" in panel else None,
    )


def _lens(data: Table, size_m: tuple[float, float]) -> RadialLens:
    if data.text("model") != "radial":
        raise InputError(f"unknown lens model '{data.text('model')}': known is radial")
    x, y = data.numbers("axis_from_centre_m", 2)
    axis, unit_m = (x, y), data.number("unit_m")
    corner = np.array(size_m) / 2 + np.abs(axis)
    return RadialLens(
        axis_from_centre_m=axis,
        unit_m=unit_m,
        tangent_per_unit=data.number("tangent_per_unit"),
        coefficients={colour: data.numbers(colour) for colour in COLOURS},
        reach=float(np.hypot(*corner) / unit_m) if unit_m else 0.0,
    )
