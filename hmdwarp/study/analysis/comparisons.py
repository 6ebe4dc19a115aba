"""Paired differences of two conditions, with everything that is said of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from ...errors import InputError
from ..design import Comparison, Family
from ..statistics import (
    MOST_PAIRS,
    RESAMPLES,
    SEED,
    attained_level,
    bca,
    hodges_lehmann,
    holm,
    is_degenerate,
    rank_biserial,
    smallest_p,
    wilcoxon_exact,
)
from .ratings import Measure, Ratings, Table

_LEAST_LEVEL = 0.5  # an exact interval that misses more often than that says nothing: that of one difference (0 %), not of two (50 %)


@attrs.frozen
class Resampling:
    """Of the BCa intervals."""

    seed: int = SEED
    resamples: int = RESAMPLES


def compared(
    ratings: Ratings,
    scale: str,
    families: Sequence[Family],
    resampling: Resampling,
    without: Mapping[str, set[str]] | None = None,
) -> list[dict[str, Any]]:
    """All comparisons on a scale as plain data, Holm's correction within each family ("holm") and over all of them ("holm_all").

    without: by part, participants to leave out.
    """
    rows: list[dict[str, Any]] = []
    for family in families:
        for comparison in family.comparisons:
            table = ratings.table(comparison.part, scale).without((without or {}).get(comparison.part, set()))
            if {comparison.a, comparison.b} <= set(table.conditions):
                rows.append(_compared(table, ratings.measures[scale], family.name, comparison, resampling))
    _correct(rows)
    return rows


def differences(table: Table, comparison: Comparison, sign: int) -> dict[str, float]:
    """Of each participant who rated both; positive where b was rated better."""
    first, second = table.column(comparison.a), table.column(comparison.b)
    both = np.isfinite(first) & np.isfinite(second)
    return {
        name: round(float(sign * (first[k] - second[k])), 9) for k, name in enumerate(table.participants) if both[k]
    }


def _compared(
    table: Table, measure: Measure, family: str, comparison: Comparison, resampling: Resampling
) -> dict[str, Any]:
    found = differences(table, comparison, measure.sign)
    values = np.array(list(found.values()))
    row: dict[str, Any] = {
        "part": comparison.part,
        "scale": measure.name,
        "family": family,
        "a": comparison.a,
        "b": comparison.b,
        "n": len(values),
        "better": int((values > 0).sum()),
        "equal": int((values == 0).sum()),
        "worse": int((values < 0).sum()),
        "differences": found,
        "left_out": [name for name in table.participants if name not in found],
    }
    return row | (_statistics(values, resampling) if len(values) else dict.fromkeys(_STATISTICS))


_STATISTICS = (
    "mean", "sd", "median", "w_plus", "w_minus", "p", "smallest_p", "rank_biserial", "shift", "shift_low", "shift_high", "shift_level",
    "low", "high",
)  # fmt: skip


def _statistics(values: np.ndarray, resampling: Resampling) -> dict[str, Any]:
    if len(values) > MOST_PAIRS:
        raise InputError(
            f"{len(values)} participants rated both of two conditions: the exact test is for {MOST_PAIRS} at most"
        )
    test = wilcoxon_exact(values)
    # One difference, or equal ones, have no spread to resample: a point is no interval.
    low, high = (None, None) if is_degenerate(values) else bca(values, resampling.seed, resampling.resamples)
    found = (
        float(values.mean()), float(values.std(ddof=1)) if len(values) > 1 else None, float(np.median(values)), test.w_plus, test.w_minus,
        test.p, smallest_p(test.n), rank_biserial(values), *shift_of(values), low, high,
    )  # fmt: skip
    return dict(zip(_STATISTICS, found, strict=True))


def shift_of(values: np.ndarray) -> tuple[float, float | None, float | None, float | None]:
    """Hodges-Lehmann shift, low, high, and how sure that interval is; None for the last three where it is hardly sure of anything."""
    shift, level = hodges_lehmann(values), attained_level(len(values))
    return (shift.shift, None, None, None) if level < _LEAST_LEVEL else (shift.shift, shift.low, shift.high, level)


def _correct(rows: list[dict[str, Any]]) -> None:
    """Holm's p in each row. A planned one that nobody rated counts in its family with p = 1, or the rest would look better."""
    groups = [[row for row in rows if row["family"] == name] for name in dict.fromkeys(row["family"] for row in rows)]
    for group, key in [*((group, "holm") for group in groups), (rows, "holm_all")]:
        for row, p in zip(group, holm([1.0 if row["p"] is None else row["p"] for row in group]), strict=True):
            row[key] = p
            row[f"{key}_of"] = len(group)
