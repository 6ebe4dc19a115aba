"""Open3D: a camera trajectory as JSON, next to the pictures that were taken with it."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

from ....errors import InputError
from ....options.named_files import FACTS, opened
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ..camera import Camera, camera_of, read_json
from ..options import SequenceOptions
from ..recorded import INTRINSICS, NO_DEPTH, POSE, Sequence
from . import readers
from ._base import OPTICAL, Pair, SequenceReader, at_rate, facts_of, folder_named, paired, poses_of, scale_fact
from ._dataset import axes_of, clock_of

_UNIT = 0.001
_CLASS = "PinholeCameraTrajectory"
_NAMES = ("camera_trajectory.json", "trajectory.json", "key.json")
_HEAD = 4096  # bytes that are searched for the class


@readers.register
class Open3DReader(SequenceReader):
    """Trajectories of Open3D; extrinsics are from world to camera, matrices by columns.

    Source: Open3D documentation, io.write_pinhole_camera_trajectory, camera.PinholeCameraParameters
    and geometry.RGBDImage (depth_scale 1000).
    """

    name = "open3d"
    summary = f"Open3D: color/, depth/ and {_NAMES[0]} of class {_CLASS}"
    assumes = (
        Assumption(INTRINSICS, "intrinsic_matrix of each frame", By.FILE, "--intrinsics"),
        scale_fact(_UNIT, By.NOBODY),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(OPTICAL)),
        Assumption(POSE, "camera from world, inverted; matrices by columns", By.FORMAT),
        clock_of(SequenceOptions()),
    )

    def fits(self, path: Path) -> int:
        return 87 if _trajectory(path) is not None and (path / "depth").is_dir() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        file = _trajectory(path)
        if file is None:
            raise InputError(f"{path}: no JSON file of class {_CLASS}; expected {self.summary}")
        cameras = _parameters(read_json(file))
        files = paired(folder_named(path, "color", "colour", "rgb", "image"), path / "depth")
        if not isinstance(cameras, list) or len(cameras) != len(files):
            count = len(cameras) if isinstance(cameras, list) else "no list of"
            raise InputError(f"{file}: {count} parameters for {len(files)} pictures; expected one for each")
        own = [_camera(f"{file}, parameters {at}", parameters) for at, parameters in enumerate(cameras)]
        facts = facts_of(path, options, None, _UNIT, own=own[0], by=By.NOBODY)
        axes = facts.axes()
        places = [f"{file}, parameters {at}" for at in range(len(cameras))]
        poses, order = poses_of(axes, list(zip(places, _extrinsics(cameras), strict=True)), inverse=True)
        stated = own if options.intrinsics is None else [None] * len(own)
        pairs = [
            Pair(colour, depth, at_rate(options, at), pose, camera)
            for at, ((colour, depth), pose, camera) in enumerate(zip(files, poses, stated, strict=True))
        ]
        return self.sequence_of(path, pairs, facts, more=(axes_of(axes), order, clock_of(options)))


def _parameters(trajectory: dict[str, Any]) -> Any:
    """Return the frames; the first Open3D wrote one intrinsic and all extrinsics."""
    extrinsics, intrinsic = trajectory.get("extrinsic"), trajectory.get("intrinsic")
    if "parameters" in trajectory or not isinstance(extrinsics, list):
        return trajectory.get("parameters")
    return [{"extrinsic": extrinsic, "intrinsic": intrinsic} for extrinsic in extrinsics]


def _extrinsics(cameras: list[Any]) -> list[Any]:
    return [parameters.get("extrinsic") for parameters in cameras]


def _trajectory(path: Path) -> Path | None:
    """Return the trajectory by its usual names, else the only JSON file of its class."""
    found = sorted(path.glob("*.json")) if path.is_dir() else []
    fitting = [candidate for candidate in found if _CLASS.encode() in _head_and_tail(candidate)]
    named = [candidate for candidate in fitting if candidate.name in _NAMES]
    return named[0] if named else fitting[0] if len(fitting) == 1 else None


def _head_and_tail(file: Path) -> bytes:
    with opened(file, FACTS) as stream:
        head = stream.read(_HEAD)
        stream.seek(max(0, stream.seek(0, io.SEEK_END) - _HEAD))
        return head + stream.read()


def _camera(where: str, parameters: Any) -> Camera:
    intrinsic = parameters.get("intrinsic") if isinstance(parameters, dict) else None
    camera = camera_of(where, intrinsic) if isinstance(intrinsic, dict) else None
    if camera is None:
        raise InputError(f"{where}: no intrinsic_matrix; expected intrinsic and extrinsic")
    return camera
