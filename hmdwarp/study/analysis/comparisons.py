"""Paired comparisons of conditions: which ones, and everything the ratings say of each."""

from __future__ import annotations

import itertools
import tomllib
from collections.abc import Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import Any

import attrs
import numpy as np

from ...errors import InputError
from ...options import Table as Keys
from ...options import parsed, text_of
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
from .ratings import Ratings, ScaleInfo, Table

# An exact interval with a lower level is no use: one difference gives 0 %, two give 50 %.
_LEAST_LEVEL = 0.5
_MOST_PAIRED = 45  # comparisons of a part without a plan: ten conditions, each against each


@attrs.frozen
class Resampling:
    """Options of random draws: BCa intervals where not all resamples count, and copied rows."""

    seed: int = SEED
    resamples: int = RESAMPLES


def compared(
    ratings: Ratings,
    scale: str,
    families: Sequence[Family],
    resampling: Resampling,
    without: Mapping[str, set[str]] | None = None,
) -> list[dict[str, Any]]:
    """Return all comparisons on a scale as plain data.

    "holm" is p after Holm's correction within the family, "holm_all" over all comparisons.
    without: by part, participants to leave out.
    """
    rows: list[dict[str, Any]] = []
    for family in families:
        for comparison in family.comparisons:
            table = ratings.table(comparison.part, scale).without((without or {}).get(comparison.part, set()))
            if {comparison.baseline, comparison.better} <= set(table.conditions):
                rows.append(_compared(table, ratings.scale_info[scale], family.name, comparison, resampling))
    correct(rows, over_all=True)
    return rows


def differences(table: Table, comparison: Comparison, sign: int) -> dict[str, float]:
    """Return the difference of each participant who rated both; positive for `better`."""
    baseline, better = table.column(comparison.baseline), table.column(comparison.better)
    both = np.isfinite(baseline) & np.isfinite(better)
    return {
        name: round(float(sign * (baseline[k] - better[k])), 9) for k, name in enumerate(table.participants) if both[k]
    }


def _compared(
    table: Table, scale: ScaleInfo, family: str, comparison: Comparison, resampling: Resampling
) -> dict[str, Any]:
    found = differences(table, comparison, scale.sign)
    values = np.array(list(found.values()))
    row: dict[str, Any] = {
        "part": comparison.part,
        "scale": scale.name,
        "family": family,
        "condition": comparison.better,
        "baseline": comparison.baseline,
        "n": len(values),
        "better": int((values > 0).sum()),
        "equal": int((values == 0).sum()),
        "worse": int((values < 0).sum()),
        "differences": found,
        "left_out": [name for name in table.participants if name not in found],
    }
    return row | (_statistics(values, resampling) if len(values) else dict.fromkeys(_STATISTICS))


_STATISTICS = (
    "mean", "sd", "median", "w_plus", "w_minus", "p", "smallest_p", "rank_biserial",
    "shift", "shift_low", "shift_high", "shift_level", "low", "high",
)  # fmt: skip


def _statistics(values: np.ndarray, resampling: Resampling) -> dict[str, Any]:
    if len(values) > MOST_PAIRS:
        raise InputError(
            f"{len(values)} participants rated both of two conditions: the exact test takes {MOST_PAIRS} at most"
        )
    test = wilcoxon_exact(values)
    # One difference, or equal ones, have no spread to resample: a point is no interval.
    low, high = (None, None) if is_degenerate(values) else bca(values, resampling.seed, resampling.resamples)
    sd = float(values.std(ddof=1)) if len(values) > 1 else None
    found = (
        float(values.mean()), sd, float(np.median(values)), test.w_plus, test.w_minus, test.p, smallest_p(test.n),
        rank_biserial(values), *shift_of(values), low, high,
    )  # fmt: skip
    return dict(zip(_STATISTICS, found, strict=True))


def shift_of(values: np.ndarray) -> tuple[float, float | None, float | None, float | None]:
    """Return the Hodges-Lehmann shift, its low and high end, and the level of that interval.

    The last three are None where the level is too low for an interval.
    """
    shift, level = hodges_lehmann(values), attained_level(len(values))
    return (shift.shift, None, None, None) if level < _LEAST_LEVEL else (shift.shift, shift.low, shift.high, level)


def correct(rows: list[dict[str, Any]], *, over_all: bool = False) -> None:
    """Put Holm's p into each row, corrected within its family; over_all: over all rows as well.

    A planned comparison without ratings has none, and counts with p = 1: leaving it out would
    favour the rest.
    """
    groups = [[row for row in rows if row["family"] == name] for name in dict.fromkeys(row["family"] for row in rows)]
    for group, key in [*((group, "holm") for group in groups), *([(rows, "holm_all")] if over_all else [])]:
        for row, p in zip(group, holm([1.0 if row["p"] is None else row["p"] for row in group]), strict=True):
            row[key] = None if row["p"] is None else p
            row[f"{key}_of"] = len(group)


def families_for(ratings: Ratings, requested: Sequence[str] = ()) -> tuple[tuple[Family, ...], str]:
    """Return the families of comparisons, and a sentence on where they come from.

    requested: from the command line, "A:B;C:D" or "PART/A:B", each text a family. Without it the
    plan's families. Without a plan, in each part: at each latency no warp against each warp; else
    each condition against the hidden reference; else all pairs.

    Errors: InputError for names without ratings.
    """
    if requested:
        names = ["as requested"] if len(requested) == 1 else [f"as requested, {k + 1}" for k in range(len(requested))]
        asked = zip(requested, names, strict=True)
        found = tuple(family for text, name in asked for family in _requested(text, name, ratings))
        return found, "Compared: the pairs of --family."
    if ratings.families:
        return ratings.families, "Compared: what the study's file plans."
    families: list[Family] = []
    rules = []
    for part in ratings.parts():
        pairs, rule = _default_pairs(ratings, part)
        if pairs:
            name = f"{part}: {rule}" if part else rule
            families.append(Family(name, tuple(Comparison(part, a, b) for a, b in pairs)))
            rules.append(rule)
    which = "; ".join(dict.fromkeys(rules)) or "nothing, as there is only one condition"
    return tuple(families), f"Compared: {which}. The data come without a plan; --family chooses other pairs."


def _requested(text: str, name: str, ratings: Ratings) -> list[Family]:
    part, slash, rest = text.partition("/")
    in_part = bool(slash) and part in ratings.parts()
    parts = [part] if in_part else list(ratings.parts())
    pairs = [tuple(name.strip() for name in pair.split(":")) for pair in (rest if in_part else text).split(";")]
    if any(len(pair) != 2 or not all(pair) for pair in pairs):
        raise InputError(
            f"--family '{text}': expected pairs of conditions, like 'late-200:warped-200;late-400:warped-400'"
        )
    found = []
    for part in parts:
        known = ratings.conditions(part)
        here = [Comparison(part, a, b) for a, b in pairs if a in known and b in known]
        if here:
            found.append(Family(f"{part}: {name}" if part else name, tuple(here)))
    named = {(c.baseline, c.better) for family in found for c in family.comparisons}
    for pair in pairs:
        if pair not in named:
            names = "; ".join(dict.fromkeys(name for part in parts for name in ratings.conditions(part)))
            raise InputError(
                f"--family '{text}': no part has both '{pair[0]}' and '{pair[1]}': the conditions are {names}"
            )
    return found


def _default_pairs(ratings: Ratings, part: str) -> tuple[list[tuple[str, str]], str]:
    names = ratings.conditions(part)
    settings = {name: ratings.settings(part, name) for name in names}

    def rest(name: str) -> tuple[Any, ...]:
        return tuple(sorted((key, str(value)) for key, value in settings[name].items() if key not in ("warp", "fill")))

    bare = [name for name in names if settings[name].get("warp") == "none" and "latency_ms" in settings[name]]
    pairs = [(a, b) for a in bare for b in names if settings[b].get("warp", "none") != "none" and rest(a) == rest(b)]
    if pairs:
        return pairs, "at each latency no warp against each warp"
    references = ratings.references(part)
    if references:
        return [
            (name, references[0]) for name in names if name not in references
        ], "each condition against the hidden reference"
    pairs = list(itertools.combinations(names, 2))
    if len(pairs) > _MOST_PAIRED:
        raise InputError(
            f"{len(names)} conditions and no plan: choose with --family which of the {len(pairs)} pairs to compare"
        )
    return pairs, "each condition against each"


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
