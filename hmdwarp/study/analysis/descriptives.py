"""Descriptive tables: conditions, sessions, sickness, questionnaires, missing ratings, order."""

from __future__ import annotations

import math
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import stdtrit

from ...errors import InputError
from ...report import counted
from ...resources import import_extra
from ..scales import QUESTIONNAIRE, Scale, load_scale, score_ranges, scored
from ..statistics import friedman, kendalls_w, wilcoxon_exact
from .comparisons import shift_of
from .ratings import Rating, Ratings, ScaleInfo, SurveyAnswer, Table

_LEVEL = 0.95
_EQUAL = 1e-9  # means of equal ratings may differ by rounding
Sheets = dict[tuple[str, int], dict[str, float | None]]  # scores by participant and session


def condition_rows(ratings: Ratings, part: str, scale: str) -> list[dict[str, Any]]:
    """Return a row per condition: n, median, mean, spread, and each participant's rating.

    "low" to "high" is Student's 95 % interval of the mean over people, cut at the ends of the
    scale; None where n is too small, as the spread, or all rated alike.
    Source of the interval: ITU-T P.910 (10/2023), as for any mean opinion score.
    """
    table, info = ratings.table(part, scale), ratings.scale_info[scale]
    references = ratings.references(part)
    rows = [_condition_row(table, name, ratings, part, name in references) for name in table.conditions]
    return [row | _mean_interval(row, info) for row in rows]


def _mean_interval(row: Mapping[str, Any], scale: ScaleInfo) -> dict[str, float | None]:
    if not row["sd"]:
        return {"low": None, "high": None}
    half = float(stdtrit(row["n"] - 1, 0.5 + _LEVEL / 2)) * row["sd"] / math.sqrt(row["n"])
    least = -math.inf if scale.least is None else scale.least
    most = math.inf if scale.most is None else scale.most
    return {"low": max(row["mean"] - half, least), "high": min(row["mean"] + half, most)}


def _condition_row(table: Table, name: str, ratings: Ratings, part: str, is_reference: bool) -> dict[str, Any]:
    column = table.column(name)
    rated = column[np.isfinite(column)]
    row: dict[str, Any] = {
        "condition": name,
        "settings": dict(ratings.settings(part, name)),
        "reference": is_reference,
        "n": len(rated),
        "missing": int(len(column) - len(rated)),
        "ratings": {
            who: round(float(v), 9) for who, v in zip(table.participants, column, strict=True) if np.isfinite(v)
        },
    }
    quartiles = np.quantile(rated, (0.25, 0.5, 0.75)).tolist() if len(rated) else [None] * 3
    row |= dict(zip(("q1", "median", "q3"), quartiles, strict=True))
    row["mean"] = float(rated.mean()) if len(rated) else None
    row["sd"] = float(rated.std(ddof=1)) if len(rated) > 1 else None
    row["least"], row["most"] = (float(rated.min()), float(rated.max())) if len(rated) else (None, None)
    return row


def friedman_row(table: Table) -> dict[str, Any] | None:
    """Return Friedman's test over participants who rated everything.

    None where there are too few people or conditions.
    """
    found = friedman(table.values)
    if found is None:
        return None
    return found._asdict() | {"conditions": len(table.conditions), "w": kendalls_w(found)}


def reference_votes(table: Table, references: tuple[str, ...], scale: ScaleInfo) -> dict[str, Any] | None:
    """Return how each participant rated the hidden reference against the median of their others.

    "better" and "same" are counts, "missed" the participants who rated it worse; "flat" counts
    those of "same" who gave everything the same rating. None without a reference.
    """
    if not references:
        return None
    inside = [table.conditions.index(name) for name in references]
    outside = [k for k in range(len(table.conditions)) if k not in inside]
    better, same, flat = 0, 0, 0
    missed = []
    for who, row in zip(table.participants, scale.sign * table.values, strict=True):
        own, others = row[inside][np.isfinite(row[inside])], row[outside][np.isfinite(row[outside])]
        if not len(own) or not len(others):
            continue
        worse_by = own.mean() - np.median(others)
        if worse_by > _EQUAL:
            missed.append(who)
        elif worse_by < -_EQUAL:
            better += 1
        else:
            same += 1
            flat += bool(np.ptp([*own, *others]) <= _EQUAL)
    rated = better + same + len(missed)
    return {
        "rated": rated, "better": better, "same": same, "flat": flat, "missed": missed, "references": list(references)
    }  # fmt: skip


def place_residuals(ratings: Ratings, part: str, scale: str) -> list[dict[str, Any]]:
    """Return each rating less its participant's and its condition's mean, by place of its trial.

    Empty where places are not known.
    """
    rated = [(row, row.value) for row in ratings.of(part, scale) if row.value is not None and row.place]
    if not rated:
        return []
    overall = sum(value for _, value in rated) / len(rated)

    def means(name: str) -> dict[str, float]:
        groups: dict[str, list[float]] = {}
        for row, value in rated:
            groups.setdefault(getattr(row, name), []).append(value)
        return {key: sum(values) / len(values) for key, values in groups.items()}

    people, conditions = means("participant"), means("condition")
    return [
        {"place": row.place, "rest": value - people[row.participant] - conditions[row.condition] + overall}
        for row, value in rated
    ]


def missing_rows(ratings: Ratings, scale: str) -> list[dict[str, Any]]:
    """Return every missing rating with its reason."""
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


def session_counts(ratings: Ratings) -> dict[str, Any]:
    """Return how sessions ended: counts, and the sessions that are not complete."""
    counts = Counter(session.status for session in ratings.sessions)
    cut = [
        {
            "participant": session.participant,
            "part": session.part,
            "session": session.number,
            "status": session.status,
            "why": session.why,
        }
        | {"rated": session.rated, "of": session.planned}
        for session in ratings.sessions
        if session.status != "complete"
    ]
    return {"counts": dict(sorted(counts.items())), "cut": cut}


def sickness_rows(ratings: Ratings, known: Callable[[str], Scale | None]) -> list[dict[str, Any]]:
    """Return for each sickness scale and trial the number, median and worst of the answers."""
    out = []
    for name in dict.fromkeys(answer.scale for answer in ratings.survey):
        scale = known(name)
        if scale is None or scale.kind == QUESTIONNAIRE:
            continue
        by_trial: dict[int, list[float]] = {}
        for answer in ratings.survey:
            if answer.scale == name and answer.value is not None:
                by_trial.setdefault(answer.trial, []).append(answer.value)
        worst = max if scale.low_is_good else min
        trials = [
            {"trial": trial, "n": len(values), "median": float(np.median(values)), "worst": float(worst(values))}
            for trial, values in sorted(by_trial.items())
        ]
        out.append({"scale": name, "title": scale.title, "least": scale.least, "most": scale.most, "trials": trials})
    return out


def questionnaire_rows(ratings: Ratings, known: Callable[[str], Scale | None]) -> list[dict[str, Any]]:
    """Return a row for each score of each questionnaire: medians before and after, and the change.

    The change is over those who answered both times, each of them once: a person's sessions are
    averaged, as ratings are. p is of the exact Wilcoxon test of the change,
    uncorrected: these comparisons are not planned. Questionnaires that were answered at one time
    only are left to asked_once_rows.
    """
    out = []
    for scale, sheets in _questionnaires(ratings, known):
        if len(sheets) < 2:
            continue
        before, after = sheets["before"], sheets["after"]
        for score in dict.fromkeys(key for sheet in [*before.values(), *after.values()] for key in sheet):
            by_person: dict[str, list[float]] = {}
            for who, sheet in before.items():
                a, b = sheet[score], after.get(who, {}).get(score)
                if a is not None and b is not None:
                    by_person.setdefault(who[0], []).append(b - a)
            changes = np.array([sum(own) / len(own) for own in by_person.values()])
            row: dict[str, Any] = {"scale": scale.name, "title": scale.title, "score": score, "n": len(changes)}
            row |= {"before": _median(before, score), "after": _median(after, score)}
            if len(changes):
                row |= dict(zip(("change", "low", "high", "level"), shift_of(changes), strict=True))
                row["p"] = wilcoxon_exact(changes).p
            out.append(row)
    return out


def asked_once_rows(ratings: Ratings, known: Callable[[str], Scale | None]) -> list[dict[str, Any]]:
    """Return a row for each score of each questionnaire that was answered at one time only.

    Median and quartiles over `n` sheets that are complete for the score; "least" and "most" are
    what it can be. Nothing is compared: there is nothing to compare with.
    """
    out = []
    for scale, by_phase in _questionnaires(ratings, known):
        if len(by_phase) > 1:
            continue
        ((phase, sheets),) = by_phase.items()
        least, most = score_ranges(scale)
        for score in scale.scores:
            values = [value for sheet in sheets.values() if (value := sheet[score.name]) is not None]
            row: dict[str, Any] = {"scale": scale.name, "title": scale.title, "score": score.name, "when": phase}
            row |= {"score_title": score.title or score.name, "n": len(values)}
            row |= {"least": least[score.name], "most": most[score.name]}
            quartiles = np.percentile(values, (25, 50, 75)).tolist() if values else (None,) * 3
            out.append(row | dict(zip(("low_quartile", "median", "high_quartile"), quartiles, strict=True)))
    return out


def _questionnaires(
    ratings: Ratings, known: Callable[[str], Scale | None]
) -> Iterator[tuple[Scale, dict[str, Sheets]]]:
    """Yield each questionnaire about a session, with the scores by when it was answered."""
    for name in dict.fromkeys(answer.scale for answer in ratings.survey):
        scale = known(name)
        if scale is None or scale.kind != QUESTIONNAIRE:
            continue
        sheets = {phase: _scores(ratings.survey, scale, phase) for phase in ("before", "after")}
        answered = {phase: found for phase, found in sheets.items() if found}
        if answered:
            yield scale, answered


def _scores(answers: tuple[SurveyAnswer, ...], scale: Scale, phase: str) -> Sheets:
    sheets: Sheets = {}
    for answer in answers:
        if answer.scale == scale.name and answer.phase == phase:
            sheets.setdefault((answer.participant, answer.session), {})[answer.item] = answer.value
    return {who: scored(scale, sheet) for who, sheet in sheets.items()}


def _median(sheets: Sheets, score: str) -> float | None:
    values = [value for sheet in sheets.values() if (value := sheet.get(score)) is not None]
    return float(np.median(values)) if values else None


def scale_or_none(name: str) -> Scale | None:
    """Return a shipped scale, or None for a name that is none."""
    try:
        return load_scale(name)
    except InputError:
        return None


_LEAST_REST = 5  # degrees of freedom that must be left for the noise
_FIRST = "(nothing)"


def order_effects(rows: Sequence[Rating]) -> dict[str, Any]:
    """Estimate the effect of a trial's place (a slope per trial) and of the condition before it.

    Type II F tests by ordinary least squares, with participants and conditions. rows: of one part
    on one scale. Where the two effects are confounded, each is estimated without the other and
    names it ("or"). An effect that cannot be estimated is {"why_not": sentence}: nothing was rated,
    the order is not recorded, or it is the same for all participants.
    """
    rated = [row for row in rows if row.value is not None]
    if not all(row.place for row in rated) or not rated:
        why = (
            "nothing was rated"
            if not rated
            else "the place of some trials is not recorded"
            if any(row.place for row in rated)
            else "the order in which the conditions were shown is not recorded"
        )
        return {name: {"why_not": why} for name in ("place", "previous")}
    blocks = {
        "base": np.hstack(
            [_dummies([row.participant for row in rated]), _dummies([row.condition for row in rated])[:, 1:]]
        ),
        "place": np.array([[row.place] for row in rated], float),
        "previous": _dummies([row.previous or _FIRST for row in rated])[:, 1:],
    }
    values = np.array([row.value for row in rated], float)
    return {
        "place": _effect(values, blocks, "place", "previous"),
        "previous": _effect(values, blocks, "previous", "place"),
    }


def _dummies(names: Sequence[str]) -> NDArray[np.float64]:
    levels = list(dict.fromkeys(names))
    return np.array([[float(name == level) for level in levels] for name in names])


def _effect(
    values: NDArray[np.float64], blocks: dict[str, NDArray[np.float64]], name: str, other: str
) -> dict[str, Any]:
    """Estimate one effect; the other one leaves the model where the two are confounded."""
    effect = blocks[name]
    rest = blocks["base"] if not _adds(blocks["base"], blocks[other]) else np.hstack([blocks["base"], blocks[other]])
    model = np.hstack([rest, effect])
    df = _rank(model) - _rank(rest)
    if df == 0:
        if _rank(np.hstack([blocks["base"], effect])) > _rank(blocks["base"]):
            alone = _effect(values, {**blocks, other: np.zeros((len(values), 0))}, name, other)
            return alone if "why_not" in alone else alone | {"or": other}
        return {"why_not": "it is confounded with the conditions: all participants saw them in the same order"}
    if len(values) - _rank(model) < _LEAST_REST:
        return {"why_not": f"{counted(len(values), 'rating')} {'is' if len(values) == 1 else 'are'} too few for it"}
    api = import_extra("statsmodels.api", "statsmodels", "study")
    with warnings.catch_warnings():
        # Sums of squares, ranks and the slope are the same for every solution of least squares.
        warnings.filterwarnings("ignore", "The design matrix is rank-deficient")
        full, reduced = api.OLS(values, model).fit(), api.OLS(values, rest).fit()
    noise = float(full.ssr)
    if noise <= 1e-20 * max(float((values**2).sum()), 1e-300):
        return {"why_not": "the ratings leave no noise to compare it with"}
    f, p, _ = full.compare_f_test(reduced)
    found: dict[str, Any] = {"f": float(f), "df": df, "df_rest": int(full.df_resid), "p": float(p)}
    if name == "place":
        low, high = full.conf_int()[-1]
        found |= {"slope": float(full.params[-1]), "low": float(low), "high": float(high)}
    return found


def _adds(base: NDArray[np.float64], block: NDArray[np.float64]) -> bool:
    return block.shape[1] > 0 and _rank(np.hstack([base, block])) > _rank(base)


def _rank(matrix: NDArray[np.float64]) -> int:
    return int(np.linalg.matrix_rank(matrix)) if matrix.shape[1] else 0
