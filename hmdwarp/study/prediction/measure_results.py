"""Finds the measure of the pictures that predicts their ratings best.

People differ in how they use a scale, so everything is within a person: ratings and measures count
from each person's own mean, and one slope holds for all (repeated-measures correlation). Intervals
come from drawing people anew, with all their ratings, because the ratings of one person are not
independent.
Source: Bakdash and Marusich 2017, Repeated measures correlation, Front Psychol 8, 456; Efron 1987,
Better bootstrap confidence intervals.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...metrics import PRIMARY, metrics_in_order
from ...report import counted
from .sums import (
    Sums,
    bca_intervals,
    correlations,
    p_of_any,
    p_of_behind,
    shares_of_people,
    sign_flips,
    skill_of_choice,
    skill_of_left_out_conditions,
    skill_of_left_out_people,
)

Row = Mapping[str, Any]
Array = NDArray[np.float64]

# Title of each column of the long table that is a measure.
MEASURES = {
    **{
        f"measured_{metric.name}": metric.study_title
        for metric in sorted(metrics_in_order(), key=lambda m: (m.name != PRIMARY, not m.is_contest, m.order))
    },
    "actual_latency_ms_median": "age of the frame",
    "actual_latency_ms_sd": "jitter of that age",
    "actual_hole_share_mean": "holes in the live picture",
    "actual_pose_age_ms_median": "age of the pose",
    "actual_missed_share": "missed refreshes",
    "actual_period_ms_p95": "95th percentile between pictures",
    "actual_angular_speed_deg_s_median": "speed of the turning head",
}
# With 5 people flipping signs gives p = 2/32 at least, and 4 people drawn anew give but 35 draws.
LEAST_PEOPLE = 6
LEAST_ROWS = 2  # of a person: a single rating has no mean to differ from
LEAST_CONDITIONS = 3  # two give a line through two points, whatever is measured
MOST_MISSING = 0.5  # share of ratings without a measure, above which the measure is left out
ALIKE = 0.95  # within-person correlation from which two measures cannot be distinguished
ALPHA = 0.05
RESAMPLES, SEED = 10_000, 20140612
_STILL = 1e-9  # of its own size: a measure that varies less is constant but for rounding


@attrs.frozen
class MeasureResult:
    """How one measure goes with the ratings."""

    name: str  # column of the long table
    title: str
    r: float  # repeated-measures correlation; positive where more of it was rated worse
    low: float  # 95 % BCa interval of r over people
    high: float
    p: float  # of Student's t for r
    dof: int
    p_any: float  # that no measure is associated with the ratings, over all measures, by sign flips
    rank_r: float  # r of ranks within each person
    rmse: float  # of a rating predicted from the person's own mean and the others' slope, scale units
    skill: float  # share of the person's mean's squared error that the measure removes; may be below 0
    skill_low: float  # 95 % percentile interval of skill over people
    skill_high: float
    skill_condition: float  # skill for a condition left out of slope and means; NaN for none
    best: float  # share of the resamples in which it predicts best
    behind_p: float  # that it is no worse than the best, by flipping signs of people's differences
    alike: tuple[str, ...]  # titles of measures that move with it


@attrs.frozen(kw_only=True)
class Prediction:
    """All measures of a study against the ratings on one scale."""

    scale: str
    low_is_good: bool
    people: int = 0
    ratings: int = 0
    conditions: int = 0
    dropped: int = 0  # ratings without all measures, or of people with a single one
    rmse_of_mean: float = 0.0  # error of each person's own mean, which every measure has to beat
    # What each person's ratings gain from the measure that all others choose, with 95 % percentile
    # interval: nested cross-validation.
    choice_skill: float = 0.0
    choice_low: float = 0.0
    choice_high: float = 0.0
    # (title, share of the people for whom the others chose it), the most often chosen first.
    chosen: tuple[tuple[str, float], ...] = ()
    measures: tuple[MeasureResult, ...] = ()  # by |r|, the best first
    left_out: tuple[tuple[str, str], ...] = ()  # (title, reason)
    refused: str = ""  # why there are no measures; "" where there are
    resamples: int = RESAMPLES
    seed: int = SEED

    @property
    def candidates(self) -> tuple[MeasureResult, ...]:
        """The best measure, and those that may be as good."""
        return tuple(measure for measure in self.measures if measure is self.measures[0] or measure.behind_p > ALPHA)

    @property
    def sure(self) -> bool:
        """Whether the best measure is associated with the ratings at all."""
        return bool(self.measures) and self.measures[0].p_any <= ALPHA


def predict(rows: Sequence[Row], scale: str = "", resamples: int = RESAMPLES, seed: int = SEED) -> Prediction | None:
    """Return how each measure predicts the ratings on one scale; None where nothing was measured.

    rows: as export.long_rows gives, of one origin. scale: by default the first in the rows.
    Too few data are not an error: `refused` gives the reason.
    """
    scale = scale or next((row["scale"] for row in rows), "")
    rated = [row for row in rows if row["scale"] == scale and row.get("value") is not None]
    measured = [name for name in MEASURES if any(_number(row, name) is not None for row in rated)]
    if not measured:
        return None
    low_is_good = bool(rated[0]["low_is_good"])
    usable, left_out = _often_enough(rated, measured)
    kept = _rated_twice([row for row in rated if all(_number(row, name) is not None for name in usable)])
    varying, still = _varying(kept, usable)
    counts = {
        "people": len({row["participant"] for row in kept}),
        "ratings": len(kept),
        "conditions": len({(row.get("part"), row["condition"]) for row in kept}),
    }
    common: dict[str, Any] = {
        "scale": scale,
        "low_is_good": low_is_good,
        "dropped": len(rated) - len(kept),
        "resamples": resamples,
        "seed": seed,
        "left_out": (*left_out, *still),
        **counts,
    }
    refused = _refused(**counts, varying=varying) or _all_alike(kept)
    if refused:
        return Prediction(refused=refused, **common)
    return Prediction(**common, **_results(kept, varying, low_is_good, resamples, seed))


def _number(row: Row, name: str) -> float | None:
    value = row.get(name)
    return None if value is None or isinstance(value, str) or not np.isfinite(value) else float(value)


def _was_measured(row: Row) -> bool:
    return any(_number(row, name) is not None for name in MEASURES if name.startswith("measured_"))


def _often_enough(rated: Sequence[Row], measured: Sequence[str]) -> tuple[list[str], list[tuple[str, str]]]:
    ways = {name: "; 'study measure' does it" if name.startswith("measured_") else "" for name in MEASURES}
    usable, left_out = [], [(MEASURES[name], f"not measured{ways[name]}") for name in MEASURES if name not in measured]
    unlike = len({(row.get("measured_size"), row.get("measured_every")) for row in rated if _was_measured(row)}) > 1
    for name in measured:
        if unlike and name.startswith("measured_"):
            why = "measured with several sizes or steps: 'study measure' with one --size makes them alike"
            left_out.append((MEASURES[name], why))
            continue
        missing = sum(_number(row, name) is None for row in rated)
        if missing > MOST_MISSING * len(rated):
            left_out.append((MEASURES[name], f"missing with {missing} of {len(rated)} ratings"))
        else:
            usable.append(name)
    return usable, left_out


def _rated_twice(rows: list[Row]) -> list[Row]:
    """Leave out people with a single rating."""
    counts = Counter(row["participant"] for row in rows)
    return [row for row in rows if counts[row["participant"]] >= LEAST_ROWS]


def _varying(rows: Sequence[Row], names: Sequence[str]) -> tuple[list[str], list[tuple[str, str]]]:
    varying, still = [], []
    who = _people_of(rows)
    for name in names:
        values = np.array([_number(row, name) for row in rows], dtype=np.float64)
        spread = np.abs(_centred(values[:, None], who)).max(initial=0.0)
        if spread <= _STILL * max(np.abs(values).max(initial=0.0), 1e-300):
            still.append((MEASURES[name], "the same in all trials of each person"))
        else:
            varying.append(name)
    return varying, still


def _people_of(rows: Sequence[Row]) -> NDArray[np.intp]:
    order = {name: k for k, name in enumerate(dict.fromkeys(row["participant"] for row in rows))}
    return np.array([order[row["participant"]] for row in rows], dtype=np.intp)


def _centred(values: Array, who: NDArray[np.intp]) -> Array:
    """Subtract each person's mean from values (n, m)."""
    count = int(who.max(initial=-1)) + 1
    sums = np.zeros((count, values.shape[1]))
    np.add.at(sums, who, values)
    return values - (sums / np.bincount(who, minlength=count)[:, None])[who]


def _ranked(values: Array, who: NDArray[np.intp]) -> Array:
    """Return midranks within each person."""
    from scipy.stats import rankdata

    out = np.empty_like(values)
    for person in range(int(who.max()) + 1):
        out[who == person] = rankdata(values[who == person], axis=0)
    return out


def _refused(people: int, ratings: int, conditions: int, varying: Sequence[str]) -> str:
    if people < LEAST_PEOPLE:
        who = f"{LEAST_PEOPLE} people with {LEAST_ROWS} ratings and all metrics each"
        return f"needs {who}, found {people or 'none'}"
    if conditions < LEAST_CONDITIONS:
        return f"needs {LEAST_CONDITIONS} conditions, as any metric fits a line through two; found {conditions}"
    if not varying:
        return "no metric differs between the trials of a person"
    if ratings - people - 1 > 1:
        return ""
    return f"{counted(ratings, 'rating')} of {counted(people, 'person')} are too few for a slope"


def _all_alike(rows: Sequence[Row]) -> str:
    values = np.array([[row["value"]] for row in rows], dtype=np.float64)
    alike = np.abs(_centred(values, _people_of(rows))).max() <= _STILL
    return "every person gave the same rating throughout" if alike else ""


def _results(rows: Sequence[Row], names: Sequence[str], low_is_good: bool, resamples: int, seed: int) -> dict[str, Any]:
    """Return the fields of a Prediction that come from the figures."""
    from scipy.stats import t as student

    who = _people_of(rows)
    x = np.array([[_number(row, name) for name in names] for row in rows], dtype=np.float64)
    x = x / np.abs(x).max(axis=0)  # so that squares of 1e-9 and of 1e9 are of one size
    y = np.array([row["value"] for row in rows], dtype=np.float64) * (1 if low_is_good else -1)
    sums = Sums.of(_centred(x, who), _centred(y[:, None], who)[:, 0], who)
    ranks = Sums.of(_centred(_ranked(x, who), who), _centred(_ranked(y[:, None], who), who)[:, 0], who)
    rng = np.random.default_rng(seed)
    drawn = rng.multinomial(sums.people, np.full(sums.people, 1 / sums.people), size=resamples).astype(np.float64)
    whole = np.ones((1, sums.people))
    r, rank_r, resampled = correlations(sums, whole)[0], correlations(ranks, whole)[0], correlations(sums, drawn)
    low, high = bca_intervals(r, resampled, correlations(sums, 1 - np.eye(sums.people)))
    shares, flips = shares_of_people(sums), sign_flips(sums.people, resamples, rng)
    dof = len(rows) - sums.people - 1
    skill, skill_low, skill_high, rmse = skill_of_left_out_people(sums, drawn)
    choice_skill, choice_low, choice_high, chosen = skill_of_choice(sums, drawn)
    conditions = [(row.get("part"), row["condition"]) for row in rows]
    of_conditions = skill_of_left_out_conditions(x, y, who, conditions)
    best = int(np.argmax(np.abs(r)))
    firsts = np.bincount(np.argmax(np.abs(resampled), axis=1), minlength=len(names)) / resamples
    p_any, behind_p = p_of_any(shares, flips), p_of_behind(shares, best, flips)
    together = np.abs(_together(_centred(x, who)))
    found = []
    for k in np.argsort(-np.abs(r), kind="stable").tolist():
        t = abs(r[k]) * np.sqrt(dof / max(1 - r[k] ** 2, 1e-300))
        alike = tuple(MEASURES[names[j]] for j in range(len(names)) if j != k and together[k, j] >= ALIKE)
        found.append(
            MeasureResult(
                name=names[k],
                title=MEASURES[names[k]],
                r=float(r[k]),
                low=float(low[k]),
                high=float(high[k]),
                p=float(2 * student.sf(t, dof)),
                dof=dof,
                p_any=float(p_any[k]),
                rank_r=float(rank_r[k]),
                rmse=float(rmse[k]),
                skill=float(skill[k]),
                skill_low=float(skill_low[k]),
                skill_high=float(skill_high[k]),
                skill_condition=float(of_conditions[k]),
                best=float(firsts[k]),
                behind_p=float(behind_p[k]),
                alike=alike,
            )
        )
    return {
        "measures": tuple(found),
        "rmse_of_mean": float(np.sqrt(sums.yy.sum() / len(rows))),
        "choice_skill": choice_skill,
        "choice_low": choice_low,
        "choice_high": choice_high,
        "chosen": tuple((MEASURES[names[k]], n / sums.people) for k, n in Counter(chosen.tolist()).most_common()),
    }


def _together(x: Array) -> Array:
    """Return the within-person correlations (m, m) of the measures with one another."""
    cross = x.T @ x
    size = np.sqrt(np.diag(cross))
    return np.asarray(cross / np.outer(size, size))
