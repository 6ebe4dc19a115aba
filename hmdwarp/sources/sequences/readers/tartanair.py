"""TartanAir: pictures and depth of a simulated camera, and its poses in north, east, down."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....errors import InputError
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ..camera import Camera
from ..options import SequenceOptions
from ..picture_files import NPY, read_colour, read_depth
from ..recorded import NO_DEPTH, POSE, Sequence
from . import readers
from ._base import (
    DEPTHS,
    Pair,
    SequenceReader,
    at_rate,
    facts_of,
    intrinsics_fact,
    pictures_in,
    pose_of_numbers,
    rows_of,
    scale_fact,
)
from ._dataset import axes_of, by_number, clock_of, refuse_y_up

# x forward, y right, z down, of the world and of the camera.
NED = "world=y,-z,x head=y,-z,x"
# 90 degrees across, so that the middle of 640 pixels is at 320: it counts from the first's edge.
FIRST = Camera(320.0, 320.0, 320.0, 240.0, size=(640, 480), centre=0.5)
SECOND = Camera(320.0, 320.0, 320.0, 320.0, size=(640, 640), centre=0.5)
_CAMERAS = {"left": (FIRST, None), "right": (FIRST, None), "lcam_front": (SECOND, 10.0), "rcam_front": (SECOND, 10.0)}


@readers.register
class TartanAirReader(SequenceReader):
    """Trajectories of TartanAir and TartanAir V2, the left camera if it is there.

    Source: Wang et al. 2020, TartanAir: a dataset to push the limits of visual SLAM (its tools'
    data_type.md: camera, metres, NED); tartanair.org, modalities (V2: 10 Hz, depth as four bytes).
    """

    name = "tartanair"
    summary = "TartanAir: image_left/N.png, depth_left/N.npy, pose_left.txt; V2: image_lcam_front/, .."
    assumes = (
        intrinsics_fact(FIRST, By.FORMAT),
        scale_fact(1.0, By.FORMAT),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(NED)),
        Assumption(POSE, "world from camera, x y z qx qy qz qw", By.FORMAT),
        clock_of(SequenceOptions()),
    )

    def fits(self, path: Path) -> int:
        return 92 if _side(path) is not None else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        side = _side(path)
        if side is None:
            raise InputError(f"{path}: no camera with pictures, depth and poses; expected {self.summary}")
        camera, rate_hz = _CAMERAS[side]
        facts, axes = facts_of(path, options, camera, 1.0), parse_axes(NED)
        refuse_y_up(path, facts.camera)
        rows = rows_of(path / f"pose_{side}.txt")
        colours = by_number(path / f"image_{side}", "*.png")
        depths = {int(picture.name.split("_")[0]): picture for picture in pictures_in(path / f"depth_{side}", DEPTHS)}
        whole = sorted(colours.keys() & depths.keys())
        if whole and whole[-1] >= len(rows):
            raise InputError(f"{path}: {len(rows)} poses, and a picture {whole[-1]}; expected a line for each")
        poses = {at: pose_of_numbers(axes, rows[at].where, rows[at].floats(7)) for at in whole}
        clock = clock_of(options, By.FORMAT, rate_hz) if rate_hz else clock_of(options)
        pairs = [Pair(colours[at], depths[at], at_rate(options, at, rate_hz), poses[at]) for at in whole]
        return self.sequence_of(path, pairs, facts, more=(axes_of(axes), clock), depth_of=_depth)


def _side(path: Path) -> str | None:
    """Return the first camera that has pictures, depth and poses."""
    return next(
        (
            side
            for side in _CAMERAS
            if (path / f"pose_{side}.txt").exists()
            and all((path / f"{kind}_{side}").is_dir() for kind in ("image", "depth"))
        ),
        None,
    )


def _depth(path: Path) -> NDArray[Any]:
    """Return metres: of an .npy file, or floats of the bytes blue, green, red, alpha."""
    if path.suffix == NPY:
        return read_depth(path)
    pixels = read_colour(path)
    if pixels.shape[2] != 4 or pixels.dtype != np.uint8:
        raise InputError(f"{path}: {pixels.shape[2]} channels; expected four bytes a pixel, of one float")
    return np.ascontiguousarray(pixels[..., [2, 1, 0, 3]]).view("<f4")[..., 0]
