"""Stray Scanner: the video, depth and odometry of a telephone with a depth camera."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from pathlib import Path

from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ..camera import Camera
from ..options import SequenceOptions
from ..picture_files import NPY, VideoPictures, fitted_depth, read_depth
from ..recorded import CLOCK, INTRINSICS, NO_DEPTH, POSE, Pictures, RecordedFrame, Sequence, as_pictures, in_metres
from . import readers
from ._base import Row, SequenceReader, at_rate, facts_of, pictures_in, pose_of_numbers, rows_of, scale_fact
from ._dataset import axes_of, clock_of, instant_ns, left_out, matrix_in, refuse_y_up, shared_camera

VIDEO, CAMERA, ODOMETRY = "rgb.mp4", "camera_matrix.csv", "odometry.csv"
# The world is ARKit's, y up; the camera was turned to x right, y down, z forward.
_AXES = "world=x,y,-z head=x,-y,z"
_UNIT = 0.001
_CLOCK = Assumption(CLOCK, f"seconds in {ODOMETRY}", By.FILE, "--frames-rate")
_HEADER = ["timestamp", "frame", "x", "y", "z", "qx", "qy", "qz", "qw"]


@readers.register
class StrayScannerReader(SequenceReader):
    """Recordings of Stray Scanner, whose depth has fewer pixels and the same field of view.

    Later ones have intrinsics in each row, which hold before those of the file.
    Source: Stray Robots documentation, data specification; for the axes, the app's OdometryEncoder.
    """

    name = "stray_scanner"
    summary = f"Stray Scanner: {VIDEO}, depth/N.png, {ODOMETRY} and {CAMERA}"
    assumes = (
        Assumption(INTRINSICS, CAMERA, By.FILE, "--intrinsics"),
        scale_fact(_UNIT, By.FORMAT),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(_AXES)),
        Assumption(POSE, "world from camera, x y z qx qy qz qw", By.FORMAT),
        _CLOCK,
    )

    def fits(self, path: Path) -> int:
        return 93 if (path / ODOMETRY).exists() and (path / VIDEO).exists() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        rows, matrix = _rows(path / ODOMETRY), matrix_in(path / CAMERA, 3)
        video, axes = VideoPictures(path / VIDEO), parse_axes(_AXES)
        cameras = [_camera(row.first(13)[9:]) for row in rows if len(row.words) >= 13]
        shared, notes = shared_camera(cameras, video.size)
        facts = facts_of(path, options, None, _UNIT, own=shared or _camera(matrix[(0, 1, 0, 1), (0, 1, 2, 2)]))
        refuse_y_up(path, facts.camera)
        if shared is not None or len(cameras) < len(rows) or options.intrinsics is not None:
            cameras = [facts.camera] * len(rows)
        fovs = [camera.fov(video.size, str(path / CAMERA)) for camera in cameras]
        depths = {int(file.stem): file for file in pictures_in(path / "depth", (".png", NPY)) if file.stem.isdigit()}
        frames = []
        for at, row in enumerate(rows):
            number, *pose = row.first(9)[1:]
            if int(number) in depths:
                time_ns = instant_ns(row) if options.frames_rate_hz is None else at_rate(options, at)
                depth = depths[int(number)]
                read = _reading(video, at, depth, facts.depth_scale)
                turned = pose_of_numbers(axes, row.where, pose)
                frames.append(
                    RecordedFrame(
                        f"{VIDEO} {at}", time_ns, turned, fovs[at], video.size, read, partial(read_depth, depth)
                    )
                )
        more = () if options.frames_rate_hz is None else (clock_of(options, By.USER),)
        notes += left_out(len(rows) - len(frames), "no depth")
        return self.made(path, frames, notes=notes, assumptions=(*facts.assumptions, *more))


def _camera(numbers: Iterable[float]) -> Camera:
    fx, fy, cx, cy = map(float, numbers)
    return Camera(fx, fy, cx, cy)


def _rows(file: Path) -> list[Row]:
    """Return the rows below the header. Errors: InputError."""
    head, *rows = rows_of(file) or [Row(str(file), ["nothing"])]
    if head.words[: len(_HEADER)] != _HEADER:
        raise head.wrong(f"the header {', '.join(_HEADER)}")
    return rows


def _reading(video: VideoPictures, number: int, depth: Path, scale: float) -> Callable[[], Pictures]:
    """Return what reads a picture of the video and its depth."""

    def read() -> Pictures:
        colour = video.picture(number)
        return as_pictures(colour, in_metres(fitted_depth(read_depth(depth), colour, depth), scale))

    return read
