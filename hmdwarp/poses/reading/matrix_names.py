"""Matrices among the names of a file's columns."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Iterator

from .columns import head_rank, words

Cells = tuple[int, ...]  # columns of 9, 12 or 16 numbers in the order of the file
SHAPES = {16: (4, 4), 12: (3, 4), 9: (3, 3)}
_CELL = re.compile(r"(.*?)[._\[\s]*([0-4])[\]._,\s]*\[?([0-4])\]?$")
_PLACE = re.compile(r"(.*?)[._\[\s]*(\d{1,2})\]?$")


def named_matrices(names: list[str]) -> list[Cells]:
    """Return the columns of every matrix that names number: m00 .. m33, r11 .. r33, T.0 .. T.15."""
    found = [*_by_row_and_column(names), *_by_place(names)]
    return [cells for _, cells in sorted(found, key=lambda one: (_is_other(one[0]), head_rank(one[0]), -len(one[1])))]


def _is_other(name: str) -> bool:
    """Return whether a matrix is a projection, or the inverse of one that may be there as well."""
    return bool(set(words(name)) & {"projection", "proj", "view", "inverse", "inv"})


def _by_row_and_column(names: list[str]) -> Iterator[tuple[str, Cells]]:
    cells: dict[str, dict[tuple[int, int], int]] = defaultdict(dict)
    for i, name in enumerate(names):
        if found := _CELL.match(name):
            cells[found[1]].setdefault((int(found[2]), int(found[3])), i)
    for name, group in cells.items():
        for rows, columns in SHAPES.values():
            whole = next((first for first in (0, 1) if _grid(first, rows, columns) <= set(group)), None)
            if whole is not None:
                yield name, tuple(group[cell] for cell in sorted(_grid(whole, rows, columns)))
                break


def _grid(first: int, rows: int, columns: int) -> set[tuple[int, int]]:
    return {(first + r, first + c) for r in range(rows) for c in range(columns)}


def _by_place(names: list[str]) -> Iterator[tuple[str, Cells]]:
    places: dict[str, dict[int, int]] = defaultdict(dict)
    for i, name in enumerate(names):
        if found := _PLACE.match(name):
            places[found[1]].setdefault(int(found[2]), i)
    for name, group in places.items():
        first = min(group)
        if len(group) in SHAPES and first <= 1 and set(group) == set(range(first, first + len(group))):
            yield name, tuple(group[place] for place in sorted(group))
