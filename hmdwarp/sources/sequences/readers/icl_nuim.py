"""ICL-NUIM in its form for TUM's tools: numbered pictures, and a trajectory by their numbers."""

from __future__ import annotations

from pathlib import Path

from ....poses.assumptions import Assumption, By
from ..camera import Camera
from ..options import SequenceOptions
from ..recorded import AXES, NO_DEPTH, POSE, Sequence
from . import readers
from ._base import (
    VGA,
    Pair,
    SequenceReader,
    at_rate,
    facts_of,
    folder_named,
    for_size,
    intrinsics_fact,
    pictures_in,
    pose_of_numbers,
    rows_of,
    scale_fact,
)
from ._dataset import clock_of

# The renderer's y points up.
CAMERA_OF_RENDERER = Camera(481.2, -480.0, 319.5, 239.5, VGA)
_TRAJECTORY = "*.gt.freiburg"
_UNIT = 1 / 5000


@readers.register
class IclNuimReader(SequenceReader):
    """ICL-NUIM sequences.

    Source: Handa et al. 2014, A benchmark for RGB-D visual odometry, 3D reconstruction and SLAM
    (the data set's page: camera, depth / 5000, 30 Hz).
    """

    name = "icl_nuim"
    summary = f"ICL-NUIM: rgb/N.png, depth/N.png and {_TRAJECTORY}"
    assumes = (
        intrinsics_fact(CAMERA_OF_RENDERER, By.FORMAT),
        for_size(scale_fact(_UNIT, By.FORMAT), VGA),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        Assumption(AXES, "x right, y up, z forward, in a left-handed world", By.FORMAT),
        Assumption(POSE, "world from camera, x y z qx qy qz qw", By.FORMAT),
        clock_of(SequenceOptions(), By.FORMAT),
    )

    def fits(self, path: Path) -> int:
        return 90 if path.is_dir() and any(path.glob(_TRAJECTORY)) and (path / "rgb").is_dir() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        facts = facts_of(path, options, CAMERA_OF_RENDERER, _UNIT, only_for=VGA)
        axes, file = facts.axes(), min(path.glob(_TRAJECTORY), default=path / "trajectory.gt.freiburg")
        colours, depths = (
            {picture.stem: picture for picture in pictures_in(folder_named(path, name))} for name in ("rgb", "depth")
        )
        pairs = []
        for row in rows_of(file):
            index, *pose = row.floats(8)
            stem = str(int(index))
            if stem in colours and stem in depths:
                turned = pose_of_numbers(axes, row.where, pose)
                pairs.append(Pair(colours[stem], depths[stem], at_rate(options, int(index)), turned))
        missing = len(colours) - len(pairs)
        notes = [f"{missing} pictures were left out: they have no depth or no pose."] if missing else []
        more = [] if options.frames_rate_hz is None else [clock_of(options)]
        return self.sequence_of(path, pairs, facts, notes=notes, more=more)
