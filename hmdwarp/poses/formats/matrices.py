"""Poses as matrices without a header: 9, 12 or 16 numbers somewhere in each row."""

from __future__ import annotations

import numpy as np

from ...errors import TraceError
from ..assumptions import By, Layout
from ..options import TraceOptions
from ..reading.columns import Cells
from ..reading.file_head import Head, is_number
from ..reading.matrix_cells import bare_matrices, read_matrix
from . import TraceFormat, formats, of_matrix

_CLOCKED = 0.9  # share of the steps in which a clock rises


@formats.register
class Matrices(TraceFormat):
    """Matrices of 3x4 or 4x4, by rows as KITTI's odometry, or by columns as WebXR, glm and ARKit.

    Where 0,0,0,1 or the rotation lies decides. A column beside them that rises is the time.
    Source: Geiger et al. 2012, Are we ready for autonomous driving? (the data set's poses).
    """

    name = "matrices"
    order = "where 0,0,0,1 or the rotation lies"
    summary = "3x4 or 4x4 matrices, 12 or 16 numbers by rows or columns, perhaps beside others; metres"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        alone = head.names is None and head.width >= 12 and sum(map(is_number, head.rows[0])) >= 12
        return 50 if alone and any(len(cells) > 9 for cells in bare_matrices(head)) else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        found = next((cells for cells in bare_matrices(head) if len(cells) > 9), _by_width(head))
        matrix = read_matrix(head, found, options.matrix)
        others = [c for c in range(head.width) if c not in found and _rises(head, c)]
        return Layout(
            time=max(others, key=lambda c: (c < found[0], *_fineness(head, c)), default=None),
            columns_by=By.NOBODY,
            **of_matrix(matrix, None),
        )


def _by_width(head: Head) -> Cells:
    """Return the last 16 or 12 columns, as a file of matrices alone has them."""
    count = 16 if head.width >= 16 else 12
    if head.width < count:
        raise TraceError(f"{head.path}: {head.width} columns, expected 12 or 16, or one more with a time first")
    return tuple(range(head.width - count, head.width))


def _fineness(head: Head, column: int) -> tuple[int, bool, float]:
    """Return how likely a rising column is the clock, and no number of the frame."""
    numbers = head.numbers((column,))[:, 0]
    step = float(np.median(np.diff(numbers))) if len(numbers) > 1 else 0.0
    return len(set(numbers.tolist())), bool((numbers % 1).any()), step


def _rises(head: Head, column: int) -> bool:
    numbers = head.numbers((column,))[:, 0]
    steps = numbers[1:] - numbers[:-1]
    return len(steps) == 0 or float((steps > 0).mean()) > _CLOCKED
