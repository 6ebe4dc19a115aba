"""Rows of many cases that stay on the disk: a long run holds the rows of one case at a time."""

from __future__ import annotations

import bisect
import itertools
from collections.abc import Callable, Iterator, Sequence
from typing import Any, overload

from .kept_cases import KeptCases

Row = dict[str, Any]
# The rows in the result of a case; a case may have none.
RowsOf = Callable[[Any], Sequence[Row]]


class KeptRows(Sequence[Row]):
    """The rows of cases that are done, case by case; each is read when it is asked for."""

    def __init__(self, kept: KeptCases, identities: Sequence[str], rows_of: RowsOf) -> None:
        self._kept, self._rows_of = kept, rows_of
        counts = {identity: len(self._read(identity)) for identity in identities}
        self._identities = [identity for identity, count in counts.items() if count]
        # The number of the first row after each of these cases.
        self._ends = list(itertools.accumulate(counts[identity] for identity in self._identities))

    def __len__(self) -> int:
        return self._ends[-1] if self._ends else 0

    def __iter__(self) -> Iterator[Row]:
        for identity in self._identities:
            yield from self._read(identity)

    @overload
    def __getitem__(self, at: int) -> Row: ...
    @overload
    def __getitem__(self, at: slice) -> list[Row]: ...
    def __getitem__(self, at: int | slice) -> Row | list[Row]:
        if isinstance(at, slice):
            return [self[number] for number in range(*at.indices(len(self)))]
        number = range(len(self))[at]
        case = bisect.bisect_right(self._ends, number)
        return self._read(self._identities[case])[number - self._ends[case]]

    def _read(self, identity: str) -> Sequence[Row]:
        return self._rows_of(self._kept.result(identity))
