"""7-Scenes: three files a frame, colour, depth and pose."""

from __future__ import annotations

from pathlib import Path

from ....errors import InputError
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ..camera import Camera
from ..options import SequenceOptions
from ..recorded import NO_DEPTH, POSE, Sequence
from . import readers
from ._base import OPTICAL, Pair, SequenceReader, at_rate, facts_of, intrinsics_fact, scale_fact, sequence_of
from ._dataset import axes_of, by_number, clock_of, left_out, poses_in_files

# The data set's page gives them for depth and says that neither camera was calibrated.
KINECT = Camera(585.0, 585.0, 320.0, 240.0, size=(640, 480))
_UNIT = 0.001
_UNREGISTERED = "Colour and depth of 7-Scenes are of two cameras and not registered to each other."


class SevenScenesReader(SequenceReader):
    """Sequences of 7-Scenes; matrices from camera to world, depth in millimetres.

    Source: Shotton et al. 2013, Scene coordinate regression forests for camera relocalization in
    RGB-D images (the data set's page: the files of a frame, 65535 for no depth, 585/320/240).
    """

    name = "seven_scenes"
    summary = "7-Scenes: frame-N.color.png, frame-N.depth.png and frame-N.pose.txt"
    assumes = (
        intrinsics_fact(KINECT, By.FORMAT),
        scale_fact(_UNIT, By.FORMAT),
        Assumption(NO_DEPTH, "0 or 65535", By.FORMAT, "--no-depth"),
        axes_of(parse_axes(OPTICAL)),
        Assumption(POSE, "world from camera, matrices by rows", By.FORMAT),
        clock_of(SequenceOptions()),
    )

    def fits(self, path: Path) -> int:
        return 90 if any(path.glob("frame-*.pose.txt")) else 40 if _sequences_in(path) else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        if inner := _sequences_in(path):
            raise InputError(f"{path}: holds the sequences {', '.join(inner)}: name one of these folders")
        facts = facts_of(path, options, KINECT, _UNIT)
        axes = facts.axes()
        colours, depths, files = (
            by_number(path, f"frame-*.{ending}") for ending in ("color.png", "depth.png", "pose.txt")
        )
        poses = poses_in_files(axes, files)
        whole = sorted(colours.keys() & depths.keys() & poses.keys())
        pairs = [Pair(colours[at], depths[at], at_rate(options, at), poses[at]) for at in whole]
        notes = left_out(len(colours) - len(pairs), "no depth, or no pose of finite numbers")
        more = (axes_of(axes), clock_of(options))
        return sequence_of(self, path, pairs, facts, notes=[_UNREGISTERED, *notes], more=more)


def _sequences_in(path: Path) -> list[str]:
    """Return the folders of a scene's sequences."""
    return sorted({pose.parent.name for pose in path.glob("seq-*/frame-*.pose.txt")})


readers.register(SevenScenesReader())
