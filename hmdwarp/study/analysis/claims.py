"""Published figures against the data they were published with."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...options import Table as Keys
from ...options import parsed, text_of
from .ratings import Ratings

_EXAMPLE = "the example of docs/study-analysis.md"
_LEAST = 1e-9


@attrs.frozen
class Claim:
    """One published figure."""

    part: str
    step: float  # what it was rounded to
    difference: float | None = None  # mean, positive where `better` was rated better; None: a mere mention
    latency_ms: float | None = None  # means the comparison at that latency, instead of a pair
    baseline: str = ""
    better: str = ""
    where: str = ""  # in the text


@attrs.frozen
class Claims:
    """Figures of one publication."""

    title: str  # of the publication, for sentences
    claims: tuple[Claim, ...]
    why_step: str = ""  # how the step is known


def load_claims(path: Path) -> Claims:
    """Load a .toml file of claims. Without `step` a figure counts as rounded to its last digit.

    Errors: InputError naming file, line and value.
    """
    text = text_of(path, f"a .toml file of published figures: {_EXAMPLE} shows one")
    return parsed(text, path, lambda data: _claims(data, text), _EXAMPLE)


def _claims(data: Keys, text: str) -> Claims:
    step = data.number("step") if "step" in data else None
    exact = tomllib.loads(text, parse_float=Decimal).get("claim", [])
    claims = tuple(_claim(table, raw, step) for table, raw in zip(data.tables("claim"), exact, strict=True))
    return Claims(data.text("title"), claims, data.text("why_step") if "why_step" in data else "")


def _claim(table: Keys, raw: Mapping[str, Any], step: float | None) -> Claim:
    difference = table.number("difference") if "difference" in table else None
    latency = table.number("latency_ms") if "latency_ms" in table else None
    baseline, better, where = (table.text(key) if key in table else "" for key in ("baseline", "better", "where"))
    if latency is None and not (baseline and better):
        raise table.fault("difference", "lacks its comparison: expected latency_ms, or baseline and better")
    last = Decimal(1).scaleb(Decimal(str(raw.get("difference", 1))).as_tuple().exponent)  # type: ignore[arg-type]
    return Claim(
        table.text("part"), float(last) if step is None else step, difference, latency, baseline, better, where
    )


def checked(claims: Claims, rows: Sequence[Mapping[str, Any]], ratings: Ratings, scale: str) -> list[dict[str, Any]]:
    """Compare each claim with the data. rows: as comparisons.compared.

    A figure follows where the mean difference of the pairs is within one step of it, which rounding
    or truncation explains. Otherwise "others" holds what else may have been meant: the difference
    of the means over all ratings, paired or not; of the medians; the median difference. A claim
    about a latency without ratings names the latencies that were rated.
    """
    return [_checked(claim, rows, ratings, scale) for claim in claims.claims]


def _checked(claim: Claim, rows: Sequence[Mapping[str, Any]], ratings: Ratings, scale: str) -> dict[str, Any]:
    found: dict[str, Any] = {
        name: getattr(claim, name) for name in ("part", "latency_ms", "difference", "step", "where")
    }
    if claim.part not in ratings.parts():
        why = f"there is no part '{claim.part}' among {', '.join(ratings.parts())}"
        return found | {"follows": None, "why_not": why}
    row = next((row for row in rows if row["part"] == claim.part and _is_about(claim, row, ratings)), None)
    if row is None:
        return found | {"follows": False, "why_not": _no_comparison(claim, ratings)}
    found |= {"baseline": row["baseline"], "condition": row["condition"], "data": row["mean"], "n": row["n"]}
    if claim.difference is None:
        return found | {"follows": True}
    if row["mean"] is None:
        return found | {"follows": None, "why_not": f"nobody rated both '{row['baseline']}' and '{row['condition']}'"}

    def is_near(value: float) -> bool:
        return bool(abs(value - found["difference"]) <= claim.step + _LEAST)

    if is_near(row["mean"]):
        return found | {"follows": True}
    others = _others(row, ratings, scale)
    near = [name for name, value in others.items() if is_near(value)]
    return found | {"follows": False, "others": others, "explained_by": near}


def _no_comparison(claim: Claim, ratings: Ratings) -> str:
    if claim.latency_ms is None:
        return f"'{claim.baseline}' and '{claim.better}' are not compared"
    settings = [ratings.settings(claim.part, name) for name in ratings.conditions(claim.part)]
    known = sorted({setting["latency_ms"] for setting in settings if "latency_ms" in setting})
    latencies = ", ".join(f"{latency_ms:g}" for latency_ms in known)
    return f"nothing was rated at {claim.latency_ms:g} ms: the latencies are {latencies} ms"


def _is_about(claim: Claim, row: Mapping[str, Any], ratings: Ratings) -> bool:
    if claim.baseline:
        return (row["baseline"], row["condition"]) == (claim.baseline, claim.better)
    latencies = {ratings.settings(row["part"], row[end]).get("latency_ms") for end in ("baseline", "condition")}
    return latencies == {claim.latency_ms}


def _others(row: Mapping[str, Any], ratings: Ratings, scale: str) -> dict[str, float]:
    table, sign = ratings.table(row["part"], scale), ratings.scale_info[scale].sign
    columns = (table.column(row[end]) for end in ("baseline", "condition"))
    a, b = (column[np.isfinite(column)] for column in columns)
    return {
        "difference of the means over all who rated either": float(sign * (a.mean() - b.mean())),
        "difference of the medians": float(sign * (np.median(a) - np.median(b))),
        "median difference": float(row["median"]),
    }
