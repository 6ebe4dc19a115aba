"""Files for `hmdwarp warp`: an RGB-D frame (.npz) and the pose to show it for (.json)."""

from __future__ import annotations

import io
import json
import reprlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import Fov, Pose, View
from ..poses.track import UNIT_WITHIN

_VIEW = {"fov": 4, "position_m": 3, "orientation_xyzw": 4}
_KEYS = ("colour", "depth_m", *_VIEW)
_SCALE, _ENCODING = "depth_scale", "encoding"


@attrs.frozen(eq=False)
class FrameFile:
    """What a FRAME.npz holds."""

    colour: NDArray[Any]
    depth_m: NDArray[Any]
    view: View
    # Metres per unit of depth_m; None for metres.
    depth_scale: float | None = None
    # Of float colour; None for linear light.
    encoding: str | None = None


def read_frame(path: Path) -> FrameFile:
    """Return what a FRAME.npz holds; depth_scale and encoding may be missing.

    Errors: InputError naming the file and its fault.
    """
    arrays = _arrays(path)
    _check_keys(path, arrays, _KEYS)
    scale = float(_numbers(path, _SCALE, np.atleast_1d(arrays[_SCALE]), 1)[0]) if _SCALE in arrays else None
    encoding = str(arrays[_ENCODING]) if _ENCODING in arrays else None
    return FrameFile(arrays["colour"], arrays["depth_m"], _view(path, arrays), scale, encoding)


def _arrays(path: Path) -> dict[str, NDArray[Any]]:
    content = _content(path)
    wanted = "expected NumPy's .npz form, as numpy.savez writes it"
    if not content.startswith(b"PK"):  # NumPy would take it for a pickle
        raise InputError(f"{path}: not an .npz file; {wanted}")
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as data:
            return {key: data[key] for key in (*_KEYS, _SCALE, _ENCODING) if key in data}
    # Zip, zlib and NumPy raise many kinds of exceptions for a damaged file.
    except Exception as error:
        why = "holds Python objects" if "allow_pickle" in str(error) else f"{type(error).__name__}: {error}"
        raise InputError(f"{path}: cannot be read ({why}); {wanted}, with arrays of numbers") from error


def read_view(path: Path) -> View:
    """Return the view of a POSE.json: fov (4), position_m (3), orientation_xyzw (4).

    Errors: InputError.
    """
    try:
        data = json.loads(_content(path).decode("utf-8"))
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: not a text file ({error})") from error
    except json.JSONDecodeError as error:
        raise InputError(f"{path}, line {error.lineno}: not JSON ({error.msg})") from error
    # A number of thousands of digits, or brackets nested without end.
    except (ValueError, RecursionError) as error:
        raise InputError(f"{path}: not JSON that can be read ({error})") from error
    if not isinstance(data, dict):
        raise InputError(f"{path}: found a {type(data).__name__}; expected an object with {', '.join(_VIEW)}")
    _check_keys(path, data, tuple(_VIEW))
    return _view(path, data)


def _content(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error


def _check_keys(path: Path, found: Mapping[str, Any], wanted: tuple[str, ...]) -> None:
    missing = [key for key in wanted if key not in found]
    if missing:
        raise InputError(f"{path}: no {', '.join(missing)} in it; expected {', '.join(wanted)}")


def _view(path: Path, data: Mapping[str, Any]) -> View:
    fov, position, orientation = (_numbers(path, key, data[key], count) for key, count in _VIEW.items())
    length = float(np.linalg.norm(orientation))
    if not abs(length - 1) <= UNIT_WITHIN:
        raise InputError(
            f"{path}: orientation_xyzw has length {length:.4g}; expected 1 within {UNIT_WITHIN:g}, x y z w: divide it "
            "by its length if it is a rotation"
        )
    try:
        return View(Pose(position, orientation), Fov(*fov))
    except InputError as error:
        raise InputError(f"{path}: {error}") from error


def _numbers(path: Path, key: str, value: Any, count: int) -> NDArray[np.float64]:
    try:
        array = np.asarray(value)
    except ValueError:  # lists of different lengths
        array = np.empty(0)
    if array.shape != (count,) or array.dtype.kind not in "fiu":
        angles = ": angles in radians, left, right, down, up" if key == "fov" else ""
        raise InputError(f"{path}: {key} is {reprlib.repr(value)}; expected {count} numbers{angles}")
    return array.astype(np.float64)
