"""Published figures against the data they were published with."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...errors import InputError
from ...tables import KeyFault, LineFinder
from ...tables import Table as Keys
from .ratings import Ratings

_EXAMPLE = "hmdwarp/study/ready/thesis_claims.toml"
_LEAST = 1e-9


@attrs.frozen
class Claim:
    """One figure.

    part: whose. a, b: the conditions compared; latency_ms instead of them: the comparison at that latency. difference: the mean of a minus
    b, positive where b was rated better; None for a mere mention of the latency. step: what it was rounded to. where: in the text.
    """

    part: str
    step: float
    difference: float | None = None
    latency_ms: float | None = None
    a: str = ""
    b: str = ""
    where: str = ""


@attrs.frozen
class Claims:
    """title: of the text that made them, for sentences. why_step: how the step is known."""

    title: str
    claims: tuple[Claim, ...]
    why_step: str = ""


def load_claims(path: Path) -> Claims:
    """A .toml file of claims. Without `step` a figure counts as rounded to its last digit. Errors: InputError naming file, line, value."""
    try:
        text = path.read_text(encoding="utf-8")
        data = Keys(tomllib.loads(text), example=_EXAMPLE)
        exact = tomllib.loads(text, parse_float=Decimal)
    except OSError as error:
        raise InputError(f"{path}: {error.strerror}: wanted a .toml file of claims, like {_EXAMPLE}") from error
    except ValueError as error:
        raise InputError(f"{path}: {error}: wanted TOML, like {_EXAMPLE}") from error
    try:
        step = data.number("step") if "step" in data else None
        tables = data.tables("claim")
        claims = tuple(_claim(table, raw, step) for table, raw in zip(tables, exact.get("claim", []), strict=True))
        found = Claims(data.text("title"), claims, data.text("why_step") if "why_step" in data else "")
        data.refuse_unread()
    except KeyFault as error:
        raise InputError(f"{path}:{LineFinder(text).line(error.path)}: {error}") from error
    return found


def _claim(table: Keys, raw: Mapping[str, Any], step: float | None) -> Claim:
    difference = table.number("difference") if "difference" in table else None
    latency = table.number("latency_ms") if "latency_ms" in table else None
    a, b, where = (table.text(key) if key in table else "" for key in ("a", "b", "where"))
    if latency is None and not (a and b):
        raise table.fault("difference", "stands without what it is about: wanted latency_ms, or a and b")
    last = Decimal(1).scaleb(Decimal(str(raw.get("difference", 1))).as_tuple().exponent)  # type: ignore[arg-type]
    return Claim(table.text("part"), float(last) if step is None else step, difference, latency, a, b, where)


def checked(claims: Claims, rows: Sequence[Mapping[str, Any]], ratings: Ratings, scale: str) -> list[dict[str, Any]]:
    """Each claim with what the data give. rows: as comparisons.compared.

    A figure follows where the mean difference of the pairs is no further from it than one step: rounding or cutting off can explain that
    much. Otherwise the other figures that somebody may have meant are tried, and told: the difference of the two means over all ratings,
    paired or not; of the two medians; the median difference. A claim about a latency that nobody rated names those that were.
    """
    return [_checked(claim, rows, ratings, scale) for claim in claims.claims]


def _checked(claim: Claim, rows: Sequence[Mapping[str, Any]], ratings: Ratings, scale: str) -> dict[str, Any]:
    found: dict[str, Any] = {
        name: getattr(claim, name) for name in ("part", "latency_ms", "difference", "step", "where")
    }
    if claim.part not in ratings.parts():
        return found | {
            "follows": None,
            "why_not": f"there is no part '{claim.part}' among {', '.join(ratings.parts())}",
        }
    about = [row for row in rows if row["part"] == claim.part and _is_about(claim, row, ratings)]
    if not about:
        known = sorted(
            {
                s["latency_ms"]
                for c in ratings.conditions(claim.part)
                if "latency_ms" in (s := ratings.settings(claim.part, c))
            }
        )
        shown = ", ".join(f"{one:g}" for one in known)
        return found | {"follows": False, "why_not": f"nobody rated {claim.latency_ms:g} ms: the latencies are {shown} ms"
                        if claim.latency_ms is not None else f"'{claim.a}' and '{claim.b}' are not compared"}  # fmt: skip
    row = about[0]
    found |= {"a": row["a"], "b": row["b"], "data": row["mean"], "n": row["n"]}
    if claim.difference is None or row["mean"] is None:
        return found | {"follows": True if claim.difference is None else None}
    if _near(claim, row["mean"]):
        return found | {"follows": True}
    others = _others(row, ratings, scale)
    return found | {
        "follows": False,
        "others": others,
        "explained_by": [name for name, value in others.items() if _near(claim, value)],
    }


def _is_about(claim: Claim, row: Mapping[str, Any], ratings: Ratings) -> bool:
    if claim.a:
        return (row["a"], row["b"]) == (claim.a, claim.b)
    latencies = {ratings.settings(row["part"], row[end]).get("latency_ms") for end in ("a", "b")}
    return latencies == {claim.latency_ms}


def _near(claim: Claim, value: float) -> bool:
    return abs(value - claim.difference) <= claim.step + _LEAST


def _others(row: Mapping[str, Any], ratings: Ratings, scale: str) -> dict[str, float]:
    table, sign = ratings.table(row["part"], scale), ratings.measures[scale].sign
    a, b = (column[np.isfinite(column)] for column in (table.column(row["a"]), table.column(row["b"])))
    return {
        "difference of the means over all who rated either": float(sign * (a.mean() - b.mean())),
        "difference of the medians": float(sign * (np.median(a) - np.median(b))),
        "median difference": float(row["median"]),
    }
