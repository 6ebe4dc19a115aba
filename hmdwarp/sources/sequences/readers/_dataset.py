"""What readers of data sets share: a matrix a file, frames by number, what a folder leaves open."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from collections.abc import Sequence as Rows
from decimal import Decimal, InvalidOperation
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ....errors import InputError
from ....geometry import Pose
from ....poses.assumptions import Assumption, By
from ....poses.reading.axes import Axes
from ..camera import Camera, Size
from ..options import RATE_HZ, SequenceOptions
from ..picture_files import fitted_depth
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


def poses_in_files(axes: Axes, files: Mapping[int, Path]) -> tuple[dict[int, Pose], Assumption]:
    """Return world_from_eye of files of a matrix, from camera to world, and how they are written.

    Not those of inf or NaN.
    """
    matrices = {number: matrix_in(path) for number, path in files.items()}
    whole = [(number, matrix) for number, matrix in matrices.items() if np.isfinite(matrix).all()]
    poses, way = poses_of(axes, [(str(files[number]), matrix) for number, matrix in whole])
    return dict(zip((number for number, _ in whole), poses, strict=True)), way


def by_number(folder: Path, pattern: str) -> dict[int, Path]:
    """Return the files of a folder by the first number in their names."""
    files = (path for path in sorted(folder.glob(pattern)) if not path.name.startswith("."))
    numbers = ((re.search(r"\d+", path.name), path) for path in files)
    return {int(number.group()): path for number, path in numbers if number}


def refuse_moved(where: str, matrix: NDArray[np.float64]) -> None:
    """Raise InputError where colour and depth were taken from different places."""
    if np.abs(matrix - np.eye(4)).max() > 1e-3:
        raise InputError(f"{where}: no unit matrix; expected depth that is registered to the colour")


def depth_fit(
    size: Size, of_depth: Size, camera: Camera, camera_of_depth: Camera | None
) -> Callable[..., NDArray[Any]]:
    """Return what takes depth to the colour's pixels: as it is where both have as many."""
    return _same_size if size == of_depth else _through_cameras(camera, camera_of_depth)


def _same_size(depth: NDArray[Any], colour: NDArray[Any], where: object) -> NDArray[Any]:
    if depth.shape != colour.shape[:2]:
        raise InputError(f"{where}: depth of {depth.shape[::-1]} pixels; expected as many as its colour has")
    return depth


def _through_cameras(camera: Camera, of_depth: Camera | None) -> Callable[..., NDArray[Any]]:
    """Return what takes the depth of another camera in the same place to the colour's pixels."""
    if of_depth is None:
        return fitted_depth

    def fit(depth: NDArray[Any], colour: NDArray[Any], where: object) -> NDArray[Any]:
        (high, wide), (rows, columns) = colour.shape[:2], depth.shape
        row = np.rint((np.arange(high) - camera.cy) / camera.fy * of_depth.fy + of_depth.cy).astype(int)
        column = np.rint((np.arange(wide) - camera.cx) / camera.fx * of_depth.fx + of_depth.cx).astype(int)
        found = depth[row.clip(0, rows - 1)[:, None], column.clip(0, columns - 1)]
        inside = ((row >= 0) & (row < rows))[:, None] & (column >= 0) & (column < columns)
        return np.asarray(np.where(inside, found, found.dtype.type(0)))

    return fit


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
