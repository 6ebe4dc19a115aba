"""What a lens hides, in requests: the seen rows of a few columns of a view."""

from __future__ import annotations

import functools

import attrs
import numpy as np

from ...geometry import Fov, Hidden, View

_COLUMNS, _ROWS = 64, 255
BYTES = 2 * _COLUMNS  # of one eye
_FINE = (_COLUMNS * 8, _ROWS * 4)  # pixels over which the seen rows are found


def packed_area(view: View) -> bytes:
    """Return the first seen row of each column, and the one after the last, in 255ths from below.

    They hold at least what is seen; 0 and 0 where nothing is.
    """
    if view.hidden is None:
        return bytes([0, _ROWS]) * _COLUMNS
    return _packed(view.hidden, view.fov)


@functools.lru_cache(maxsize=16)
def _packed(hidden: Hidden, fov: Fov) -> bytes:
    rows = hidden.rows(fov, _FINE).reshape(_COLUMNS, -1, 2)
    seen = rows[..., 0] < rows[..., 1]
    first = np.where(seen, rows[..., 0], _FINE[1]).min(axis=1) // 4
    end = -(-rows[..., 1].max(axis=1) // 4)
    return np.where(seen.any(axis=1), [first, end], 0).T.astype(np.uint8).tobytes()


def with_area(view: View, data: bytes | memoryview, at: int) -> View:
    """Return a view with the area that stands in a message. Errors: ValueError."""
    return attrs.evolve(view, hidden=_area(bytes(data[at : at + BYTES]), view.fov))


@functools.lru_cache(maxsize=64)
def _area(data: bytes, fov: Fov) -> Hidden | None:
    """Return what is hidden: one object for the same area, whose rows are found once."""
    rows = np.frombuffer(data, np.uint8).reshape(_COLUMNS, 2).astype(np.int64)
    if (rows[:, 0] > rows[:, 1]).any() or not rows.any():
        raise ValueError("a hidden area leaves nothing to see, or ends before it begins")
    if (rows == (0, _ROWS)).all():
        return None
    return Hidden.of_rows(rows / _ROWS, fov)
