"""Paired comparisons: scores of the conditions, and what they say of the planned comparisons."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from scipy.special import ndtr

from ...report import ALPHA, counted, p_is, signed
from ..design import Comparison, Family, tables_of
from ..scales import FIRST, NEITHER
from ..statistics import (
    JOD_SPREAD,
    Scores,
    jod_scores,
    left_out_scores,
    resampled_interval,
    resampled_scores,
    wilcoxon_exact,
)
from .comparisons import Resampling, correct
from .ratings import Preference, Ratings

RESAMPLES = 2000  # the ends of an interval are then known to a tenth of its width
LEAST_PEOPLE = 6  # fewer have no interval: their resamples are too alike for 95 %


def preference_results(ratings: Ratings, families: Sequence[Family], resampling: Resampling) -> list[dict[str, Any]]:
    """Return the results of each part with paired comparisons, as plain data.

    Scores are in JOD: the hidden reference has 0, or without one the mean of all conditions. A
    comparison's "p" is of the exact Wilcoxon test of each person's choices for less those against
    it, where the two were shown together.
    """
    asked = dict.fromkeys((preference.part, preference.scale) for preference in ratings.preferences)
    return [_of_part(ratings, part, scale, families, resampling) for part, scale in asked]


@attrs.frozen(eq=False)
class _Counts:
    """Answers of one part by person."""

    names: tuple[str, ...]
    wins: np.ndarray  # (people, n, n)
    ties: np.ndarray | None  # (people, n, n); None where there could be none

    @classmethod
    def of(cls, answers: Sequence[Preference], names: tuple[str, ...], allows_ties: bool) -> _Counts:
        by_person: dict[str, list[Preference]] = {}
        for preference in answers:
            by_person.setdefault(preference.participant, []).append(preference)
        tables = [
            tables_of(names, [((p.first, p.second), p.answer) for p in of if p.answer is not None], allows_ties=True)
            for of in by_person.values()
        ]
        wins, ties = (np.array([table[k] for table in tables]) for k in (0, 1))
        return cls(names, wins, ties if allows_ties or ties.any() else None)

    def estimated(self, resampling: Resampling) -> _Estimates:
        scores = jod_scores(self.wins.sum(axis=0), None if self.ties is None else self.ties.sum(axis=0))
        if len(self.wins) < LEAST_PEOPLE:
            return _Estimates(scores, None, None)
        count = min(RESAMPLES, resampling.resamples)
        drawn = resampled_scores(self.wins, self.ties, count, resampling.seed).jod
        return _Estimates(scores, drawn, left_out_scores(self.wins, self.ties).jod)


@attrs.frozen(eq=False)
class _Estimates:
    """Scores of n conditions, and how they vary with the people."""

    scores: Scores
    resampled: np.ndarray | None  # (resamples, n), None for too few people
    left_out: np.ndarray | None  # (people, n)

    def of(self, weights: np.ndarray) -> dict[str, float | None]:
        """Return a weighted sum of scores, "jod", with its interval, "low" to "high"."""
        found: dict[str, float | None] = {"jod": float(self.scores.jod @ weights), "low": None, "high": None}
        if self.resampled is not None and self.left_out is not None and weights.any():
            ends = resampled_interval(found["jod"] or 0.0, self.resampled @ weights, self.left_out @ weights)
            found |= dict(zip(("low", "high"), ends, strict=True))
        return found


def _of_part(
    ratings: Ratings, part: str, scale: str, families: Sequence[Family], resampling: Resampling
) -> dict[str, Any]:
    planned = [preference for preference in ratings.preferences if (preference.part, preference.scale) == (part, scale)]
    given = [preference for preference in planned if preference.answer is not None]
    found: dict[str, Any] = {
        "part": part,
        "scale": scale,
        "people": len({preference.participant for preference in given}),
        "answers": len(given),
        "ties": sum(preference.answer == NEITHER for preference in given),
        "first": sum(preference.answer == FIRST for preference in given),
        "missing": len(planned) - len(given),
        "threshold": None,
        "conditions": [],
        "comparisons": [],
    }
    if not given:
        return found | {"sentences": ["No pair was compared."]}
    counts = _Counts.of(given, ratings.conditions(part), bool(planned[0].allows_ties))
    estimates = counts.estimated(resampling)
    zero = counts.names.index(planned[0].reference) if planned[0].reference in counts.names else None
    found["threshold"] = float(estimates.scores.threshold) if counts.ties is not None else None
    found["conditions"] = [_condition(counts, k, zero, estimates) for k in range(len(counts.names))]
    found["comparisons"] = [
        _comparison(counts, family.name, comparison, estimates)
        for family in families
        for comparison in family.comparisons
        if comparison.part == part and {comparison.baseline, comparison.better} <= set(counts.names)
    ]
    correct(found["comparisons"])
    for row in found["comparisons"]:
        row["sentence"] = _of_comparison(row)
    return found | {"sentences": [*(row["sentence"] for row in found["comparisons"]), _of_places(found)]}


def _condition(counts: _Counts, k: int, zero: int | None, estimates: _Estimates) -> dict[str, Any]:
    places = np.eye(len(counts.names))
    wins = counts.wins.sum(axis=0)
    return {
        "condition": counts.names[k],
        "reference": k == zero,
        **estimates.of(places[k] - (0 if zero is None else places[zero])),
        "preferred": int(wins[k].sum()),
        "other_preferred": int(wins[:, k].sum()),
        "neither": 0 if counts.ties is None else int(counts.ties.sum(axis=0)[k].sum()),
    }


def _comparison(counts: _Counts, family: str, comparison: Comparison, estimates: _Estimates) -> dict[str, Any]:
    a, b = (counts.names.index(name) for name in (comparison.better, comparison.baseline))
    places = np.eye(len(counts.names))
    found = estimates.of(places[a] - places[b])
    ties = 0 if counts.ties is None else int(counts.ties[:, a, b].sum())
    together = counts.wins[:, a, b] + counts.wins[:, b, a] + (0 if counts.ties is None else counts.ties[:, a, b])
    net = (counts.wins[:, a, b] - counts.wins[:, b, a])[together > 0]
    return {
        "part": comparison.part,
        "family": family,
        "condition": comparison.better,
        "baseline": comparison.baseline,
        "people": int((together > 0).sum()),
        "for": int(counts.wins[:, a, b].sum()),
        "against": int(counts.wins[:, b, a].sum()),
        "neither": ties,
        **found,
        **{f"share{end}": _share(found[of]) for end, of in (("", "jod"), ("_low", "low"), ("_high", "high"))},
        "p": wilcoxon_exact(net).p if len(net) else None,
    }


def _share(jod: float | None) -> float | None:
    """Return the share of forced choices for a condition that is better by so much."""
    return None if jod is None else float(ndtr(jod / JOD_SPREAD))


def _of_comparison(row: Mapping[str, Any]) -> str:
    where = f"{row['part']}: " if row["part"] else ""
    given = row["for"] + row["against"] + row["neither"]
    votes = f"{where}'{row['condition']}' was preferred to '{row['baseline']}' in {row['for']} of {given} answers"
    votes += f", neither in {row['neither']}" if row["neither"] else ""
    if not given:
        votes = f"{where}'{row['condition']}' and '{row['baseline']}' were not shown together"
    size = f"{signed(row['jod'])} JOD"
    if row["low"] is None:
        return f"{votes}; {size}, from fewer than {LEAST_PEOPLE} people, who give no interval.{_tested(row)}"
    size += f" (95 % {signed(row['low'])} to {signed(row['high'])})"
    share = f"{row['share']:.0%} of choices would go to it ({row['share_low']:.0%} to {row['share_high']:.0%})"
    shown = "" if row["low"] > 0 or row["high"] < 0 else ": no difference is shown"
    return f"{votes}; {size}: {share}{shown}.{_tested(row)}"


def _tested(row: Mapping[str, Any]) -> str:
    if row["p"] is None:
        return ""
    of = f" after Holm over {row['holm_of']}" if row["holm_of"] > 1 else ""
    people = f"{counted(row['people'], 'person')} who saw both: exact {p_is(row['holm'])}{of}"
    return f" {people}{'' if row['holm'] <= ALPHA else ', not significant at 5 %'}."


def _of_places(found: Mapping[str, Any]) -> str:
    chosen = found["answers"] - found["ties"]
    return f"The first of a pair was chosen {found['first']} times in {counted(chosen, 'choice')}."
