"""What a prediction comes to, in sentences that claim no more than it shows."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from ..report import counted, listed

if TYPE_CHECKING:
    from .prediction import Measure, Prediction


def sentences(found: Prediction) -> list[str]:
    """The first says which measure predicts best, or that it cannot be told."""
    if found.refused:
        return [f"Which measure predicts the ratings best was not asked: {found.refused}.", *_left_out(found)]
    told = [_winner(found), _strength(found), _conditions(found)]
    told += _alike(found)
    return [text for text in (*told, *_left_out(found)) if text]


def _winner(found: Prediction) -> str:
    first, rest = found.measures[0], found.candidates[1:]
    how = (
        f"within-person r = {first.r:+.2f} (95 % {first.low:+.2f} .. {first.high:+.2f}, more is rated {_worse(first)})"
    )
    people = f"{counted(found.people, 'person')}, {counted(found.ratings, 'rating')}"
    if len(found.measures) == 1:
        return f"Only one measure can be looked at: {first.title}, {how}; {people}."
    if not found.sure:
        return (
            f"No measure is known to predict the ratings: even the best, {first.title}, has {how}, which the best of "
            f"{len(found.measures)} may have by chance; {people}."
        )
    if not rest:
        return f"{_big(first.title)} predicts the ratings best: {how}, the best in {first.best:.0%} of the resamples; {people}."
    return (
        f"Which measure predicts best cannot be told: {first.title} comes first with {how}, but {listed([one.title for one in rest])} "
        f"may be as good (p = {max(one.behind_p for one in rest):.2f} and less, by flipping people's signs); {people}."
    )


def _worse(measure: Measure) -> str:
    return "worse" if measure.r > 0 else "better"


def _strength(found: Prediction) -> str:
    first = found.measures[0]
    helps = (
        f"takes {first.skill:.0%} off its squared error (95 % {first.skill_low:.0%} .. {first.skill_high:.0%})"
        if first.skill > 0
        else "is no better"
    )
    return (
        f"Predicting somebody's ratings from their own mean is off by {found.rmse_of_mean:.2f}; with {first.title} and the slope of the "
        f"others it is {first.rmse:.2f}, which {helps}."
    )


def _conditions(found: Prediction) -> str:
    first = found.measures[0]
    many = f"These are {counted(found.conditions, 'condition')} and {counted(len(found.measures), 'measure')}"
    warning = "others may put another measure first" if len(found.measures) > 1 else "others may tell otherwise"
    if math.isnan(first.skill_condition):
        return f"{many}: {warning}."
    if first.skill_condition > 0:
        kept = f"a condition left out is still predicted by {first.title}, with {first.skill_condition:.0%} less squared error"
    else:
        kept = f"a condition left out is not predicted by {first.title} any better"
    kept += " than by the mean of the others"
    return f"{many}: {warning}; {kept}."


def _alike(found: Prediction) -> list[str]:
    """Measures that move together, each group once."""
    groups: list[set[str]] = []
    for one in found.measures:
        group = {one.title, *one.alike}
        if len(group) > 1 and not any(group <= other for other in groups):
            groups = [other for other in groups if not other <= group] + [group]
    order = [one.title for one in found.measures]
    told = []
    for group in groups:
        names = listed(sorted(group, key=order.index))
        told.append(
            f"In these conditions {names} move together (within-person correlation 0.95 and more): ratings cannot tell them apart."
        )
    age = next((one for one in found.measures if one.name == "actual_latency_ms_median"), None)
    if age is not None and found.measures[0] is not age and age in found.candidates:
        told.append(
            "The age of the frame may predict as well: what looks like an effect of the picture may be one of latency alone."
        )
    return told


def _left_out(found: Prediction) -> list[str]:
    told = []
    if found.dropped:
        told.append(f"Left out: {counted(found.dropped, 'rating')} without all measures, or the only one of a person.")
    reasons: dict[str, list[str]] = {}
    for title, reason in found.left_out:
        reasons.setdefault(reason, []).append(title)
    told += [f"Not looked at: {listed(titles)} ({reason})." for reason, titles in reasons.items()]
    return told


def _big(text: str) -> str:
    return text[:1].upper() + text[1:]
