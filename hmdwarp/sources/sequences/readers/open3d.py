"""Open3D: a camera trajectory as JSON, beside the pictures that were taken with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ....errors import InputError
from ....poses.assumptions import Assumption, By
from ..camera import Camera, camera_of, numbers_of, read_json
from ..options import SequenceOptions
from ..recorded import Sequence
from . import readers
from ._base import Pair, SequenceReader, at_rate, facts_of, folder_named, paired, pose_of_matrix, sequence_of
from ._dataset import axes_of, clock_of

_CLASS = "PinholeCameraTrajectory"
_NAMES = ("camera_trajectory.json", "trajectory.json", "key.json")
_HEAD = 4096  # bytes that are searched for the class


class Open3DReader(SequenceReader):
    """Trajectories of Open3D; extrinsics are from world to camera, matrices by columns.

    Source: Open3D documentation, io.write_pinhole_camera_trajectory, camera.PinholeCameraParameters
    and geometry.RGBDImage (depth_scale 1000).
    """

    name = "open3d"
    summary = f"Open3D: color/, depth/ and {_NAMES[0]} of class {_CLASS}"

    def fits(self, path: Path) -> int:
        return 87 if _trajectory(path) is not None and (path / "depth").is_dir() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        file = _trajectory(path)
        if file is None:
            raise InputError(f"{path}: no JSON file of class {_CLASS}; expected {self.summary}")
        cameras = read_json(file).get("parameters")
        files = paired(folder_named(path, "color", "colour", "rgb", "image"), path / "depth")
        if not isinstance(cameras, list) or len(cameras) != len(files):
            count = len(cameras) if isinstance(cameras, list) else "no list of"
            raise InputError(f"{file}: {count} parameters for {len(files)} pictures; expected one for each")
        own = [_camera(f"{file}, parameters {at}", one) for at, one in enumerate(cameras)]
        facts = facts_of(path, options, None, 0.001, own=own[0])
        axes = facts.axes()
        pairs = []
        for at, ((colour, depth), camera, one) in enumerate(zip(files, own, cameras, strict=True)):
            where = f"{file}, parameters {at}"
            extrinsic = np.reshape(numbers_of(where, "extrinsic", one.get("extrinsic"), 16), (4, 4)).T
            pose = pose_of_matrix(axes, where, _inverse(where, extrinsic))
            stated = camera if options.intrinsics is None else None
            pairs.append(Pair(colour, depth, at_rate(options, at), pose, stated))
        pose_by = Assumption("camera pose", "camera from world, inverted; matrices by columns", By.FORMAT)
        more = (axes_of(axes), pose_by, clock_of(options, By.NOBODY))
        return sequence_of(self, path, pairs, facts, more=more)


def _trajectory(path: Path) -> Path | None:
    """Return the trajectory by its usual names, else the only JSON file of its class."""
    found = sorted(path.glob("*.json")) if path.is_dir() else []
    fitting = [one for one in found if _CLASS.encode() in _head_and_tail(one)]
    named = [one for one in fitting if one.name in _NAMES]
    return named[0] if named else fitting[0] if len(fitting) == 1 else None


def _head_and_tail(file: Path) -> bytes:
    with file.open("rb") as stream:
        head = stream.read(_HEAD)
        stream.seek(max(0, file.stat().st_size - _HEAD))
        return head + stream.read()


def _camera(where: str, one: Any) -> Camera:
    intrinsic = one.get("intrinsic") if isinstance(one, dict) else None
    camera = camera_of(where, intrinsic) if isinstance(intrinsic, dict) else None
    if camera is None:
        raise InputError(f"{where}: no intrinsic_matrix; expected intrinsic and extrinsic")
    return camera


def _inverse(where: str, matrix: np.ndarray) -> np.ndarray:
    if np.abs(matrix[3] - (0, 0, 0, 1)).max() > 1e-6:
        raise InputError(f"{where}: extrinsic is not 16 numbers by columns; expected 0, 0, 0, 1 at every fourth")
    turn = matrix[:3, :3].T
    inverse = np.eye(4)
    inverse[:3, :3], inverse[:3, 3] = turn, -turn @ matrix[:3, 3]
    return inverse


readers.register(Open3DReader())
