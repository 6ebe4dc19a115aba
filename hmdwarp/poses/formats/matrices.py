"""Poses as matrices: 12 or 16 numbers a row, row by row, perhaps after a time."""

from __future__ import annotations

import numpy as np

from ...errors import TraceError
from ..assumptions import By
from ..options import TraceOptions
from ..reading.file_head import Head
from ..stated import Layout
from ._base import TraceFormat, formats, numbers_alone

_WIDTHS = (12, 13, 16, 17)
_OFF = 0.01


class Matrices(TraceFormat):
    """World-from-head matrices of 3x4 or 4x4, as KITTI's odometry has them.

    Source: Geiger et al. 2012, Are we ready for autonomous driving? (the data set's poses).
    """

    name = "matrices"
    summary = "3x4 or 4x4 matrices, 12 or 16 numbers a row, perhaps after a time; world from head, metres"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        if not numbers_alone(head, head.separator, *_WIDTHS):
            return 0
        first = np.array([float(f.replace(",", ".")) for f in head.rows[0]])[list(_columns(head.width)[0])]
        turn = first.reshape(3, 3)
        return 50 if np.abs(turn @ turn.T - np.eye(3)).max() < _OFF else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        if head.width not in _WIDTHS:
            raise TraceError(f"{head.path}: {head.width} columns, expected 12 or 16, or one more with a time first")
        orientation, position = _columns(head.width)
        return Layout(
            time=0 if head.width % 2 else None,
            orientation=orientation,
            position=position,
            matrix=True,
            columns_by=By.NOBODY,
        )


def _columns(width: int) -> tuple[tuple[int, ...], tuple[int, int, int]]:
    """Return the columns of the nine numbers of the rotation, and of the position."""
    at = width % 2
    turn = tuple(at + 4 * row + column for row in range(3) for column in range(3))
    return turn, (at + 3, at + 7, at + 11)


formats.register(Matrices())
