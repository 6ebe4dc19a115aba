"""What readers of data sets share: a matrix a file, frames by number, what a folder leaves open."""

from __future__ import annotations

import re
from collections.abc import Mapping
from collections.abc import Sequence as Rows
from decimal import Decimal, InvalidOperation
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray

from ....errors import InputError
from ....geometry import Pose
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import Axes
from ..camera import Camera, Size
from ..options import RATE_HZ, SequenceOptions
from ..recorded import AXES, CLOCK
from ._base import Row, poses_of, rows_of

_BREATHES = 0.005  # of the width: telephones focus within it


def matrix_in(path: Path, size: int = 4) -> NDArray[np.float64]:
    """Return the matrix of (size, size) numbers in a text file; it may hold inf or NaN.

    Errors: InputError.
    """
    rows = rows_of(path)
    found = []
    for row in rows:
        try:
            found.append([float(word) for word in row.words])
        except ValueError:
            raise row.wrong(f"{size} numbers") from None
    if [len(row) for row in found] != [size] * size:
        raise InputError(f"{path}: {len(found)} lines; expected a matrix, {size} lines of {size} numbers")
    return np.array(found)


def poses_in_files(axes: Axes, files: Mapping[int, Path]) -> dict[int, Pose]:
    """Return world_from_eye of files of a matrix, from camera to world; not those of inf or NaN."""
    matrices = {number: matrix_in(path) for number, path in files.items()}
    whole = [(number, matrix) for number, matrix in matrices.items() if np.isfinite(matrix).all()]
    poses, _ = poses_of(axes, [(str(files[number]), matrix) for number, matrix in whole])
    return dict(zip((number for number, _ in whole), poses, strict=True))


def inverse_of(where: str, matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the inverse of a (4, 4) matrix. Errors: InputError where it has none."""
    try:
        return np.asarray(np.linalg.inv(matrix), np.float64)
    except np.linalg.LinAlgError:
        raise InputError(f"{where}: the matrix has no inverse; expected a rotation and a position") from None


def by_number(folder: Path, pattern: str) -> dict[int, Path]:
    """Return the files of a folder by the first number in their names."""
    files = (path for path in sorted(folder.glob(pattern)) if not path.name.startswith("."))
    numbers = ((re.search(r"\d+", path.name), path) for path in files)
    return {int(number.group()): path for number, path in numbers if number}


def refuse_y_up(path: Path, camera: Camera) -> None:
    """Raise InputError for a camera whose y points up, where the layout's points down."""
    if camera.is_y_up:
        raise InputError(f"{path}: fy is {camera.fy:g}; expected above 0, as its layout has it")


def instant_ns(row: Row, column: int = 0) -> int:
    """Return the nanoseconds of seconds in a row, to the last digit. Errors: InputError."""
    try:
        return int(Decimal(row.words[column]) * 10**9)
    except (InvalidOperation, ValueError, OverflowError):
        raise row.wrong("seconds") from None


def shared_camera(cameras: Rows[Camera], size: Size) -> tuple[Camera | None, list[str]]:
    """Return one camera for frames whose focus breathes, and the note on it; None for none or many.

    It is the median, where no pixel moves by more than 0.5 % of the width; a replay takes one.
    """
    if not cameras:
        return None, []
    numbers = np.array([(camera.fx, camera.fy, camera.cx, camera.cy) for camera in cameras])
    fx, fy, cx, cy = middle = np.median(numbers, axis=0)
    apart = np.abs(numbers - middle)
    moved = (apart[:, :2] / (fx, fy) * size / 2 + apart[:, 2:]).max()
    if moved > _BREATHES * size[0]:
        return None, []
    note = f"Intrinsics differ from frame to frame, by up to {moved:.2g} px at the border: their median is taken."
    return attrs.evolve(cameras[0], fx=fx, fy=fy, cx=cx, cy=cy), [note] if moved > 0 else []


def left_out(count: int, why: str) -> list[str]:
    """Return the note on frames that were left out, if there are any."""
    return [f"{count} frames were left out: {why}."] if count else []


def clock_of(options: SequenceOptions, by: By = By.NOBODY, rate_hz: float = RATE_HZ, file: str = "") -> Assumption:
    """Return the entry for the instants of frames.

    by: who says rate_hz, if the user states none. file: how the files state instants, "" for not.
    """
    stated = options.frames_rate_hz
    if file and stated is None:
        return Assumption(CLOCK, file, By.FILE, "--frames-rate")
    return Assumption(CLOCK, f"{stated or rate_hz:g} frames per second", By.USER if stated else by, "--frames-rate")


def axes_of(axes: Axes, by: By = By.FORMAT) -> Assumption:
    """Return the entry for axes."""
    return Assumption(AXES, axes.words(), by)
