"""Files of one frame with depth (NPZ, EXR, pictures with a JSON), and of a view (JSON)."""

from __future__ import annotations

import io
import reprlib
from collections.abc import Callable, Mapping
from functools import cached_property
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...geometry import Fov, Pose, View
from ...options import as_path
from ...options.named_files import MOST_PIXELS_BYTES, PICTURE_FILE, content_of, named_in
from ...poses.assumptions import Assumption, By, first_stated
from ...poses.track import UNIT_WITHIN
from .camera import Camera, camera_of, read_json, refuse_distortion, unread_notes
from .picture_files import EXR, NPY, PICTURES, fitted_depth, read_colour, read_depth, read_exr, size_of
from .recorded import AXES, DEPTH_SCALE, INTRINSICS, NO_DEPTH, POSE

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
    """Files of one frame with depth, whose pixels are read later."""

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
        """The view that it was rendered for. Errors: InputError."""
        return _view(self.where, self.facts, self.size)

    @property
    def notes(self) -> list[str]:
        """What its files state and nothing reads."""
        return unread_notes(self.where, self.facts, (*_FACTS, "depth"))

    @property
    def depth_scale(self) -> float | None:
        """Metres per unit of depth; None where nothing says it."""
        if _SCALE not in self.facts:
            return None
        return float(_numbers(self.where, _SCALE, np.atleast_1d(self.facts[_SCALE]), 1)[0])

    @property
    def encoding(self) -> str | None:
        """The encoding of float colour; None where nothing says it."""
        return str(self.facts[_ENCODING]) if _ENCODING in self.facts else None


def assumptions_of(
    found: FrameFile, camera: Camera | None = None, scale: float | None = None, encoding: str | None = None
) -> list[Assumption]:
    """Return the facts by which a frame is read, those the user states included."""
    if camera is not None or "fov" not in found.facts:
        stated = camera or camera_of(found.where, found.facts)
        by = By.FILE if camera is None else By.USER
        intrinsics = Assumption(INTRINSICS, stated.text if stated else "", by, "--intrinsics")
    else:
        intrinsics = Assumption(INTRINSICS, "fov", By.FILE, "--intrinsics")
    scale, by = first_stated(scale, found.depth_scale, None)
    if scale is None:
        by, scale = (By.FILE if found.path == found.where else By.DEFAULT), 1.0
    facts = [intrinsics, Assumption(DEPTH_SCALE, f"{scale:.6g} m per unit", by, "--depth-scale"), *OWN_FACTS]
    if found.path == found.where and encoding is None and found.encoding is None:  # an .npz file, which takes both
        if found.arrays()[0].dtype.kind == "f":
            facts.append(Assumption("encoding", "linear (float colour)", By.DEFAULT, "encoding in the file"))
        else:
            facts.append(Assumption("encoding", "sRGB (bytes)", By.FORMAT))
    return facts


def read_frame(path: Path, depth: Path | None = None, camera: Path | None = None) -> FrameFile:
    """Return the files of a frame, read and checked.

    path: FRAME.npz with everything; or colour as a picture or EXR file. depth: of a picture, by
    default the file beside it, or an EXR file's own Z. camera: JSON with fov or intrinsics,
    position_m, orientation_xyzw, and maybe depth_scale and encoding; by default NAME.json beside.
    Errors: InputError naming the file and its fault; MachineError for EXR without its package.
    """
    found = find_frame(path, depth, camera)
    # What is wrong is found here, not at the first use.
    _ = found.view, found.colour, found.depth_scale
    return found


def find_frame(
    path: Path, depth: Path | None = None, camera: Path | None = None, shared: Mapping[str, Any] | None = None
) -> FrameFile:
    """Return the files of a frame as read_frame does, pixels unread. shared: further facts."""
    path, (depth, camera) = as_path(path), (None if one is None else as_path(one) for one in (depth, camera))
    shared, ending = dict(shared or {}), path.suffix.lower()
    if ending == NPZ:
        if depth is not None or camera is not None:
            raise InputError(f"{path}: an .npz file holds its depth and its view: leave out --depth and --camera")
        return _in_npz(path, shared)
    if ending != EXR and ending not in PICTURES:
        if path.exists() and content_of(path, PICTURE_FILE).startswith(b"PK"):
            return _in_npz(path, shared)
        if not path.exists():
            raise InputError(f"{path}: cannot be read (No such file or directory)")
        raise InputError(
            f"{path}: not an .npz file, nor a picture with depth; expected NumPy's .npz form, as numpy.savez writes "
            f"it, or one of {', '.join((*PICTURES, EXR))}"
        )
    size, where = size_of(path), _camera_beside(path, camera, shared)
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
        raise InputError(
            f"{path}: no depth beside it{channels}: name it by --depth, or call it {names[0]} (16 bits, EXR or {NPY})"
        )
    return colour, fitted_depth(read_depth(depth), colour, depth)


def _camera_beside(path: Path, camera: Path | None, shared: Mapping[str, Any]) -> Path | None:
    if camera is not None:
        return camera
    beside = path.with_suffix(JSON)
    if beside.exists():
        return beside
    if _POSE.keys() <= shared.keys():
        return None
    raise InputError(
        f"{path}: no {beside.name} beside it to say its camera and pose: write it, or name it by --camera; expected "
        '{"intrinsics": [fx, fy, cx, cy], "position_m": [x, y, z], "orientation_xyzw": [x, y, z, w], "depth_scale": '
        "0.001}"
    )


def is_depth(path: Path) -> bool:
    """Return whether the name of a file is that of the depth of a picture."""
    return path.stem.endswith(_DEPTH_MARKS)


def _in_npz(path: Path, shared: Mapping[str, Any]) -> FrameFile:
    facts, names, size = _from_npz(path, _head_of_npz)
    _check_keys(path, {**shared, **names}, _KEYS)
    plain = {name: value.tolist() if name in (INTRINSICS, "centre") else value for name, value in facts.items()}
    return FrameFile(
        path, path, {**shared, **plain}, size, lambda: _from_npz(path, lambda data: (data["colour"], data["depth_m"]))
    )


def _head_of_npz(data: Any) -> tuple[dict[str, NDArray[Any]], dict[str, None], tuple[int, int]]:
    # What is no picture is refused when it is read.
    shape: tuple[int, ...] = ()
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
            size = sum(
                one.file_size for one in data.zip.infolist() if one.filename.removesuffix(NPY) in (*_KEYS, *_FACTS)
            )
            if size > MOST_PIXELS_BYTES:
                raise ValueError(f"arrays of {size} bytes, unpacked; expected at most {MOST_PIXELS_BYTES}")
            return read(data)
    # Zip, zlib and NumPy raise many kinds of exceptions for a damaged file.
    except Exception as error:
        why = "holds Python objects" if "allow_pickle" in str(error) else f"{type(error).__name__}: {error}"
        raise InputError(f"{path}: cannot be read ({why}); {wanted}, with arrays of numbers") from error


def read_view(path: Path, size: tuple[int, int] = (1, 1)) -> View:
    """Return the view of a POSE.json. size: (w, h) that intrinsics are for. Errors: InputError."""
    path = as_path(path)
    data = read_json(path, _WANTED)
    _check_keys(path, data, tuple(_VIEW))
    camera = None if "fov" in data else camera_of(path, data)
    return _view(path, data, size if camera is None or camera.size is None else camera.size)


def _check_keys(path: Path, found: Mapping[str, Any], wanted: tuple[str, ...]) -> None:
    missing = [key for key in wanted if key not in found and not (key == "fov" and INTRINSICS in found)]
    if missing:
        names = ", ".join(f"fov or {INTRINSICS}" if key == "fov" else key for key in wanted)
        raise InputError(
            f"{path}: no {', '.join(missing)} in it; found {', '.join(found) or 'nothing'}; expected {names}"
        )


def _view(path: Path, data: Mapping[str, Any], size: tuple[int, int]) -> View:
    _check_keys(path, data, tuple(_VIEW))
    position, orientation = (_numbers(path, key, data[key], count) for key, count in _POSE.items())
    length = float(np.linalg.norm(orientation))
    if not abs(length - 1) <= UNIT_WITHIN:
        raise InputError(
            f"{path}: orientation_xyzw has length {length:.4g}; expected 1 within {UNIT_WITHIN:g}, x y z w: divide it "
            "by its length if it is a rotation"
        )
    try:
        pose = Pose(position, orientation)
        pose.check_near(str(path))
        return View(pose, _fov(path, data, size))
    except InputError as error:
        raise InputError(f"{path}: {error}" if str(path) not in str(error) else str(error)) from error


def _fov(path: Path, data: Mapping[str, Any], size: tuple[int, int]) -> Fov:
    if "fov" in data:
        return Fov(*_numbers(path, "fov", data["fov"], _FOV["fov"]))
    camera = camera_of(path, data)
    assert camera is not None  # there are intrinsics
    if camera.is_y_up:
        raise InputError(
            f"{path}: fy is {camera.fy:g}; expected above 0: position_m and orientation_xyzw are those of "
            "OpenXR, which has y up already"
        )
    return camera.fov(size, str(path))


def _numbers(path: Path, key: str, value: Any, count: int) -> NDArray[np.float64]:
    try:
        array = np.asarray(value)
    except ValueError:  # lists of different lengths
        array = np.empty(0)
    if array.shape != (count,) or array.dtype.kind not in "fiu":
        angles = ": angles in radians, left, right, down, up" if key == "fov" else ""
        raise InputError(f"{path}: {key} is {reprlib.repr(value)}; expected {count} numbers{angles}")
    return array.astype(np.float64)
