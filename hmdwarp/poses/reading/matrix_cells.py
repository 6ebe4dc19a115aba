"""Matrices among the columns of a file: which numbers they are, by rows or by columns."""

from __future__ import annotations

import attrs
import numpy as np
from numpy.typing import NDArray

from ...errors import TraceError
from ..assumptions import By
from ..options import COLUMNS, ROWS
from .columns import SHAPES, Cells
from .file_head import Head

_OFF = 0.02
_LAST = np.array([0.0, 0.0, 0.0, 1.0])


@attrs.frozen
class Matrix:
    """Columns of a rotation row by row, and of a position."""

    turn: Cells
    position: tuple[int, int, int] | None
    words: str  # how the numbers are ordered
    by: By


def matrix_in(head: Head, candidates: list[Cells], order: str | None) -> Matrix | None:
    """Return the first of the candidates that holds rotations. order: of --matrix."""
    return next(filter(None, (_arranged(head, cells, order) for cells in candidates)), None)


def bare_matrices(head: Head) -> list[Cells]:
    """Return neighbouring columns that may be a matrix in a file without names, 4x4 before 3x4."""
    runs = [tuple(range(a, a + n)) for n in (16, 12, 9) for a in range(head.width - n + 1)]
    return [cells for cells in runs if _arranged(head, cells, None) is not None]


def read_matrix(head: Head, cells: Cells, order: str | None) -> Matrix:
    """Return how a stated matrix is read. Errors: TraceError for numbers that are no rotation."""
    found = _arranged(head, cells, order)
    if found is None:
        last = ", nor 0,0,0,1 in the last row or column" if len(cells) == 16 else ""
        raise TraceError(
            f"{head.path}: its {len(cells)} numbers of a matrix are no rotations by {order or 'rows or columns'}{last}"
            ": were the wrong columns read? --columns m=2-17 names them"
        )
    return found


def _arranged(head: Head, cells: Cells, order: str | None) -> Matrix | None:
    numbers = head.numbers(cells)
    numbers = numbers[np.abs(numbers).max(axis=1, initial=0.0) > 0]  # lost tracking writes zeros
    if not len(numbers):
        return None
    fits = [layout for layout in (ROWS, COLUMNS) if order in (None, layout) and _holds(numbers, layout)]
    if not fits:
        return None
    # A transposed rotation is a rotation: only the place of a translation or of 0,0,0,1 decides.
    decided = len(fits) == 1 and len(cells) > 9
    words = (
        {16: "0,0,0,1 is its last row", 12: "3x4"} if fits[0] == ROWS else {16: "0,0,0,1 is its last column", 12: "4x3"}
    )
    turn, place = _places(len(cells), fits[0])
    by = By.USER if order else By.FILE if decided else By.NOBODY
    shown = f"by {fits[0]}" + (f" ({words[len(cells)]})" if decided else "")
    at = None if place is None else (cells[place[0]], cells[place[1]], cells[place[2]])
    return Matrix(tuple(cells[i] for i in turn), at, shown, by)


def _places(count: int, order: str) -> tuple[Cells, tuple[int, int, int] | None]:
    """Return the places of the rotation's nine numbers row by row, and of the position's three."""
    rows, columns = SHAPES[count]
    grid = np.arange(count).reshape(rows, columns) if order == ROWS else np.arange(count).reshape(columns, rows).T
    place = grid[:3, 3].tolist() if columns == 4 else None
    return tuple(grid[:3, :3].ravel().tolist()), place


def _holds(numbers: NDArray[np.float64], order: str) -> bool:
    turn, place = _places(numbers.shape[1], order)
    if numbers.shape[1] == 16:
        last = np.arange(16).reshape(4, 4)
        last = last[3] if order == ROWS else last[:, 3]
        if np.median(np.abs(numbers[:, last] - _LAST).max(axis=1)) > _OFF:
            return False
    matrices = numbers[:, turn].reshape(-1, 3, 3)
    off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(axis=(1, 2))
    return bool(np.median(off) < _OFF and np.median(np.linalg.det(matrices)) > 0)
