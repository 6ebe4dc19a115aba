"""A prediction as sentences that claim no more than it shows, and as plain data for the page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from ...errors import InputError
from ...report import counted, listed
from .measure_results import Prediction, predict

Row = Mapping[str, Any]


def pooled(studies: Mapping[str, Sequence[Row]], scale: str = "") -> tuple[str, list[Row]]:
    """Return the scale, and the rows of all studies on it; people count from their own mean anyway.

    studies: rows as export.long_rows gives, by name. scale: by default the first that all have.
    Errors: InputError for a study without ratings on it, and where it has another good end.
    """
    scales = {name: tuple(dict.fromkeys(row["scale"] for row in rows)) for name, rows in studies.items()}
    common = [name for name in next(iter(scales.values()), ()) if all(name in found for found in scales.values())]
    chosen = scale or next(iter(common), "")
    lacking = [
        f"'{name}' ({listed(found) if found else 'nothing'})" for name, found in scales.items() if chosen not in found
    ]
    if lacking:
        wanted = f"on scale '{chosen}'" if chosen else "on one scale"
        raise InputError(f"expected ratings {wanted} in every study, and these have others: {listed(lacking)}")
    good = {name: bool(row["low_is_good"]) for name, rows in studies.items() for row in rows if row["scale"] == chosen}
    if len(set(good.values())) > 1:
        ways = listed([f"{'low' if low else 'high'} is good in '{name}'" for name, low in good.items()])
        raise InputError(f"the scale '{chosen}' is not the same in all studies: {ways}; predict each alone")
    return chosen, [_apart(name, row) for name, rows in studies.items() for row in rows if row["scale"] == chosen]


def _apart(study: str, row: Row) -> Row:
    """Name participant and part after the study, so that those of two are never one."""
    return {**row, **{key: f"{study}: {row.get(key) or ''}" for key in ("participant", "part")}}


_CHARTS = 4  # measures that get a chart


def prediction_data(rows: Sequence[Mapping[str, Any]], scale: str) -> dict[str, Any] | None:
    """Return the results of all measures, with sentences; None where nothing was measured.

    rows: of the long table, as export.long_rows gives.
    """
    found = predict(rows, scale) if any(row["scale"] == scale for row in rows) else None
    if found is None:
        return None
    return {
        "sentences": sentences(found),
        "measures": [
            {key: _plain(value) for key, value in attrs.asdict(measure).items()} for measure in found.measures
        ],
        "left_out": [list(pair) for pair in found.left_out],
        "choice": {
            "skill": found.choice_skill,
            "low": found.choice_low,
            "high": found.choice_high,
            "chosen": dict(found.chosen),
        },
        "resamples": found.resamples,
        "seed": found.seed,
        "points": {measure.name: _points(rows, scale, measure.name) for measure in found.measures[:_CHARTS]},
    }


def _points(rows: Sequence[Mapping[str, Any]], scale: str, name: str) -> list[dict[str, Any]]:
    return [
        {"participant": row["participant"], "x": row[name], "y": row["value"]}
        for row in rows
        if row["scale"] == scale and row.get("value") is not None and row.get(name) is not None
    ]


def _plain(value: Any) -> Any:
    """Replace NaN, which JSON lacks, by None."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return list(value) if isinstance(value, tuple) else value


def sentences(found: Prediction) -> list[str]:
    """Say in sentences which measure predicts best; the first one may say that it is unknown."""
    if found.refused:
        return [f"Skipped: which metric predicts the ratings ({found.refused}).", *_left_out(found)]
    return [_winner(found), _strength(found), *_choice(found), _conditions(found), *_alike(found), *_left_out(found)]


def _winner(found: Prediction) -> str:
    first, rest = found.measures[0], found.candidates[1:]
    how = (
        f"within-person r = {first.r:+.2f} (95 % {first.low:+.2f} .. {first.high:+.2f}, "
        f"more is rated {'worse' if first.r > 0 else 'better'})"
    )
    people = f"{counted(found.people, 'person')}, {counted(found.ratings, 'rating')}"
    if len(found.measures) == 1:
        return f"Only one metric can be tested: {first.title}, {how}; {people}."
    if not found.sure:
        return (
            f"No metric is shown to predict the ratings: even the best, {first.title}, has {how}, which the best of "
            f"{len(found.measures)} may reach by chance; {people}."
        )
    if not rest:
        best = f"{first.title[:1].upper()}{first.title[1:]} predicts the ratings best"
        return f"{best}: {how}, the best in {first.best:.0%} of the resamples; {people}."
    return (
        f"Which metric predicts best is undecided: {first.title} comes first with {how}, but "
        f"{listed([other.title for other in rest])} may be as good (p = {max(other.behind_p for other in rest):.2f} "
        f"and less, by flipping people's signs); {people}."
    )


def _strength(found: Prediction) -> str:
    first = found.measures[0]
    helps = (
        f"removes {first.skill:.0%} of the squared error (95 % {first.skill_low:.0%} .. {first.skill_high:.0%})"
        if first.skill > 0
        else "is no better"
    )
    return (
        f"Predicting a person's ratings from their own mean is off by {found.rmse_of_mean:.2f}; with {first.title} "
        f"and the slope of the others it is {first.rmse:.2f}, which {helps}."
    )


def _choice(found: Prediction) -> list[str]:
    """Say what a choice of the measure is worth to those who took no part in it."""
    if len(found.measures) == 1:
        return []
    interval = f"95 % {found.choice_low:.0%} .. {found.choice_high:.0%}"
    gain = (
        f"removes {found.choice_skill:.0%} of the squared error ({interval})"
        if found.choice_skill > 0
        else "is no better than their own mean"
    )
    (title, share), *_ = found.chosen
    return [
        "That first place was found on the same people. Chosen anew without each person and tested on them (nested "
        f"cross-validation), the best metric {gain}; {title} was chosen for {share:.0%} of the people."
    ]


def _conditions(found: Prediction) -> str:
    first = found.measures[0]
    many = f"These are {counted(found.conditions, 'condition')} and {counted(len(found.measures), 'metric')}"
    warning = "others may rank another metric first" if len(found.measures) > 1 else "others may give another result"
    if math.isnan(first.skill_condition):
        return f"{many}: {warning}."
    if first.skill_condition > 0:
        kept = f"{first.title} still predicts a condition left out, with {first.skill_condition:.0%} less squared error"
    else:
        kept = f"{first.title} predicts a condition left out no better"
    return f"{many}: {warning}; {kept} than the mean of the others."


def _alike(found: Prediction) -> list[str]:
    """Name measures that move together, each group once."""
    groups: list[set[str]] = []
    for measure in found.measures:
        group = {measure.title, *measure.alike}
        if len(group) > 1 and not any(group <= other for other in groups):
            groups = [other for other in groups if not other <= group] + [group]
    order = [measure.title for measure in found.measures]
    out = [
        f"In these conditions {listed(sorted(group, key=order.index))} move together (within-person correlation "
        "0.95 and more): ratings cannot separate them."
        for group in groups
    ]
    age = next((measure for measure in found.measures if measure.name == "actual_latency_ms_median"), None)
    if age is not None and found.measures[0] is not age and age in found.candidates:
        out.append("The age of the frame may predict as well: an apparent effect of the picture may be one of latency.")
    return out


def _left_out(found: Prediction) -> list[str]:
    out = []
    if found.dropped:
        out.append(f"Left out: {counted(found.dropped, 'rating')} without all metrics, or the only one of a person.")
    reasons: dict[str, list[str]] = {}
    for title, reason in found.left_out:
        reasons.setdefault(reason, []).append(title)
    return out + [f"Not tested: {listed(titles)} ({reason})." for reason, titles in reasons.items()]
