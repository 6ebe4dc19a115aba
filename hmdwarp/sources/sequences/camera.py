"""Facts in JSON files: numbers, intrinsics by any of their names, and lenses that are refused."""

from __future__ import annotations

import math
import re
import reprlib
from collections.abc import Collection, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...geometry import Fov
from ...options.documents import json_in
from ...options.named_files import FACTS
from ...poses.assumptions import Assumption, By
from .recorded import POSE

Size = tuple[int, int]
_PLAIN_MODELS = ("PINHOLE", "SIMPLE_PINHOLE", "OPENCV", "FULL_OPENCV", "RADIAL", "SIMPLE_RADIAL", "PERSPECTIVE")
_COEFFICIENTS = ("k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "s1", "s2", "s3", "s4")
_LISTS = ("distortion", "distortion_coefficients", "distortion_params", "dist_coeffs")
# Names of a 3x3 matrix of intrinsics: of Open3D, OpenCV, ROS and others.
MATRICES = ("intrinsic_matrix", "camera_matrix", "intrinsic", "K", "k")
_CAMERA_KEYS = (
    *("intrinsics", "fx", "fy", "cx", "cy", "w", "h", "width", "height", "centre", "depth_scale", "camera_model"),
    *("model", "fl_x", "fl_y", "camera_angle_x", "camera_angle_y"),
)
# In a key that may change what depth, poses or pixels mean.
_GEOMETRIC = re.compile(
    "depth|scale|unit|near|far|ax[ei]s|pose|matrix|rotat|transl|position|quat|offset|convention|flip|invert|coord|hand"
    "|skew|shutter|fisheye|ortho|distort|crop|baseline|orient|transform|shift|world|extrinsic|camera|lens|pixel|px|mitsuba",
    re.IGNORECASE,
)
_UNDISTORT = (
    "lens distortion is not undone here: undistort colour and depth first (COLMAP: image_undistorter; OpenCV: "
    "undistort, with nearest pixels for depth)"
)


@attrs.frozen
class Camera:
    """Intrinsics of a camera without lens distortion; fy < 0 where its y points up."""

    fx: float
    fy: float
    cx: float
    cy: float
    size: Size | None = None  # (w, h) that they are for; None for any
    centre: float = 0.0  # the coordinate of the first pixel's middle, as in Fov.from_intrinsics
    projected: Fov | None = None  # in place of the numbers above, by a projection matrix

    @classmethod
    def of(cls, numbers: Iterable[float]) -> Camera:
        fx, fy, cx, cy = map(float, numbers)
        return cls(fx, fy, cx, cy)

    def fov(self, size: Size, where: str) -> Fov:
        """Return the field of view of pictures of (w, h) pixels. Errors: InputError."""
        if self.size is not None and self.size != size:
            (wide, high), (found_wide, found_high) = self.size, size
            raise InputError(
                f"{where}: its intrinsics are for {wide}x{high} pixels, its pictures have {found_wide}x{found_high}: "
                "give those of the pictures by --intrinsics FX,FY,CX,CY"
            )
        if self.projected is not None:
            return self.projected
        try:
            return Fov.from_intrinsics(self.fx, abs(self.fy), self.cx, self.cy, *size, centre=self.centre)
        except InputError as error:
            raise InputError(f"{where}: {error}") from error

    @property
    def text(self) -> str:
        if self.projected is not None:
            left, right, down, up = self.projected.tangents.tolist()
            return f"projection from {left:.6g} to {right:.6g} and {down:.6g} to {up:.6g}"
        where = f", first pixel at {self.centre:g}" if self.centre else ""
        size = "" if self.size is None else " for {}x{}".format(*self.size)
        return ",".join(f"{number:.6g}" for number in (self.fx, self.fy, self.cx, self.cy)) + f" px{size}{where}"

    @property
    def is_y_up(self) -> bool:
        """Whether its y axis points up, which makes its axes left-handed where z points forward."""
        return self.fy < 0


def parse_intrinsics(text: str) -> Camera:
    """Return the camera of 'FX,FY,CX,CY'. Errors: InputError."""
    try:
        numbers = [float(part.encode("ascii")) for part in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 4 or not all(map(math.isfinite, numbers)) or 0 in numbers[:2] or numbers[0] < 0:
        raise InputError(
            f"--intrinsics '{text}': expected FX,FY,CX,CY in pixels, such as 525,525,319.5,239.5; a negative FY says "
            "that the camera's y points up"
        )
    return Camera.of(numbers)


def parse_projection(text: str) -> Camera:
    """Return the camera of a 4x4 matrix of OpenGL, WebXR, Unity, OpenVR. Errors: InputError."""
    try:
        numbers = [float(part) for part in text.replace(",", " ").split()]
    except ValueError:
        numbers = []
    try:
        return Camera(1, 1, 0, 0, projected=Fov.from_projection(numbers))
    except InputError as error:
        raise InputError(f"--projection '{text}': {error}") from error


def camera_of(where: str | Path, data: Mapping[str, Any], centre: float = 0.0) -> Camera | None:
    """Return the camera that a JSON object describes, None where it has no intrinsics.

    Known are `intrinsics` (fx, fy, cx, cy), a matrix by any of the names in MATRICES, nested or
    flat, by rows or by columns, `fx` .. `cy`, and `fl_x` .. `cy` and `camera_angle_x` of
    nerfstudio. centre: of the first pixel, unless `centre` says so.
    Errors: InputError, which names a lens distortion.
    """
    refuse_distortion(where, data)
    sides = [
        number_of(where, key, data[key]) for keys in (("w", "width"), ("h", "height")) for key in keys if key in data
    ]
    size, centre = None, number_of(where, "centre", data.get("centre", centre))
    if len(sides) == 2:
        if min(sides) < 1 or any(side % 1 for side in sides):
            raise InputError(f"{where}: pictures of {sides[0]:g}x{sides[1]:g}; expected whole pixels, 1 or more")
        size = int(sides[0]), int(sides[1])
    named = next((name for name in ("intrinsics", *MATRICES) if data.get(name) is not None), "")
    if named:
        fx, fy, cx, cy = _of_list(where, named, data[named])
    elif "fx" in data:
        fx, fy, cx, cy = (number_of(where, name, data.get(name)) for name in ("fx", "fy", "cx", "cy"))
    elif "fl_x" in data or "camera_angle_x" in data:  # as nerfstudio has them, or the older files of NeRF
        fx, fy = (_focal(where, data, size, axis) for axis in (0, 1))
        if fx is None:
            raise InputError(f"{where}: fl_y without fl_x: expected both focal lengths, in pixels")
        fy = fy or fx
        middle = [None, None] if size is None else [side / 2 - 0.5 + centre for side in size]
        cx, cy = (number_of(where, key, data.get(key, at)) for key, at in zip(("cx", "cy"), middle, strict=True))
    else:
        return None
    if not fx > 0 or fy == 0:
        raise InputError(
            f"{where}: focal lengths fx {fx:g}, fy {fy:g}: expected fx above 0 and fy other than 0, in pixels"
        )
    return Camera(fx, fy, cx, cy, size, centre)


def _focal(where: str | Path, data: Mapping[str, Any], size: Size | None, axis: int) -> float | None:
    name = "xy"[axis]
    if f"fl_{name}" in data:
        return number_of(where, f"fl_{name}", data[f"fl_{name}"])
    angle = data.get(f"camera_angle_{name}")
    if angle is None:
        return None
    if size is None:
        raise InputError(f"{where}: camera_angle_{name} without w and h: expected the pictures' size in pixels too")
    return size[axis] / 2 / math.tan(number_of(where, f"camera_angle_{name}", angle) / 2)


def _of_list(where: str | Path, name: str, value: Any) -> tuple[float, ...]:
    if isinstance(value, Mapping):  # as OpenCV writes a matrix
        value = value.get("data")
    try:
        shape = np.shape(value)
    except ValueError:  # rows of several lengths
        shape = ()
    numbers = np.ravel(np.asarray(value, dtype=object)).tolist() if shape else []
    if name == "intrinsics" and len(numbers) == 4:
        return numbers_of(where, name, numbers, 4)
    if shape not in ((9,), (3, 3)):
        four = "4 numbers fx, fy, cx, cy, or " if name == "intrinsics" else ""
        raise InputError(f"{where}: {name} is {reprlib.repr(value)}; expected {four}9 numbers of a 3x3 matrix")
    matrix = np.reshape(numbers_of(where, name, numbers, 9), (3, 3))
    matrix = matrix if np.array_equal(matrix[2], (0, 0, 1)) else matrix.T  # its zeros say which way it is
    if not np.array_equal(matrix[2], (0, 0, 1)):
        raise InputError(f"{where}: {name} is {reprlib.repr(value)}; expected 0, 0, 1 as its last row or column")
    if skew := matrix[0, 1] or matrix[1, 0]:
        raise InputError(f"{where}: {name} has a skew of {skew:g}; expected 0: square the pixels")
    return float(matrix[0, 0]), float(matrix[1, 1]), float(matrix[0, 2]), float(matrix[1, 2])


def refuse_distortion(where: str | Path, data: Mapping[str, Any]) -> None:
    """Raise InputError, with its name and value, for a lens that is no pinhole."""
    model = str(data.get("camera_model") or data.get("model") or "PINHOLE").upper()
    if model not in _PLAIN_MODELS:
        raise InputError(f"{where}: camera model {model}; expected a pinhole without distortion: {_UNDISTORT}")
    found = {name: data[name] for name in _COEFFICIENTS if name in data}
    for name in _LISTS:
        values = data.get(name) or []
        values = values if isinstance(values, list | tuple) else [values]
        found |= {f"{name}[{i}]": value for i, value in enumerate(values)}
    for name, value in found.items():
        if value is not None and number_of(where, name, value) != 0:
            raise InputError(f"{where}: {name} is {value:g}; expected 0: {_UNDISTORT}")


def unread_notes(where: str | Path, data: Mapping[str, Any], known: Collection[str] = ()) -> list[str]:
    """Return a note on keys that may change the geometry and are neither read nor known."""
    read = {*_CAMERA_KEYS, *_COEFFICIENTS, *_LISTS, *MATRICES, *known}
    found = [key for key in data if key not in read and _GEOMETRIC.search(key)]
    are = "is" if len(found) == 1 else "are"
    note = f"{where}: {', '.join(found)} {are} not read, and may change where things are: "
    return [note + "'hmdwarp check' says whether the frames agree without."] if found else []


def read_json(path: Path, wanted: str = "an object", folder: Path | None = None) -> dict[str, Any]:
    """Return the object in a JSON file. wanted: in words. folder: as opened. Errors: InputError."""
    data = json_in(path, FACTS, folder)
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


def seconds_of(where: str | Path, key: str, value: Any) -> float:
    """Return an instant in seconds that 64 bits of nanoseconds hold. Errors: InputError."""
    return number_of(where, key, value, "seconds, -9e9 to 9e9", above=-9e9, most=9e9)


def scale_of(where: str | Path, value: Any) -> float:
    """Return a depth scale. Errors: InputError for what are no metres per unit."""
    return number_of(where, "depth_scale", value, "metres per unit, above 0 and at most 1", above=0, most=1)


Matrix = NDArray[np.float64]
LAST = (0.0, 0.0, 0.0, 1.0)
_NOTHING = 1e-12
_WITHIN = 1e-3


def square_of(where: str, value: Any) -> Matrix:
    """Return 4x4 of 4x4, 3x4, 4x3 or 12 or 16 numbers, as written. Errors: InputError."""
    try:
        found = np.array(value, np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape == (12,):
        found = found.reshape(3, 4)
        if not turns(found[:, :3]) and turns(found.reshape(4, 3)[:3]):
            found = found.reshape(4, 3)
    found = found.reshape(4, 4) if found.shape == (16,) else found
    if found.shape not in ((4, 4), (3, 4), (4, 3)) or not np.isfinite(found).all():
        raise InputError(
            f"{where}: {reprlib.repr(value)}; expected a matrix of 4 rows of 4 finite numbers, nested or flat"
        )
    whole = np.diag(np.ones(4))
    whole[: found.shape[0], : found.shape[1]] = found
    return whole


def by_rows(where: str, matrices: Sequence[Matrix]) -> tuple[list[Matrix], Assumption]:
    """Return a file's matrices by rows, and who says they are: 0, 0, 0, 1. Errors: InputError."""
    below, beside = (
        np.array([np.abs(np.subtract(line, LAST)).max() <= _NOTHING for line in lines], bool)
        for lines in ([matrix[3] for matrix in matrices], [matrix[:, 3] for matrix in matrices])
    )
    rows, columns = np.flatnonzero(below & ~beside), np.flatnonzero(beside & ~below)
    if len(rows) and len(columns):
        raise InputError(
            f"{where}: matrix {rows[0]} is written by rows and matrix {columns[0]} by columns; expected one way for all"
        )
    order = "by columns" if len(columns) else "by rows"
    by = By.FILE if len(rows) or len(columns) else By.FORMAT
    turned = [matrix.T for matrix in matrices] if len(columns) else list(matrices)
    return turned, Assumption(POSE, f"world from camera, matrices {order}", by)


def turns(matrix: Matrix) -> bool:
    """Return whether three rows are those of a rotation, within what a file rounds."""
    return bool(np.abs(matrix @ matrix.T - np.eye(3)).max() <= _WITHIN)


def shared_scale(matrices: Sequence[Matrix]) -> float:
    """Return the factor that all matrices have beside a rotation; 1 for none, or for several."""
    scales = np.cbrt([np.linalg.det(matrix[:3, :3]) for matrix in matrices])
    if not len(scales) or not np.isfinite(scales).all() or scales.min() <= 0:
        return 1.0
    scale = float(np.median(scales))
    is_shared = np.abs(scales / scale - 1).max() <= _WITHIN
    return scale if is_shared and abs(scale - 1) > _WITHIN / 2 else 1.0
