"""Numbered pictures and one line of a pose for each, as small examples and robots write them."""

from __future__ import annotations

from pathlib import Path

from ....errors import InputError
from ....poses.assumptions import Assumption, By
from ..options import SequenceOptions
from ..recorded import AXES, DEPTH_SCALE, INTRINSICS, NO_DEPTH, POSE, Sequence
from . import readers
from ._base import Pair, SequenceReader, at_rate, facts_of, folder_named, paired, pose_of_numbers, rows_of
from ._dataset import clock_of

POSES = ("pose.txt", "poses.txt")


@readers.register
class NumberedReader(SequenceReader):
    """Pictures by number, with poses from camera to world; x right, y down, z forward.

    Source: Gao and Zhang 2021, Introduction to visual SLAM (ch5/rgbd of its code).
    """

    name = "numbered"
    summary = "color/N.png, depth/N.png or .pgm, and pose.txt: x y z qx qy qz qw, a line for each; --intrinsics"
    assumes = (
        Assumption(INTRINSICS, "to be stated", By.USER, "--intrinsics"),
        Assumption(DEPTH_SCALE, "to be stated", By.USER, "--depth-scale"),
        Assumption(NO_DEPTH, "0", By.NOBODY, "--no-depth"),
        Assumption(AXES, "x right, y down, z forward", By.NOBODY),
        Assumption(POSE, "world from camera, x y z qx qy qz qw", By.NOBODY),
        clock_of(SequenceOptions()),
    )

    def fits(self, path: Path) -> int:
        if not _poses(path).exists() or not (path / "depth").is_dir():
            return 0
        return 80 if all(len(row.words) == 7 for row in rows_of(_poses(path))[:1]) else 20  # others are traces

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        facts, file = facts_of(path, options, None, None), _poses(path)
        axes, rows = facts.axes(), rows_of(file)
        files = paired(folder_named(path, "color", "colour", "rgb", "image"), path / "depth")
        if len(rows) != len(files):
            raise InputError(f"{file}: {len(rows)} poses for {len(files)} pictures; expected one for each")
        pairs = [
            Pair(colour, depth, at_rate(options, i), pose_of_numbers(axes, row.where, row.floats(7)))
            for i, (row, (colour, depth)) in enumerate(zip(rows, files, strict=True))
        ]
        return self.sequence_of(path, pairs, facts, more=[clock_of(options)])


def _poses(path: Path) -> Path:
    return next((path / name for name in POSES if (path / name).exists()), path / POSES[0])
