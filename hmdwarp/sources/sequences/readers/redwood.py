"""Redwood and Open3D: colour and depth by number, and a trajectory of matrices."""

from __future__ import annotations

from pathlib import Path

from ....errors import InputError
from ..camera import Camera, camera_of, read_json
from ..options import SequenceOptions
from ..recorded import Sequence
from . import readers
from ._base import Pair, SequenceReader, at_rate, facts_of, folder_named, paired, pose_of_matrix, rows_of, sequence_of

_LOGS = ("trajectory.log", "scene/trajectory.log")
_INTRINSICS = ("camera_intrinsic.json", "intrinsic.json", "camera_primesense.json")
# Of the data set's depth cameras, and Open3D's own default.
PRIMESENSE = Camera(525.0, 525.0, 319.5, 239.5)
_COLOURS = ("color", "rgb", "image", "colour")


class RedwoodReader(SequenceReader):
    """Redwood and Open3D sequences, whose world is the first camera.

    Source: Choi, Zhou and Koltun 2015, Robust reconstruction of indoor scenes (the data set's page:
    .log files); Open3D documentation, camera.PinholeCameraIntrinsic and the reconstruction system.
    """

    name = "redwood"
    summary = "Redwood, Open3D: color/, depth/, trajectory.log, and maybe camera_intrinsic.json"

    def fits(self, path: Path) -> int:
        return 85 if _log(path) is not None and (path / "depth").is_dir() else 0

    def read(self, path: Path, options: SequenceOptions) -> Sequence:
        file = _log(path)
        if file is None:
            raise InputError(f"{path}: no trajectory.log; expected {self.summary}")
        named = next((path / name for name in _INTRINSICS if (path / name).is_file()), None)
        own = camera_of(named, read_json(named)) if named is not None else None
        facts = facts_of(path, options, own or PRIMESENSE, 0.001)
        axes, files = facts.axes(), paired(folder_named(path, *_COLOURS), path / "depth")
        poses = _matrices(file)
        numbers = [number for number, _, _ in poses]
        if len(poses) == len(files):
            numbers = list(range(len(files)))
        elif len(set(numbers)) < len(numbers) or not all(0 <= number < len(files) for number in numbers):
            raise InputError(
                f"{file}: {len(poses)} poses for {len(files)} pictures; expected one for each, or their numbers"
            )
        pairs = [
            Pair(*files[number], at_rate(options, number), pose_of_matrix(axes, where, matrix))
            for number, (_, where, matrix) in zip(numbers, poses, strict=True)
        ]
        return sequence_of(self, path, pairs, facts)


def _log(path: Path) -> Path | None:
    """Return the trajectory of a folder, by its usual names, or the only .log file there is."""
    named = next((path / name for name in _LOGS if (path / name).is_file()), None)
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


readers.register(RedwoodReader())
