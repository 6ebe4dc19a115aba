"""ScanNet, extracted from its .sens files: colour, depth and pose by number, and intrinsics."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ....errors import InputError
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ..camera import Camera, Size
from ..options import SequenceOptions
from ..picture_files import size_of
from ..recorded import INTRINSICS, NO_DEPTH, POSE, Sequence
from . import readers
from ._base import Pair, SequenceReader, at_rate, facts_of, pictures_in, scale_fact
from ._dataset import axes_of, by_number, clock_of, depth_fit, left_out, matrix_in, poses_in_files, refuse_moved

_WORLD = "x,z,y"  # z up
_UNIT = 0.001
_OFF_CENTRE = 0.15  # of a picture's side, which no camera of the set's reaches


@readers.register
class ScanNetReader(SequenceReader):
    """Scans of ScanNet; matrices from camera to world, those of -inf where tracking was lost.

    Source: Dai et al. 2017, ScanNet: richly-annotated 3D reconstructions of indoor scenes (its
    SensReader: names, depth shift 1000, 4x4 intrinsics and extrinsics; 30 Hz).
    """

    name = "scannet"
    summary = "ScanNet, extracted: color/N.jpg, depth/N.png, pose/N.txt, intrinsic/intrinsic_color.txt"
    assumes = (
        Assumption(INTRINSICS, "intrinsic/intrinsic_color.txt", By.FILE, "--intrinsics"),
        scale_fact(_UNIT, By.FORMAT),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(f"world={_WORLD} head=x,-y,z")),
        Assumption(POSE, "world from camera, matrices by rows", By.FORMAT),
        clock_of(SequenceOptions(), By.FORMAT),
    )

    def fits(self, path: Path) -> int:
        known = all((path / name).is_dir() for name in ("color", "depth", "pose"))
        return 88 if known and _file(path, "intrinsic_color") is not None else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        for side in ("color", "depth"):
            if (file := _file(path, f"extrinsic_{side}")) is not None:
                refuse_moved(str(file), matrix_in(file))
        colours = {int(picture.stem): picture for picture in pictures_in(path / "color") if picture.stem.isdigit()}
        depths, files = by_number(path / "depth", "*.png"), by_number(path / "pose", "*.txt")
        first = min(colours.keys() & depths.keys(), default=None)
        if first is None:
            raise InputError(f"{path}: no number in both color and depth; expected {self.summary}")
        cameras = {side: _camera(_file(path, f"intrinsic_{side}")) for side in ("color", "depth")}
        size, depth_size = size_of(colours[first]), size_of(depths[first])
        own = cameras["color"]
        # Sets that shrank their colour to the depth's pixels left the file of the larger one.
        if own is not None and not _centred(own, size) and size == depth_size:
            own = cameras["depth"]
        if own is not None and options.intrinsics is None and not _centred(own, size):
            raise InputError(
                f"{path}: intrinsic_color.txt has its centre at {own.cx:g},{own.cy:g}, which is not the middle of "
                f"pictures of {size[0]}x{size[1]}: give those of the pictures by --intrinsics FX,FY,CX,CY"
            )
        facts = facts_of(path, options, None, _UNIT, own=own)
        axes = facts.axes(_WORLD)
        poses, way = poses_in_files(axes, files)
        whole = sorted(colours.keys() & depths.keys() & poses.keys())
        pairs = [Pair(colours[at], depths[at], at_rate(options, at), poses[at]) for at in whole]
        notes = left_out(len(colours) - len(pairs), "no depth, or no pose of finite numbers")
        more = (axes_of(axes), way, clock_of(options, By.FORMAT))
        fit = depth_fit(size, depth_size, facts.camera, cameras["depth"])
        return self.sequence_of(path, pairs, facts, notes=notes, more=more, fit=fit)


def _file(path: Path, name: str) -> Path | None:
    """Return a file of the calibration: of the full sets, or of their frames_25k."""
    places = (path / "intrinsic" / f"{name}.txt", path / f"{name.replace('intrinsic_', 'intrinsics_')}.txt")
    return next((place for place in places if place.exists()), None)


def _camera(file: Path | None) -> Camera | None:
    if file is None:
        return None
    matrix = matrix_in(file)
    fx, fy, cx, cy = (float(matrix[at]) for at in ((0, 0), (1, 1), (0, 2), (1, 2)))
    if not np.isfinite(matrix).all() or min(fx, fy) <= 0:
        raise InputError(f"{file}: focal lengths {fx:g}, {fy:g}; expected a 4x4 matrix with both above 0, in pixels")
    return Camera(fx, fy, cx, cy)


def _centred(camera: Camera, size: Size) -> bool:
    sides = zip((camera.cx, camera.cy), size, strict=True)
    return all(abs((centre + 0.5) / side - 0.5) < _OFF_CENTRE for centre, side in sides)
