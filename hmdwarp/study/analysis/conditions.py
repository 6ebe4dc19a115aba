"""Each condition by itself, all of them at once, and whether the hidden reference was found."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..statistics import friedman, kendalls_w
from .ratings import Measure, Ratings, Table


def described(ratings: Ratings, part: str, scale: str) -> list[dict[str, Any]]:
    """A row for each condition: n, median, mean, spread, and every single rating by participant. Spread is None where n is too small."""
    table = ratings.table(part, scale)
    references = ratings.references(part)
    return [_described(table, name, ratings, part, name in references) for name in table.conditions]


def _described(table: Table, name: str, ratings: Ratings, part: str, is_reference: bool) -> dict[str, Any]:
    column = table.column(name)
    given = column[np.isfinite(column)]
    row: dict[str, Any] = {
        "condition": name,
        "settings": dict(ratings.settings(part, name)),
        "reference": is_reference,
        "n": len(given),
        "missing": int(len(column) - len(given)),
        "ratings": {
            who: round(float(v), 9) for who, v in zip(table.participants, column, strict=True) if np.isfinite(v)
        },
    }
    quartiles = np.quantile(given, (0.25, 0.5, 0.75)).tolist() if len(given) else [None] * 3
    row |= dict(zip(("q1", "median", "q3"), quartiles, strict=True))
    row["mean"] = float(given.mean()) if len(given) else None
    row["sd"] = float(given.std(ddof=1)) if len(given) > 1 else None
    row["least"], row["most"] = (float(given.min()), float(given.max())) if len(given) else (None, None)
    return row


def all_at_once(table: Table) -> dict[str, Any] | None:
    """Friedman's test over participants who rated everything, None where that is too few people or conditions."""
    found = friedman(table.values)
    if found is None:
        return None
    return {
        "chi2": found.chi2,
        "df": found.df,
        "p": found.p,
        "n": found.n,
        "conditions": len(table.conditions),
        "w": kendalls_w(found),
    }


def reference_missed(table: Table, references: tuple[str, ...], measure: Measure) -> dict[str, Any] | None:
    """Who rated the hidden reference worse than the middle one of their own other ratings; None where there is no reference."""
    if not references:
        return None
    inside = [table.conditions.index(name) for name in references]
    outside = [k for k in range(len(table.conditions)) if k not in inside]
    badness = measure.sign * table.values
    rated, missed = 0, []
    for who, row in zip(table.participants, badness, strict=True):
        own, others = row[inside][np.isfinite(row[inside])], row[outside][np.isfinite(row[outside])]
        if len(own) and len(others):
            rated += 1
            if own.mean() > np.median(others) + 1e-9:
                missed.append(who)
    return {"rated": rated, "missed": missed, "references": list(references)}
