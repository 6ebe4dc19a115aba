"""Redwood and Open3D: colour and depth by number, and a trajectory of matrices."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ....errors import InputError
from ....poses.assumptions import Assumption, By
from ..camera import Camera, camera_of, number_of, read_json, unread_notes
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
    intrinsics_fact,
    paired,
    poses_of,
    rows_of,
    scale_fact,
)
from ._dataset import clock_of

_READ = ("fps", "stream_length_usec", "color_format", "depth_format", "device_name", "serial_number")
_LOGS = ("trajectory.log", "scene/trajectory.log")
_INTRINSICS = ("camera_intrinsic.json", "intrinsic.json", "camera_primesense.json")
# Of the data set's depth cameras, and Open3D's own default.
PRIMESENSE = Camera(525.0, 525.0, 319.5, 239.5, VGA)
_UNIT = 1e-3  # of depth, by default in Open3D
_COLOURS = ("color", "rgb", "image", "colour")


@readers.register
class RedwoodReader(SequenceReader):
    """Redwood and Open3D sequences, whose world is the first camera.

    Source: Choi, Zhou and Koltun 2015, Robust reconstruction of indoor scenes (the data set's page:
    .log files); Open3D documentation, camera.PinholeCameraIntrinsic and the reconstruction system.
    """

    name = "redwood"
    summary = "Redwood, Open3D: color/, depth/, trajectory.log, and maybe camera_intrinsic.json"
    assumes = (
        intrinsics_fact(PRIMESENSE, By.NOBODY),
        scale_fact(_UNIT, By.NOBODY),
        Assumption(NO_DEPTH, "0", By.FORMAT, "--no-depth"),
        Assumption(AXES, "x right, y down, z forward", By.FORMAT),
        Assumption(POSE, "world from camera, matrices by rows", By.FORMAT),
        clock_of(SequenceOptions()),
    )

    def fits(self, path: Path) -> int:
        return 85 if _log(path) is not None and (path / "depth").is_dir() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        file = _log(path)
        if file is None:
            raise InputError(f"{path}: no trajectory.log; expected {self.summary}")
        named = next((path / name for name in _INTRINSICS if (path / name).exists()), None)
        stated = read_json(named) if named is not None else {}
        own = camera_of(named, stated) if named is not None else None
        facts = facts_of(path, options, PRIMESENSE, _UNIT, own=own, own_scale=_scale(named, stated), by=By.NOBODY)
        axes, files = facts.axes(), paired(folder_named(path, *_COLOURS), path / "depth")
        poses = _matrices(file)
        numbers = [number for number, _, _ in poses]
        if len(poses) == len(files):
            numbers = list(range(len(files)))
        elif len(set(numbers)) < len(numbers) or not all(0 <= number < len(files) for number in numbers):
            raise InputError(
                f"{file}: {len(poses)} poses for {len(files)} pictures; expected one for each, or their numbers"
            )
        turned, way = poses_of(axes, [(where, matrix) for _, where, matrix in poses])
        pairs = [
            Pair(*files[number], at_rate(options, number), pose) for number, pose in zip(numbers, turned, strict=True)
        ]
        notes = unread_notes(named, stated, _READ) if named is not None else []
        return self.sequence_of(path, pairs, facts, notes=notes, more=[way, clock_of(options)])


def _scale(where: Path | None, stated: Mapping[str, Any]) -> float | None:
    """Return metres per unit of what Open3D states, which are units per metre."""
    if where is None or stated.get("depth_scale") is None:
        return None
    per_metre = number_of(where, "depth_scale", stated["depth_scale"], "units per metre, above 0", above=0)
    return 1 / per_metre if per_metre >= 1 else per_metre


def _log(path: Path) -> Path | None:
    """Return the trajectory of a folder, by its usual names, or the only .log file there is."""
    named = next((path / name for name in _LOGS if (path / name).exists()), None)
    others = sorted(path.glob("*.log")) if path.is_dir() else []
    return named or (others[0] if len(others) == 1 else None)


def _matrices(file: Path) -> list[tuple[int, str, list[list[float]]]]:
    """Return number, place and matrix of each pose. Errors: InputError."""
    rows = rows_of(file)
    if len(rows) % 5:
        raise InputError(f"{file}: {len(rows)} lines; expected five for each pose, a line of numbers and a matrix")
    found = []
    for at in range(0, len(rows), 5):
        head, *matrix = rows[at : at + 5]
        if len(head.words) not in (1, 2, 3) or not head.words[0].lstrip("-").isdigit():
            raise head.wrong("the numbers of a frame")
        found.append((int(head.words[0]), head.where, [row.floats(4) for row in matrix]))
    return found
