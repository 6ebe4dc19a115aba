"""Files of one frame with depth, of a view, and the facts in them: intrinsics, matrices."""

from __future__ import annotations

import io
import math
import re
import reprlib
from collections.abc import Callable, Collection, Iterable, Mapping
from functools import cached_property, partial
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...base import InputError, as_path
from ...base.documents import json_in
from ...base.named_files import FACTS, MOST_PIXELS_BYTES, PICTURE_FILE, content_of, named_in
from ...geometry import Fov, Pose, View
from ...poses.assumptions import Assumption, By, first_stated
from ...poses.track import UNIT_WITHIN
from .picture_files import EXR, NPY, PICTURES, fitted_depth, read_colour, read_depth, read_exr, size_of
from .recorded import AXES, DEPTH_SCALE, INTRINSICS, NO_DEPTH, POSE

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


def floats_in(words: Iterable[str]) -> list[float]:
    """Return the numbers in words, none where one is something else."""
    try:
        return [float(word.encode("ascii")) for word in words]
    except ValueError:
        return []


def parse_intrinsics(text: str) -> Camera:
    """Return the camera of 'FX,FY,CX,CY'. Errors: InputError."""
    numbers = floats_in(text.split(","))
    if len(numbers) != 4 or not all(map(math.isfinite, numbers)) or 0 in numbers[:2] or numbers[0] < 0:
        hint = "a negative FY says that the camera's y points up"
        raise InputError(f"--intrinsics '{text}': expected FX,FY,CX,CY in pixels, such as 525,525,319.5,239.5; {hint}")
    return Camera.of(numbers)


def parse_projection(text: str) -> Camera:
    """Return the camera of a 4x4 matrix of OpenGL, WebXR, Unity, OpenVR. Errors: InputError."""
    try:
        numbers = floats_in(text.replace(",", " ").split())
        return Camera(1, 1, 0, 0, projected=Fov.from_projection(numbers))
    except InputError as error:
        raise InputError(f"--projection '{text}': {error}") from error


def camera_of(where: str | Path, data: Mapping[str, Any], centre: float = 0.0) -> Camera | None:
    """Return the camera that a JSON object describes, None where it has no intrinsics.

    Known: `intrinsics`, a matrix of MATRICES, by rows or columns, `fx` .. `cy`, `fl_x` .. and
    `camera_angle_x`. centre: of the first pixel. Errors: InputError, also for lens distortion.
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
        if (across := _focal(where, data, size, 0)) is None:
            raise InputError(f"{where}: fl_y without fl_x: expected both focal lengths, in pixels")
        fx, fy = across, _focal(where, data, size, 1) or across
        middle = [None, None] if size is None else [side / 2 - 0.5 + centre for side in size]
        cx, cy = (number_of(where, key, data.get(key, at)) for key, at in zip(("cx", "cy"), middle, strict=True))
    else:
        return None
    if not fx > 0 or fy == 0:
        expected = "expected fx above 0 and fy other than 0, in pixels"
        raise InputError(f"{where}: focal lengths fx {fx:g}, fy {fy:g}: {expected}")
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
    if not isinstance(value, list | tuple) or len(value) != count:
        raise InputError(f"{where}: {key} is {reprlib.repr(value)}; expected {count} numbers")
    return tuple(number_of(where, key, entry) for entry in value)


_INF = math.inf
Where = str | Path  # a file, or a place in one


def number_of(
    where: Where, key: str, value: Any, expected: str = "a finite number", *, above: float = -_INF, most: float = _INF
) -> float:
    """Return a finite number in this range. expected: the range in words. Errors: InputError."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not math.isfinite(value) or not above < value <= most:
        raise InputError(f"{where}: {key} is {reprlib.repr(value)}; expected {expected}")
    return float(value)


def seconds_of(where: str | Path, key: str, value: Any) -> float:
    return number_of(where, key, value, "seconds, -9e9 to 9e9", above=-9e9, most=9e9)


def scale_of(where: str | Path, value: Any) -> float:
    return number_of(where, "depth_scale", value, "metres per unit, above 0 and at most 1", above=0, most=1)


_FOV, _POSE = {"fov": 4}, {"position_m": 3, "orientation_xyzw": 4}
_VIEW = {**_FOV, **_POSE}
_ARRAYS = ("colour", "depth_m")
_WANTED = f"an object with {', '.join(_VIEW)}"
_KEYS = (*_ARRAYS, *_VIEW)
_SCALE, _ENCODING = "depth_scale", "encoding"
_FACTS = (*_VIEW, INTRINSICS, "centre", _SCALE, _ENCODING, "time_s", "time_ns")
# What frames of our own form have by its description.
OWN_FACTS = (
    Assumption(NO_DEPTH, "0 or NaN", By.FORMAT, "--no-depth"),
    Assumption(AXES, "x right, y up, -z forward", By.FORMAT),
    Assumption(POSE, "world from camera, x y z and quaternion x y z w", By.FORMAT),
)
NPZ, JSON = ".npz", ".json"
_DEPTH_MARKS = (".depth", "-depth", "_depth")
_DEPTH_ENDINGS = (".png", ".exr", ".npy", ".pgm", ".tif", ".tiff")
Arrays = tuple[NDArray[Any], NDArray[Any]]


@attrs.frozen(eq=False)
class FrameFile:
    path: Path
    where: Path  # what states the facts: the frame itself, or the JSON next to it
    facts: Mapping[str, Any]  # of the keys that a camera JSON has
    size: tuple[int, int]  # (w, h) in pixels
    arrays: Callable[[], Arrays] = attrs.field(repr=False)  # reads colour and depth

    @cached_property
    def _kept(self) -> Arrays:
        return self.arrays()

    @property
    def colour(self) -> NDArray[Any]:
        """(h, w, 3 or 4) as the file has it; read at the first access and kept."""
        return self._kept[0]

    @property
    def depth_m(self) -> NDArray[Any]:
        """(h, w) as the file has it, in its own unit; read at the first access and kept."""
        return self._kept[1]

    @property
    def view(self) -> View:
        return _view(self.where, self.facts, self.size)

    @property
    def notes(self) -> list[str]:
        return unread_notes(self.where, self.facts, (*_FACTS, "depth"))

    @property
    def depth_scale(self) -> float | None:
        if _SCALE not in self.facts:
            return None
        return float(_numbers(self.where, _SCALE, np.atleast_1d(self.facts[_SCALE]), 1)[0])

    @property
    def encoding(self) -> str | None:
        return str(self.facts[_ENCODING]) if _ENCODING in self.facts else None


def assumptions_of(
    found: FrameFile, camera: Camera | None = None, scale: float | None = None, encoding: str | None = None
) -> list[Assumption]:
    """Return the facts by which a frame is read, those the user states included."""
    text, by = "fov", By.FILE
    if camera is not None or "fov" not in found.facts:
        stated = camera or camera_of(found.where, found.facts)
        text, by = stated.text if stated else "", By.FILE if camera is None else By.USER
    intrinsics = Assumption(INTRINSICS, text, by, "--intrinsics")
    scale, by = first_stated(scale, found.depth_scale, None)
    if scale is None:
        by, scale = (By.FILE if found.path == found.where else By.DEFAULT), 1.0
    facts = [intrinsics, Assumption(DEPTH_SCALE, f"{scale:.6g} m per unit", by, "--depth-scale"), *OWN_FACTS]
    if found.path == found.where and encoding is None and found.encoding is None:  # an .npz file, which takes both
        floats = Assumption("encoding", "linear (float colour)", By.DEFAULT, "encoding in the file")
        is_float = found.arrays()[0].dtype.kind == "f"
        facts.append(floats if is_float else Assumption("encoding", "sRGB (bytes)", By.FORMAT))
    return facts


def read_frame(path: Path, depth: Path | None = None, camera: Path | None = None) -> FrameFile:
    """Return the files of a frame, read and checked.

    Parameters
    ----------
    path : path
        FRAME.npz with everything, or colour as a picture or EXR file.
    depth : path, optional
        Depth of a picture; by default the file beside it, or an EXR file's own Z.
    camera : path, optional
        JSON with fov or intrinsics, position_m, orientation_xyzw; by default NAME.json beside.

    Raises
    ------
    InputError
        Naming the file and its fault.
    """
    found = find_frame(path, depth, camera)
    _ = found.view, found.colour, found.depth_scale  # what is wrong is found here, not at the first use
    return found


def find_frame(
    path: Path, depth: Path | None = None, camera: Path | None = None, shared: Mapping[str, Any] | None = None
) -> FrameFile:
    """Return the files of a frame as read_frame does, pixels unread. shared: further facts."""
    path, (depth, camera) = as_path(path), (None if one is None else as_path(one) for one in (depth, camera))
    shared, ending = dict(shared or {}), path.suffix.lower()
    if ending == NPZ and (depth is not None or camera is not None):
        raise InputError(f"{path}: an .npz file holds its depth and its view: leave out --depth and --camera")
    if ending == NPZ or ending != EXR and ending not in PICTURES:
        if ending != NPZ and not path.exists():
            raise InputError(f"{path}: cannot be read (No such file or directory)")
        if ending == NPZ or content_of(path, PICTURE_FILE).startswith(b"PK"):
            facts, names, size = _from_npz(path, _head_of_npz)
            _check_keys(path, {**shared, **names}, _KEYS)
            plain = {name: one.tolist() if name in (INTRINSICS, "centre") else one for name, one in facts.items()}
            read = partial(_from_npz, path, lambda data: (data["colour"], data["depth_m"]))
            return FrameFile(path, path, {**shared, **plain}, size, read)
        expected = f"expected NumPy's .npz form, as numpy.savez writes it, or one of {', '.join((*PICTURES, EXR))}"
        raise InputError(f"{path}: not an .npz file, nor a picture with depth; {expected}")
    size, beside, where = size_of(path), path.with_suffix(JSON), camera
    if where is None and beside.exists():
        where = beside
    if where is None and not _POSE.keys() <= shared.keys():
        raise InputError(
            f"{path}: no {beside.name} beside it to say its camera and pose: write it, or name it by --camera; "
            'expected {"intrinsics": [fx, fy, cx, cy], "position_m": [x, y, z], "orientation_xyzw": [x, y, z, w], '
            '"depth_scale": 0.001}'
        )
    own = {} if where is None else read_json(where, _WANTED, None if where is camera else path.parent)
    facts, where = {**shared, **{name: value for name, value in own.items() if value is not None}}, where or path
    refuse_distortion(where, facts)
    if depth is None and "depth" in facts:
        depth = named_in(path.parent, str(facts["depth"]))
    return FrameFile(path, where, facts, size, lambda: _pictures(path, depth))


def _pictures(path: Path, depth: Path | None) -> Arrays:
    channels = ""
    if depth is None and path.suffix.lower() == EXR:
        both = read_exr(path)
        if (own := both.depth()) is not None:
            return both.colour(), own
        channels = f", and none called Depth or Z among its channels ({', '.join(both.channels)})"
    colour = read_colour(path)
    names = [f"{path.stem}{mark}{ending}" for mark in _DEPTH_MARKS for ending in _DEPTH_ENDINGS]
    depth = depth or next((named_in(path.parent, name) for name in names if (path.parent / name).exists()), None)
    if depth is None:
        hint = f"name it by --depth, or call it {names[0]} (16 bits, EXR or {NPY})"
        raise InputError(f"{path}: no depth beside it{channels}: {hint}")
    return colour, fitted_depth(read_depth(depth), colour, depth)


def is_depth(path: Path) -> bool:
    return path.stem.endswith(_DEPTH_MARKS)


def _head_of_npz(data: Any) -> tuple[dict[str, NDArray[Any]], dict[str, None], tuple[int, int]]:
    shape: tuple[int, ...] = ()  # what is no picture is refused when it is read
    if "colour" in data:
        with data.zip.open(f"colour{NPY}") as file:
            version = np.lib.format.read_magic(file)
            read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
            shape = read(file)[0]
    size = (shape[1], shape[0]) if len(shape) == 3 and 0 not in shape else (1, 1)
    return {key: data[key] for key in _FACTS if key in data}, dict.fromkeys(data), size


def _from_npz(path: Path, read: Callable[[Any], Any]) -> Any:
    content = content_of(path, PICTURE_FILE)
    wanted = "expected NumPy's .npz form, as numpy.savez writes it"
    if not content.startswith(b"PK"):  # NumPy would take it for a pickle
        raise InputError(f"{path}: not an .npz file; {wanted}")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as data:
            known = (one for one in data.zip.infolist() if one.filename.removesuffix(NPY) in (*_KEYS, *_FACTS))
            size = sum(one.file_size for one in known)
            if size > MOST_PIXELS_BYTES:
                raise ValueError(f"arrays of {size} bytes, unpacked; expected at most {MOST_PIXELS_BYTES}")
            return read(data)
    # Zip, zlib and NumPy raise many kinds of exceptions for a damaged file.
    except Exception as error:
        why = "holds Python objects" if "allow_pickle" in str(error) else f"{type(error).__name__}: {error}"
        raise InputError(f"{path}: cannot be read ({why}); {wanted}, with arrays of numbers") from error


def read_view(path: Path, size: tuple[int, int] = (1, 1)) -> View:
    """Return the view of a POSE.json: position_m, orientation_xyzw, fov or intrinsics.

    Parameters
    ----------
    path : path
    size : tuple of int
        (w, h) pixels of the intrinsics, unless width and height say it.

    Raises
    ------
    InputError
        For a file without them.
    """
    path = as_path(path)
    data = read_json(path, _WANTED)
    _check_keys(path, data, tuple(_VIEW))
    camera = None if "fov" in data else camera_of(path, data)
    return _view(path, data, size if camera is None or camera.size is None else camera.size)


def _check_keys(path: Path, found: Mapping[str, Any], wanted: tuple[str, ...]) -> None:
    missing = [key for key in wanted if key not in found and not (key == "fov" and INTRINSICS in found)]
    if missing:
        names = ", ".join(f"fov or {INTRINSICS}" if key == "fov" else key for key in wanted)
        why = f"found {', '.join(found) or 'nothing'}; expected {names}"
        raise InputError(f"{path}: no {', '.join(missing)} in it; {why}")


def _view(path: Path, data: Mapping[str, Any], size: tuple[int, int]) -> View:
    _check_keys(path, data, tuple(_VIEW))
    position, orientation = (_numbers(path, key, data[key], count) for key, count in _POSE.items())
    length = float(np.linalg.norm(orientation))
    if not abs(length - 1) <= UNIT_WITHIN:
        expected = f"expected 1 within {UNIT_WITHIN:g}, x y z w: divide it by its length if it is a rotation"
        raise InputError(f"{path}: orientation_xyzw has length {length:.4g}; {expected}")
    try:
        pose = Pose(position, orientation)
        pose.check_near(str(path))
        if "fov" in data:
            return View(pose, Fov(*_numbers(path, "fov", data["fov"], _FOV["fov"])))
        camera = camera_of(path, data)
        assert camera is not None  # there are intrinsics
        if camera.is_y_up:
            why = "position_m and orientation_xyzw are those of OpenXR, which has y up already"
            raise InputError(f"{path}: fy is {camera.fy:g}; expected above 0: {why}")
        return View(pose, camera.fov(size, str(path)))
    except InputError as error:
        raise InputError(f"{path}: {error}" if str(path) not in str(error) else str(error)) from error


def _numbers(path: Path, key: str, value: Any, count: int) -> NDArray[np.float64]:
    try:
        array = np.asarray(value)
    except ValueError:  # lists of different lengths
        array = np.empty(0)
    if array.shape != (count,) or array.dtype.kind not in "fiu":
        angles = ": angles in radians, left, right, down, up" if key == "fov" else ""
        raise InputError(f"{path}: {key} is {reprlib.repr(value)}; expected {count} numbers{angles}")
    return array.astype(np.float64)
