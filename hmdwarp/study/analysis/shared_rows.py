"""Rows of ratings that two parts share and that look copied."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from .ratings import Ratings, Table

_LEAST_CONDITIONS = 2  # equal ratings of one condition say nothing
_DRAWS = 20_000
_MISSING = -np.inf  # equal to itself, and no rating


def copied_rows(ratings: Ratings, scale: str, seed: int) -> list[dict[str, Any]]:
    """Return, for every two parts with conditions in common, the rows that are equal there.

    Conditions are common by name or by settings; missing ratings count as equal.
    "by_chance": how often as many people of the second part would have an equal row in the first if
    every rating were drawn by itself from all ratings of its condition (seeded draws). "within":
    equal rows among the people of one part, of all pairs: how common they are without copying.
    """
    found = []
    for first, second in itertools.combinations(ratings.parts(), 2):
        shared = _shared(ratings, first, second)
        if len(shared) < _LEAST_CONDITIONS:
            continue
        tables = [
            _columns(ratings.table(part, scale), [pair[k] for pair in shared]) for k, part in enumerate((first, second))
        ]
        pairs = _equal(*tables)
        if not pairs:
            continue
        names = [ratings.table(part, scale).participants for part in (first, second)]
        people = len({b for _, b in pairs})
        found.append(
            {
                "parts": [first, second],
                "conditions": [a for a, _ in shared],
                "rows": [
                    {"first": names[0][a], "second": names[1][b], "ratings": _plain(tables[0][a])} for a, b in pairs
                ],
                "people": people,
                "of": len(names[1]),
                "by_chance": _by_chance(tables[0], tables[1], people, seed),
                "draws": _DRAWS,
                "within": sum(len(_within(table)) for table in tables),
                "within_of": sum(len(table) * (len(table) - 1) // 2 for table in tables),
            }
        )
    return found


def _shared(ratings: Ratings, first: str, second: str) -> list[tuple[str, str]]:
    """Return the conditions of both, as (name in the first, name in the second)."""
    pairs = []
    for a in ratings.conditions(first):
        own = ratings.settings(first, a)
        for b in ratings.conditions(second):
            other = ratings.settings(second, b)
            if (own == other) if own and other else a == b:
                pairs.append((a, b))
                break
    return pairs


def _columns(table: Table, names: list[str]) -> np.ndarray:
    """Return ratings (participants, conditions), missing ones as _MISSING, equal to each other."""
    values = np.stack([table.column(name) for name in names], axis=1)
    return np.where(np.isfinite(values), np.round(values, 6), _MISSING)


def _plain(row: np.ndarray) -> list[float | None]:
    return [None if value == _MISSING else float(value) for value in row]


def _equal(first: np.ndarray, second: np.ndarray) -> list[tuple[int, int]]:
    same = (first[:, None] == second[None]).all(axis=2) & (first != _MISSING).any(axis=1)[:, None]
    return [(int(a), int(b)) for a, b in np.argwhere(same)]


def _within(table: np.ndarray) -> list[tuple[int, int]]:
    return [(a, b) for a, b in _equal(table, table) if a < b]


def _by_chance(first: np.ndarray, second: np.ndarray, people: int, seed: int) -> float:
    """Return the share of draws with as many equal rows; the data count as one draw."""
    random = np.random.default_rng(seed)
    pool = np.concatenate([first, second])
    n, columns = len(pool), np.arange(pool.shape[1])
    hits = 1
    for start in range(0, _DRAWS, 2000):  # little memory at a time
        count = min(2000, _DRAWS - start)
        drawn = pool[random.integers(0, n, (count, n, pool.shape[1])), columns]
        a, b = drawn[:, : len(first)], drawn[:, len(first) :]
        same = (a[:, :, None] == b[:, None]).all(axis=3) & (a != _MISSING).any(axis=2)[:, :, None]
        hits += int((same.any(axis=1).sum(axis=1) >= people).sum())
    return hits / (_DRAWS + 1)
