"""Facts in JSON files: numbers, intrinsics by any of their names, and lenses that are refused."""

from __future__ import annotations

import json
import math
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...errors import InputError
from ...geometry import Fov

Size = tuple[int, int]
_PLAIN_MODELS = ("PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "FULL_OPENCV", "RADIAL", "SIMPLE_RADIAL", "PERSPECTIVE")
_COEFFICIENTS = tuple(
    f"{kind}{number}" for kind, count in (("k", 6), ("p", 2), ("s", 4)) for number in range(1, count + 1)
)
_LISTS = ("distortion", "distortion_coefficients", "distortion_params", "dist_coeffs")
_UNDISTORT = (
    "lens distortion is not undone here: undistort colour and depth first (COLMAP: image_undistorter; OpenCV: "
    "undistort, with nearest pixels for depth)"
)


@attrs.frozen
class Camera:
    """Intrinsics of a camera without lens distortion.

    A negative fy says that the camera's y points up, as ICL-NUIM has it.
    """

    fx: float
    fy: float
    cx: float
    cy: float
    # (w, h) that they are for; None for any.
    size: Size | None = None
    # The coordinate of the first pixel's middle, as in Fov.from_intrinsics.
    centre: float = 0.0

    def fov(self, size: Size, where: str) -> Fov:
        """Return the field of view of pictures of (w, h) pixels. Errors: InputError."""
        if self.size is not None and self.size != size:
            (wide, high), (found_wide, found_high) = self.size, size
            raise InputError(
                f"{where}: its intrinsics are for {wide}x{high} pixels, its pictures have {found_wide}x{found_high}: "
                "give those of the pictures by --intrinsics FX,FY,CX,CY"
            )
        try:
            return Fov.from_intrinsics(self.fx, abs(self.fy), self.cx, self.cy, *size, centre=self.centre)
        except InputError as error:
            raise InputError(f"{where}: {error}") from error

    @property
    def is_y_up(self) -> bool:
        """Whether its y axis points up, which makes its axes left-handed where z points forward."""
        return self.fy < 0


def parse_intrinsics(text: str) -> Camera:
    """Return the camera of 'FX,FY,CX,CY'. Errors: InputError."""
    try:
        numbers = [float(part) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 4 or not all(map(math.isfinite, numbers)) or 0 in numbers[:2] or numbers[0] < 0:
        raise InputError(
            f"--intrinsics '{text}': expected FX,FY,CX,CY in pixels, such as 525,525,319.5,239.5; a negative FY says "
            "that the camera's y points up"
        )
    fx, fy, cx, cy = numbers
    return Camera(fx, fy, cx, cy)


def camera_of(where: str | Path, data: Mapping[str, Any], centre: float = 0.0) -> Camera | None:
    """Return the camera that a JSON object describes, None where it has no intrinsics.

    Known are `intrinsics` (fx, fy, cx, cy), `fl_x` .. `cy` and `camera_angle_x` of nerfstudio, and
    `intrinsic_matrix` of Open3D (by columns). centre: of the first pixel, unless `centre` says so.
    Errors: InputError, which names a lens distortion.
    """
    refuse_distortion(where, data)
    size, centre = _size(where, data), number_of(where, "centre", data.get("centre", centre))
    if "intrinsics" in data:
        fx, fy, cx, cy = numbers_of(where, "intrinsics", data["intrinsics"], 4)
    elif "intrinsic_matrix" in data:
        matrix = np.ravel(np.asarray(data["intrinsic_matrix"], dtype=object))
        fx, _, _, _, fy, _, cx, cy, _ = numbers_of(where, "intrinsic_matrix", list(matrix), 9)
    elif "fl_x" in data or "camera_angle_x" in data:
        fx, fy, cx, cy = _of_nerf(where, data, size, centre)
    else:
        return None
    if not fx > 0 or fy == 0:
        raise InputError(
            f"{where}: focal lengths fx {fx:g}, fy {fy:g}: expected fx above 0 and fy other than 0, in pixels"
        )
    return Camera(fx, fy, cx, cy, size, centre)


def refuse_distortion(where: str | Path, data: Mapping[str, Any]) -> None:
    """Raise InputError, with its name and value, for a lens that is no pinhole."""
    model = str(data.get("camera_model") or data.get("model") or "PINHOLE").upper()
    if model not in _PLAIN_MODELS:
        raise InputError(f"{where}: camera model {model}; expected a pinhole without distortion: {_UNDISTORT}")
    found = {name: data[name] for name in _COEFFICIENTS if name in data}
    for name in _LISTS:
        values = data.get(name) or []
        found |= {
            f"{name}[{i}]": value for i, value in enumerate(values if isinstance(values, list | tuple) else [values])
        }
    for name, value in found.items():
        if value is not None and number_of(where, name, value) != 0:
            raise InputError(f"{where}: {name} is {value:g}; expected 0: {_UNDISTORT}")


def read_json(path: Path, wanted: str = "an object") -> dict[str, Any]:
    """Return the object in a JSON file. wanted: in words. Errors: InputError."""
    try:
        data = json.loads(path.read_bytes().decode("utf-8-sig"))
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file ({error})") from error
    except json.JSONDecodeError as error:
        raise InputError(f"{path}, line {error.lineno}: not JSON ({error.msg})") from error
    # A number of thousands of digits, or brackets nested without end.
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not JSON that can be read ({error})") from error
    if not isinstance(data, dict):
        raise InputError(f"{path}: found a {type(data).__name__}; expected {wanted}")
    return data


def numbers_of(where: str | Path, key: str, value: Any, count: int) -> tuple[float, ...]:
    """Return so many finite numbers. Errors: InputError naming file and key."""
    if not isinstance(value, list | tuple) or len(value) != count:
        raise InputError(f"{where}: {key} is {reprlib.repr(value)}; expected {count} numbers")
    return tuple(number_of(where, key, entry) for entry in value)


def number_of(
    where: str | Path,
    key: str,
    value: Any,
    expected: str = "a finite number",
    *,
    above: float = -math.inf,
    most: float = math.inf,
) -> float:
    """Return a finite number in this range. expected: the range in words. Errors: InputError."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value) or not above < value <= most:
        raise InputError(f"{where}: {key} is {reprlib.repr(value)}; expected {expected}")
    return float(value)


def scale_of(where: str | Path, value: Any) -> float:
    """Return a depth scale. Errors: InputError for what are no metres per unit."""
    return number_of(where, "depth_scale", value, "metres per unit, above 0 and at most 1", above=0, most=1)


def _size(where: str | Path, data: Mapping[str, Any]) -> Size | None:
    sides = [
        number_of(where, key, data[key]) for keys in (("w", "width"), ("h", "height")) for key in keys if key in data
    ]
    if len(sides) != 2:
        return None
    if min(sides) < 1 or any(side % 1 for side in sides):
        raise InputError(f"{where}: pictures of {sides[0]:g}x{sides[1]:g}; expected whole pixels, 1 or more")
    return int(sides[0]), int(sides[1])


def _of_nerf(
    where: str | Path, data: Mapping[str, Any], size: Size | None, centre: float
) -> tuple[float, float, float, float]:
    """Return fx, fy, cx, cy as nerfstudio has them, or as the older files of NeRF do."""

    def focal(axis: int) -> float | None:
        name = "xy"[axis]
        if f"fl_{name}" in data:
            return number_of(where, f"fl_{name}", data[f"fl_{name}"])
        angle = data.get(f"camera_angle_{name}")
        if angle is None:
            return None
        if size is None:
            raise InputError(f"{where}: camera_angle_{name} without w and h: expected the pictures' size in pixels too")
        return size[axis] / 2 / math.tan(number_of(where, f"camera_angle_{name}", angle) / 2)

    fx = focal(0)
    if fx is None:
        raise InputError(f"{where}: fl_y without fl_x: expected both focal lengths, in pixels")
    fy = focal(1) or fx
    middle = [None, None] if size is None else [side / 2 - 0.5 + centre for side in size]
    cx, cy = (data.get(key, default) for key, default in zip(("cx", "cy"), middle, strict=True))
    return fx, fy, number_of(where, "cx", cx), number_of(where, "cy", cy)
