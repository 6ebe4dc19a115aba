"""Files for `hmdwarp warp`: an RGB-D frame (.npz) and the pose to show it for (.json)."""

from __future__ import annotations

import json
import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .errors import InputError
from .geometry import Fov, Pose, View

_VIEW_KEYS = ("fov", "position_m", "orientation_xyzw")
_KEYS = ("colour", "depth_m", *_VIEW_KEYS)


def read_frame(path: Path) -> tuple[NDArray, NDArray, View]:
    """colour, depth_m and the view of a FRAME.npz. Errors: InputError naming the file and what is wrong with it."""
    try:
        with np.load(path, allow_pickle=False) as data:
            missing = [key for key in _KEYS if key not in data]
            if missing:
                raise InputError(f"{path}: no {', '.join(missing)} in it; wanted {', '.join(_KEYS)}")
            arrays = {key: data[key] for key in _KEYS}
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file") from error
    except (OSError, ValueError, zipfile.BadZipFile, EOFError, TypeError, AttributeError) as error:
        raise InputError(f"{path}: not a frame in NumPy's .npz form ({error})") from error
    return arrays["colour"], arrays["depth_m"], _view(path, arrays)


def read_view(path: Path) -> View:
    """The view of a POSE.json: fov (4), position_m (3), orientation_xyzw (4). Errors: InputError naming the file."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file") from error
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as text ({error})") from error
    except json.JSONDecodeError as error:
        raise InputError(f"{path}, line {error.lineno}: not JSON ({error.msg})") from error
    missing = [key for key in _VIEW_KEYS if not isinstance(data, dict) or key not in data]
    if missing:
        raise InputError(f"{path}: no {', '.join(missing)} in it; wanted an object with {', '.join(_VIEW_KEYS)}")
    return _view(path, data)


def _view(path: Path, data: dict) -> View:
    try:
        fov = np.asarray(data["fov"], dtype=np.float64)
        if fov.shape != (4,):
            raise InputError(f"fov has shape {fov.shape}: wanted four angles in radians, left, right, down, up")
        return View(Pose(data["position_m"], data["orientation_xyzw"]), Fov(*fov))
    except (ValueError, TypeError) as error:
        raise InputError(f"{path}: {error}") from error
    except InputError as error:
        raise InputError(f"{path}: {error}") from error
