"""Numbers of a run of any length in bounded bytes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

MOST = 1 << 15  # six minutes at 90 Hz are kept whole


class Thinned:
    """A table of numbers, one row for each refresh; once it is full every other row is left out, and from then on only every other one
    is taken: what is there is always spaced evenly over the whole run, at least `most` / 2 rows of it.

    every: of how many rows one is there. most: even.
    """

    def __init__(self, columns: Sequence[str], most: int = MOST) -> None:
        self._at = {name: index for index, name in enumerate(columns)}
        self._table = np.empty((most, len(columns)))
        self._seen = self._kept = 0
        self.every = 1

    def add(self, row: Sequence[float]) -> None:
        """The next row, in the order of the columns; NaN for what was not measured."""
        if self._seen % self.every == 0:
            if self._kept == len(self._table):
                self._kept //= 2
                self._table[: self._kept] = self._table[::2].copy()
                self.every *= 2
            self._table[self._kept] = row
            self._kept += 1
        self._seen += 1

    def column(self, name: str) -> NDArray[np.float64]:
        """All rows of one column, NaN included."""
        return self._table[: self._kept, self._at[name]].copy()

    def measured(self, *names: str) -> NDArray[np.float64]:
        """What was measured of these columns, one after the other."""
        values = np.concatenate([self.column(name) for name in names])
        return values[~np.isnan(values)]
