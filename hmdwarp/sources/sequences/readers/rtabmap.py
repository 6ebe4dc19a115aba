"""RTAB-Map: what its export of images and poses writes, with a calibration for each image."""

from __future__ import annotations

import re
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ....errors import InputError
from ....options.named_files import TABLE, text_in
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ..camera import Camera, refuse_distortion
from ..options import SequenceOptions
from ..recorded import CLOCK, INTRINSICS, NO_DEPTH, POSE, Sequence
from . import readers
from ._base import Pair, Row, SequenceReader, at_rate, facts_of, pictures_in, pose_of_matrix, rows_of, scale_fact
from ._dataset import axes_of, clock_of, instant_ns, left_out, refuse_y_up, shared_camera

# The world is that of ROS, x forward and z up; the camera is optical.
_AXES = "world=-y,z,x head=x,-y,z"
_UNIT = 0.001
_LIST = re.compile(r"^(\w+):[^\n]*\n(?:\s+(?:rows|cols|dt):[^\n]*\n)*\s+data:\s*\[([^\]]*)\]", re.MULTILINE)
_NUMBER = re.compile(r"^(image_width|image_height):\s*(\d+)\s*$", re.MULTILINE)


@readers.register
class RtabMapReader(SequenceReader):
    """Exports of `rtabmap-export --images --poses_camera` (or --poses), which name a map NAME.

    Source: RTAB-Map, tools/Export (folders, formats of poses; 11 is its default: stamp x y z qx qy
    qz qw id) and CameraModel (calibration of ROS, with local_transform).
    """

    name = "rtabmap"
    summary = "RTAB-Map export: NAME_rgb/, NAME_depth/, NAME_calib/ and NAME_camera_poses.txt of format 11"
    assumes = (
        Assumption(INTRINSICS, "NAME_calib/ID.yaml, of each image", By.FILE, "--intrinsics"),
        scale_fact(_UNIT, By.FORMAT),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(_AXES)),
        Assumption(POSE, "world from camera, x y z qx qy qz qw", By.FORMAT),
        Assumption(CLOCK, "seconds in the file of poses", By.FILE, "--frames-rate"),
    )

    def fits(self, path: Path) -> int:
        return 91 if _poses(path) is not None and _folder(path, "rgb").is_dir() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        file = _poses(path)
        if file is None:
            raise InputError(f"{path}: no NAME_camera_poses.txt and no NAME_poses.txt; expected {self.summary}")
        colours, depths = (
            {picture.stem: picture for picture in pictures_in(_folder(path, side))} for side in ("rgb", "depth")
        )
        rows, axes = rows_of(file), parse_axes(_AXES)
        pairs, calibrations = [], []
        for at, row in enumerate(rows):
            stem = _stem(row, colours)
            if stem not in colours or stem not in depths:
                continue
            calibration = _calibration(_folder(path, "calib") / f"{stem}.yaml")
            pose = row.floats(9)[1:8]
            matrix = _matrix(row.where, pose)
            matrix = matrix if file.stem.endswith("_camera_poses") else matrix @ calibration.local
            time_ns = instant_ns(row) if options.frames_rate_hz is None else at_rate(options, at)
            turned = pose_of_matrix(axes, row.where, matrix)
            pairs.append(Pair(colours[stem], depths[stem], time_ns, turned))
            calibrations.append(calibration)
        cameras = [calibration.camera for calibration in calibrations]
        if not cameras:
            raise InputError(f"{path}: no row of {file.name} has a picture and depth; expected {self.summary}")
        shared, notes = shared_camera(cameras, cameras[0].size or (1, 1))
        facts = facts_of(path, options, None, _UNIT, own=shared or cameras[0])
        refuse_y_up(path, facts.camera)
        if shared is None and options.intrinsics is None:
            pairs = [attrs.evolve(pair, camera=camera) for pair, camera in zip(pairs, cameras, strict=True)]
        more = () if options.frames_rate_hz is None else (clock_of(options, By.USER),)
        notes += left_out(len(colours) - len(pairs), "no depth or no pose")
        return self.sequence_of(path, pairs, facts, notes=notes, more=more)


def _poses(path: Path) -> Path | None:
    """Return the poses of the camera, else those of the robot."""
    found = [*path.glob("*_camera_poses.txt"), *path.glob("*_poses.txt")] if path.is_dir() else []
    return next((file for file in found if not file.name.endswith("_scan_poses.txt")), None)


def _folder(path: Path, side: str) -> Path:
    return min(path.glob(f"*_{side}"), default=path / f"NAME_{side}")


def _stem(row: Row, colours: dict[str, Path]) -> str:
    """Return the name of a row's pictures: its id, or its stamp. Errors: InputError."""
    if len(row.words) != 9:
        raise row.wrong("nine numbers, stamp x y z qx qy qz qw id, as rtabmap-export --poses_format 11 writes them")
    return next((stem for stem in (row.words[8], row.words[0]) if stem in colours), "")


def _matrix(where: str, numbers: list[float]) -> NDArray[np.float64]:
    """Return the matrix of x y z qx qy qz qw. Errors: InputError."""
    from scipy.spatial.transform import Rotation

    if not abs(float(np.linalg.norm(numbers[3:])) - 1) <= 1e-2:
        raise InputError(f"{where}: a quaternion of length {np.linalg.norm(numbers[3:]):.4g}; expected 1 within 0.01")
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = Rotation.from_quat(numbers[3:]).as_matrix(), numbers[:3]
    return matrix


@attrs.frozen(eq=False)
class _Calibration:
    camera: Camera
    # (4, 4), the robot's frame from the optical one.
    local: NDArray[np.float64]


def _calibration(file: Path) -> _Calibration:
    """Return what a calibration states. Errors: InputError."""
    text = text_in(file, attrs.evolve(TABLE, what="the calibration of its image"))
    try:
        lists = {name: [float(word) for word in numbers.split(",")] for name, numbers in _LIST.findall(text)}
    except ValueError as error:
        raise InputError(f"{file}: {error}; expected lists of numbers") from None
    sizes = {name: int(number) for name, number in _NUMBER.findall(text)}
    refuse_distortion(file, {"distortion_coefficients": lists.get("distortion_coefficients", [])})
    matrix = lists.get("camera_matrix", [])
    if len(matrix) != 9 or len(sizes) != 2:
        raise InputError(f"{file}: no image_width, image_height and camera_matrix of 9 numbers in it; expected them")
    camera = Camera(matrix[0], matrix[4], matrix[2], matrix[5], (sizes["image_width"], sizes["image_height"]))
    local = np.vstack([np.reshape(lists.get("local_transform", np.eye(4)[:3].ravel()), (3, 4)), [0, 0, 0, 1]])
    return _Calibration(camera, local)
