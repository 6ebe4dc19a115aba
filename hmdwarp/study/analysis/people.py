"""Who took part and how far they came, how they felt, and which ratings are missing."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

from ...errors import InputError
from ..scales import QUESTIONNAIRE, Scale, load_scale, scored
from ..statistics import wilcoxon_exact
from .comparisons import shift_of
from .ratings import Felt, Ratings


def missing(ratings: Ratings, scale: str) -> list[dict[str, Any]]:
    """Every rating that is not there, with the reason."""
    return [
        {
            "participant": row.participant,
            "part": row.part,
            "condition": row.condition,
            "session": row.session,
            "why": row.why_missing,
        }
        for row in ratings.rows
        if row.scale == scale and row.value is None
    ]


def sittings(ratings: Ratings) -> dict[str, Any]:
    """How sessions ended: counts, and those that did not come to their end."""
    counts = Counter(one.status for one in ratings.sittings)
    cut = [
        {"participant": one.participant, "part": one.part, "session": one.number, "status": one.status, "why": one.why}
        | {"rated": one.shown, "of": one.planned}
        for one in ratings.sittings
        if one.status != "complete"
    ]
    return {"counts": dict(sorted(counts.items())), "cut": cut}


def sickness(ratings: Ratings, known: Callable[[str], Scale | None]) -> list[dict[str, Any]]:
    """For each sickness scale: how many were asked after each trial, their median and the worst answer."""
    out = []
    for name in dict.fromkeys(one.scale for one in ratings.felt):
        scale = known(name)
        if scale is None or scale.kind == QUESTIONNAIRE:
            continue
        answers = [one for one in ratings.felt if one.scale == name and one.value is not None]
        trials = []
        for trial in sorted({one.trial for one in answers}):
            values = [one.value for one in answers if one.trial == trial]
            worst = max(values) if scale.low_is_good else min(values)
            trials.append({"trial": trial, "n": len(values), "median": float(np.median(values)), "worst": float(worst)})
        out.append({"scale": name, "title": scale.title, "least": scale.least, "most": scale.most, "trials": trials})
    return out


def questionnaires(ratings: Ratings, known: Callable[[str], Scale | None]) -> list[dict[str, Any]]:
    """For each questionnaire asked before and after, and each of its scores: medians, and the change of those who answered both times.

    p is of the exact Wilcoxon test of the change, corrected for nothing: nobody planned these comparisons.
    """
    out = []
    for name in dict.fromkeys(one.scale for one in ratings.felt):
        scale = known(name)
        if scale is None or scale.kind != QUESTIONNAIRE:
            continue
        before, after = (_scores(ratings.felt, scale, phase) for phase in ("before", "after"))
        for score in dict.fromkeys(key for sheet in [*before.values(), *after.values()] for key in sheet):
            pairs = {who: (before[who][score], after[who][score]) for who in before if who in after}
            changes = np.array([b - a for a, b in pairs.values() if a is not None and b is not None])
            row: dict[str, Any] = {"scale": name, "title": scale.title, "score": score, "n": len(changes)}
            row |= {"before": _median(before, score), "after": _median(after, score)}
            if len(changes):
                row |= dict(zip(("change", "low", "high", "level"), shift_of(changes), strict=True)) | {
                    "p": wilcoxon_exact(changes).p
                }
            out.append(row)
    return out


def _scores(felt: tuple[Felt, ...], scale: Scale, phase: str) -> dict[tuple[str, int], dict[str, float | None]]:
    """By participant and session."""
    sheets: dict[tuple[str, int], dict[str, float | None]] = {}
    for one in felt:
        if one.scale == scale.name and one.phase == phase:
            sheets.setdefault((one.participant, one.session), {})[one.item] = one.value
    return {who: scored(scale, answers) for who, answers in sheets.items()}


def _median(sheets: dict[tuple[str, int], dict[str, float | None]], score: str) -> float | None:
    values = [sheet[score] for sheet in sheets.values() if sheet.get(score) is not None]
    return float(np.median(values)) if values else None


def scale_or_none(name: str) -> Scale | None:
    """A shipped scale, None for a name that is none."""
    try:
        return load_scale(name)
    except InputError:
        return None
