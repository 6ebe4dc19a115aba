"""7-Scenes and its kin: three files a frame, colour, depth and pose, and maybe a calibration."""

from __future__ import annotations

from pathlib import Path

import attrs
import numpy as np

from ....errors import InputError
from ....options.named_files import LIST, content_of
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import parse_axes
from ..camera import Camera, camera_of, number_of
from ..options import SequenceOptions
from ..picture_files import size_of
from ..recorded import NO_DEPTH, POSE, Sequence
from . import readers
from ._base import OPTICAL, Pair, SequenceReader, at_rate, facts_of, intrinsics_fact, scale_fact
from ._dataset import axes_of, by_number, clock_of, depth_fit, left_out, matrix_in, poses_in_files, refuse_moved

# The data set's page gives them for depth and says that neither camera was calibrated.
KINECT = Camera(585.0, 585.0, 320.0, 240.0, size=(640, 480))
_UNIT = 0.001
_INFO, _MATRIX = ("info.txt", "_info.txt"), "camera-intrinsics.txt"
_UNREGISTERED = "Colour and depth of 7-Scenes are of two cameras and not registered to each other."


@readers.register
class SevenScenesReader(SequenceReader):
    """Sequences of 7-Scenes; matrices from camera to world, depth in millimetres.

    Source: Shotton et al. 2013, Scene coordinate regression forests for camera relocalization in
    RGB-D images (the data set's page: the files of a frame, 65535 for no depth, 585/320/240). The
    same names with info.txt: 12-Scenes, BundleFusion, 3RScan; with camera-intrinsics.txt: 3DMatch.
    """

    name = "seven_scenes"
    summary = (
        "7-Scenes, 12-Scenes, BundleFusion, 3RScan, 3DMatch: frame-N.color.*, frame-N.depth.* and frame-N.pose.txt, "
        f"and maybe {_INFO[0]} or {_MATRIX} there or above"
    )
    assumes = (
        intrinsics_fact(KINECT, By.NOBODY),
        scale_fact(_UNIT, By.NOBODY),
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
        stated = _stated(path)
        facts = facts_of(path, options, KINECT, _UNIT, own=stated.colour, own_scale=stated.scale, by=By.NOBODY)
        axes = facts.axes()
        colours, depths, files = (
            by_number(path, f"frame-*[0-9].{ending}") for ending in ("color.*", "depth.*", "pose.txt")
        )
        poses, way = poses_in_files(axes, files)
        whole = sorted(colours.keys() & depths.keys() & poses.keys())
        pairs = [Pair(colours[at], depths[at], at_rate(options, at), poses[at]) for at in whole]
        notes = [] if stated.colour or options.intrinsics else [_UNREGISTERED]
        notes += left_out(len(colours) - len(pairs), "no depth, or no pose of finite numbers")
        more = (axes_of(axes), way, clock_of(options))
        size, of_depth = (size_of(side[whole[0]]) if whole else (1, 1) for side in (colours, depths))
        fit = depth_fit(size, of_depth, facts.camera, stated.depth)
        return self.sequence_of(path, pairs, facts, notes=notes, more=more, fit=fit)


@attrs.frozen
class _Stated:
    colour: Camera | None = None
    # Of its own pixels, where those are others than of colour.
    depth: Camera | None = None
    # Metres per unit.
    scale: float | None = None


def _stated(path: Path) -> _Stated:
    """Return what files of the sequence or of its scene state. Errors: InputError."""
    places = (path, path.resolve().parent)
    info = next((place / name for place in places for name in _INFO if (place / name).exists()), None)
    text = "" if info is None else content_of(info, LIST).decode("utf-8", "replace")
    if info is not None and "m_calibrationColorIntrinsic" in text:
        return _of_info(info, text)
    file = next((place / _MATRIX for place in places if (place / _MATRIX).exists()), None)
    if file is None:
        return _Stated()
    matrix = matrix_in(file, 3)
    camera = camera_of(file, {"intrinsic_matrix": matrix.tolist()})
    return _Stated(camera, camera)


def _of_info(file: Path, text: str) -> _Stated:
    """Return cameras and scale of lines such as m_depthShift = 1000. Errors: InputError."""
    values = {key.strip(): value.split() for key, _, value in (line.partition("=") for line in text.splitlines())}

    def numbers(key: str, *counts: int) -> list[float]:
        try:
            found = [float(word) for word in values.get(key, [])]
        except ValueError:
            found = []
        if len(found) not in counts or not np.isfinite(found).all():
            raise InputError(
                f"{file}: {key} is {' '.join(values.get(key, [])) or 'missing'}; expected {counts[0]} numbers"
            )
        return found

    def camera(side: str) -> Camera:
        at = numbers(f"m_calibration{side}Intrinsic", 16, 12)
        sides = [round(numbers(f"m_{side.lower()}{way}", 1)[0]) for way in ("Width", "Height")]
        moved = f"m_calibration{side}Extrinsic"
        if moved in values:
            refuse_moved(f"{file}, {moved}", np.reshape(numbers(moved, 16), (4, 4)))
        rows = [at[0:3], at[4:7], at[8:11]]
        found = camera_of(file, {"intrinsic_matrix": rows, "w": sides[0], "h": sides[1]})
        assert found is not None  # there is a matrix
        return found

    shift = number_of(file, "m_depthShift", numbers("m_depthShift", 1)[0], "units per metre, above 0", above=0)
    return _Stated(camera("Color"), camera("Depth"), 1 / shift)


def _sequences_in(path: Path) -> list[str]:
    """Return the folders of a scene's sequences."""
    return sorted({pose.parent.name for pose in path.glob("seq-*/frame-*.pose.txt")})
