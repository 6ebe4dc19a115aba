"""Matrices of poses in files: nested or flat, by rows or by columns, as their zeros say."""

from __future__ import annotations

import reprlib
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ...poses.assumptions import Assumption, By
from .recorded import POSE

Matrix = NDArray[np.float64]
LAST = (0.0, 0.0, 0.0, 1.0)
_NOTHING = 1e-12
_WITHIN = 1e-3


def square_of(where: str, value: Any) -> Matrix:
    """Return the numbers of one matrix as 4x4, as they are written.

    value: 4x4, 3x4 or, by columns, 4x3; or their numbers in one list, of which 12 are by rows
    unless a rotation stands only in their columns. Errors: InputError.
    """
    try:
        found = np.array(value, np.float64)
    except (TypeError, ValueError):
        found = np.empty(0)
    if found.shape == (12,):
        found = found.reshape(3, 4)
        if not turns(found[:, :3]) and turns(found.reshape(4, 3)[:3]):
            found = found.reshape(4, 3)
    found = found.reshape(4, 4) if found.shape == (16,) else found
    if found.shape not in ((4, 4), (3, 4), (4, 3)) or not np.isfinite(found).all():
        raise InputError(
            f"{where}: {reprlib.repr(value)}; expected a matrix of 4 rows of 4 finite numbers, nested or flat"
        )
    whole = np.diag(np.ones(4))
    whole[: found.shape[0], : found.shape[1]] = found
    return whole


def by_rows(where: str, matrices: Sequence[Matrix]) -> tuple[list[Matrix], Assumption]:
    """Return the matrices of one file by rows, and who says which way they are written.

    The last row or the last column of 0, 0, 0, 1 decides for all, wherever another place than the
    origin makes them differ. Errors: InputError where two of a file are written in both ways.
    """
    below, beside = (
        np.array([np.abs(np.subtract(line, LAST)).max() <= _NOTHING for line in lines], bool)
        for lines in ([matrix[3] for matrix in matrices], [matrix[:, 3] for matrix in matrices])
    )
    rows, columns = np.flatnonzero(below & ~beside), np.flatnonzero(beside & ~below)
    if len(rows) and len(columns):
        raise InputError(
            f"{where}: matrix {rows[0]} is written by rows and matrix {columns[0]} by columns; expected one way for all"
        )
    order = "by columns" if len(columns) else "by rows"
    by = By.FILE if len(rows) or len(columns) else By.FORMAT
    turned = [matrix.T for matrix in matrices] if len(columns) else list(matrices)
    return turned, Assumption(POSE, f"world from camera, matrices {order}", by)


def turns(matrix: Matrix) -> bool:
    """Return whether three rows are those of a rotation, within what a file rounds."""
    return bool(np.abs(matrix @ matrix.T - np.eye(3)).max() <= _WITHIN)


def shared_scale(matrices: Sequence[Matrix]) -> float:
    """Return the factor that all matrices have beside a rotation; 1 for none, or for several."""
    scales = np.cbrt([np.linalg.det(matrix[:3, :3]) for matrix in matrices])
    if not len(scales) or not np.isfinite(scales).all() or scales.min() <= 0:
        return 1.0
    scale = float(np.median(scales))
    is_shared = np.abs(scales / scale - 1).max() <= _WITHIN
    return scale if is_shared and abs(scale - 1) > _WITHIN / 2 else 1.0
