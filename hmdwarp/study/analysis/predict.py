"""Finds the measure of the pictures that predicts their ratings best, and how certain that is.

People differ in how they use a scale, so everything is within a person: ratings and measures count
from each person's own mean, and one slope holds for all (repeated-measures correlation). Intervals
come from drawing people anew, with all their ratings: a resample is a matrix product of weights and
sums per person.
Source: Bakdash and Marusich 2017, Repeated measures correlation, Front Psychol 8, 456; Efron 1987,
Better bootstrap confidence intervals; Varma and Simon 2006, Bias in error estimation when using
cross-validation for model selection, BMC Bioinformatics 7, 91.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import attrs
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import t as student

from ...errors import InputError
from ...metrics import PRIMARY, metrics_in_order
from ...report import counted, listed
from ..statistics import bca_shares

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
_CHARTS = 4  # measures that get a chart


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
    chosen: tuple[tuple[str, float], ...] = ()  # (title, share of the people), the most often chosen first
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


def predict(rows: Any, scale: str = "", resamples: int = RESAMPLES, seed: int = SEED) -> Prediction | None:
    """Return how each measure predicts the ratings on one scale; None where nothing was measured.

    rows: a long table of ratings. scale: by default the first in it. Too few data are not an error:
    `refused` gives the reason.
    """
    rows = pd.DataFrame(rows)
    if rows.empty:
        return None
    scale = scale or rows["scale"].iloc[0]
    rated = rows[(rows["scale"] == scale) & rows["value"].notna()]
    there = [name for name in MEASURES if name in rated and rated[name].notna().any()]
    if not there:
        return None
    way = {name: "; 'study measure' does it" if name.startswith("measured_") else "" for name in MEASURES}
    left_out = [(MEASURES[name], f"not measured{way[name]}") for name in MEASURES if name not in there]
    how = [name for name in ("measured_size", "measured_every") if name in rated]
    measured = rated[[name for name in there if name.startswith("measured_")]].notna().any(axis=1)
    unlike = len(rated.loc[measured, how].drop_duplicates()) > 1 if how else False
    for name in list(there):
        missing, why = int(rated[name].isna().sum()), ""
        if unlike and name.startswith("measured_"):
            why = "measured with several sizes or steps: 'study measure' with one --size makes them alike"
        elif missing > MOST_MISSING * len(rated):
            why = f"missing with {missing} of {len(rated)} ratings"
        if why:
            there.remove(name)
            left_out.append((MEASURES[name], why))
    kept = rated.dropna(subset=there)
    kept = kept[kept.groupby("participant")["value"].transform("size") >= LEAST_ROWS]
    spread = _centred(kept[there].astype(float), kept).abs().max()
    still = spread <= _STILL * kept[there].astype(float).abs().max().clip(lower=1e-300)
    left_out += [
        (MEASURES[name], "the same in all trials of each person") for name in there if len(kept) and still[name]
    ]
    varying = [name for name in there if len(kept) and not still[name]]
    people, conditions = kept["participant"].nunique(), len(kept[["part", "condition"]].drop_duplicates())
    refused = _refused(kept, people, conditions, varying)
    return Prediction(
        scale=scale,
        people=people,
        ratings=len(kept),
        conditions=conditions,
        dropped=len(rated) - len(kept),
        resamples=resamples,
        seed=seed,
        left_out=tuple(left_out),
        refused=refused,
        **({} if refused else _results(kept, varying, resamples, seed)),
    )


def _centred(values: Any, rows: pd.DataFrame) -> Any:
    """Subtract each person's mean."""
    return values - values.groupby(rows["participant"]).transform("mean")


def _refused(kept: pd.DataFrame, people: int, conditions: int, varying: Sequence[str]) -> str:
    if people < LEAST_PEOPLE:
        who = f"{LEAST_PEOPLE} people with {LEAST_ROWS} ratings and all metrics each"
        return f"needs {who}, found {people or 'none'}"
    if conditions < LEAST_CONDITIONS:
        return f"needs {LEAST_CONDITIONS} conditions, as any metric fits a line through two; found {conditions}"
    if not varying:
        return "no metric differs between the trials of a person"
    if len(kept) - people - 1 <= 1:
        return f"{counted(len(kept), 'rating')} of {counted(people, 'person')} are too few for a slope"
    alike = _centred(kept["value"].astype(float), kept).abs().max() <= _STILL
    return "every person gave the same rating throughout" if alike else ""


@attrs.frozen(eq=False)
class _Sums:
    """Sums over each person's ratings, of products of centred measures x and ratings y."""

    xx: Array  # (people, measures)
    xy: Array
    yy: Array  # (people, 1)
    count: Array

    @classmethod
    def of(cls, x: pd.DataFrame, y: pd.Series, rows: pd.DataFrame) -> _Sums:
        x, y = _centred(x, rows), _centred(y, rows)
        products = (x**2, x.mul(y, axis=0), (y**2).to_frame(), (y**0).to_frame())
        return cls(*(of.groupby(rows["participant"], sort=False).sum().to_numpy() for of in products))

    def correlations(self, weights: Array) -> Array:
        """Return correlations (draws, m), 0 where nothing varies. weights: (draws, people)."""
        size = np.sqrt((weights @ self.xx) * (weights @ self.yy))
        return np.asarray(np.divide(weights @ self.xy, size, out=np.zeros_like(size), where=size > 0))

    def errors(self) -> Array:
        """Return each person's squared error by each measure with the slope of all others."""
        xx, xy = self.xx.sum(axis=0) - self.xx, self.xy.sum(axis=0) - self.xy
        slope = np.divide(xy, xx, out=np.zeros_like(xx), where=xx > 0)
        return np.asarray(self.yy - 2 * slope * self.xy + slope**2 * self.xx)

    def skill(self, error: Array, drawn: Array) -> tuple[Array, Array, Array]:
        """Return the share of squared error that is removed, and its percentiles over people."""
        low, high = np.percentile(1 - (drawn @ error) / np.maximum(drawn @ self.yy, 1e-300), (2.5, 97.5), axis=0)
        return 1 - error.sum(axis=0) / self.yy.sum(), low, high

    def without(self, person: int) -> _Sums:
        return _Sums(*(np.delete(of, person, axis=0) for of in attrs.astuple(self, recurse=False)))


def _results(rows: pd.DataFrame, names: Sequence[str], resamples: int, seed: int) -> dict[str, Any]:
    """Return the fields of a Prediction that come from the figures."""
    x = rows[list(names)].astype(float)
    x = x / x.abs().max()  # so that squares of 1e-9 and of 1e9 are of one size
    y = rows["value"].astype(float) * (1 if rows["low_is_good"].iloc[0] else -1)
    who = rows["participant"]
    sums, ranks = _Sums.of(x, y, rows), _Sums.of(x.groupby(who).rank(), y.groupby(who).rank(), rows)
    people, rng = len(sums.yy), np.random.default_rng(seed)
    drawn = rng.multinomial(people, np.full(people, 1 / people), size=resamples).astype(np.float64)
    whole = np.ones((1, people))
    r, rank_r, resampled = sums.correlations(whole)[0], ranks.correlations(whole)[0], sums.correlations(drawn)
    low, high = _bca(r, resampled, sums.correlations(1 - np.eye(people)))
    shares, flips = sums.xy / np.sqrt(sums.xx.sum(axis=0) * sums.yy.sum()), _sign_flips(people, resamples, rng)
    error, everybody = sums.errors(), np.arange(people)
    skill, skill_low, skill_high = sums.skill(error, drawn)
    # For each person the others choose the measure, by leaving out each of them in turn.
    chosen = np.array([np.argmin(sums.without(person).errors().sum(axis=0)) for person in range(people)])
    choice = [float(of[0]) for of in sums.skill(error[everybody, chosen][:, None], drawn)]
    best, dof = int(np.argmax(np.abs(r))), len(rows) - people - 1
    firsts = np.bincount(np.argmax(np.abs(resampled), axis=1), minlength=len(names)) / resamples
    # Without an association each person's share is as likely to be its opposite: exact where all
    # flips are tried, and corrected for testing all measures.
    largest = np.abs(flips @ shares).max(axis=1)
    p_any = (largest[:, None] >= np.abs(shares.sum(axis=0)) - 1e-12).mean(axis=0)
    turned = shares * np.where(shares.sum(axis=0) < 0, -1.0, 1.0)
    ahead = turned[:, [best]] - turned
    behind_p = (np.abs(flips @ ahead) >= np.abs(ahead.sum(axis=0)) - 1e-12).mean(axis=0)
    t = np.abs(r) * np.sqrt(dof / np.maximum(1 - r**2, 1e-300))
    titles = [MEASURES[name] for name in names]
    columns: dict[str, Any] = {
        "name": names, "title": titles, "r": r, "low": low, "high": high, "p": 2 * student.sf(t, dof), "p_any": p_any,
        "rank_r": rank_r, "rmse": np.sqrt(np.maximum(error.sum(axis=0), 0) / len(rows)), "skill": skill,
        "skill_low": skill_low, "skill_high": skill_high, "skill_condition": _skill_of_conditions(x, y, rows),
        "best": firsts, "behind_p": behind_p,
    }  # fmt: skip
    together = np.abs(np.corrcoef(_centred(x, rows).to_numpy().T).reshape(len(names), -1)) >= ALIKE
    alike = [tuple(title for j, title in enumerate(titles) if j != k and of[j]) for k, of in enumerate(together)]
    columns |= {"dof": [dof] * len(names), "alike": alike}
    found = [
        MeasureResult(**{name: of[k].item() if isinstance(of, np.ndarray) else of[k] for name, of in columns.items()})
        for k in np.argsort(-np.abs(r), kind="stable").tolist()
    ]
    counts = pd.Series([titles[k] for k in chosen]).value_counts() / people
    return {
        "measures": tuple(found),
        "rmse_of_mean": float(np.sqrt(sums.yy.sum() / len(rows))),
        **dict(zip(("choice_skill", "choice_low", "choice_high"), choice, strict=True)),
        "chosen": tuple(counts.items()),
    }


def _bca(found: Array, resampled: Array, jackknifed: Array) -> tuple[Array, Array]:
    """Return the ends (m,) of 95 % BCa intervals."""
    # Ties count half: with few people many draws give the very same.
    below = ((resampled < found).mean(axis=0) + (resampled <= found).mean(axis=0)) / 2
    shares = bca_shares(np.clip(below, 0.5 / len(resampled), 1 - 0.5 / len(resampled)), jackknifed)
    ends = np.array([np.quantile(resampled[:, k], shares[:, k]) for k in range(len(found))])
    return ends[:, 0], ends[:, 1]


def _sign_flips(people: int, draws: int, rng: np.random.Generator) -> Array:
    """Return patterns (n, people) of +1 and -1: all, or the one without a flip and random ones."""
    if 2**people <= draws:
        return 1.0 - 2.0 * ((np.arange(2**people)[:, None] >> np.arange(people)) & 1).astype(np.float64)
    return np.vstack([np.ones((1, people)), rng.choice((-1.0, 1.0), size=(draws - 1, people))])


def _skill_of_conditions(x: pd.DataFrame, y: pd.Series, rows: pd.DataFrame) -> Array:
    """Predict each condition from all others, people's means included; NaN where none can be."""
    error, alone = np.zeros(x.shape[1]), 0.0
    for _, left in rows.groupby(["part", "condition"], sort=False):
        known = rows.index.difference(left.index)
        means = pd.concat([x, y.rename("y")], axis=1).loc[known].groupby(rows.loc[known, "participant"]).mean()
        asked = left.index[left["participant"].isin(means.index)]  # people without other ratings have no mean
        if not len(asked):
            continue
        dx, dy = _centred(x.loc[known], rows.loc[known]), _centred(y.loc[known], rows.loc[known])
        slope = (dx.mul(dy, axis=0).sum() / (dx**2).sum()).fillna(0.0)
        own = means.loc[rows.loc[asked, "participant"]].set_axis(asked)
        off = y[asked] - own["y"]
        error += (((x.loc[asked] - own[x.columns]).mul(slope).rsub(off, axis=0)) ** 2).sum().to_numpy()
        alone += float((off**2).sum())
    return 1 - error / alone if alone > 0 else np.full(x.shape[1], np.nan)


def pooled(studies: Mapping[str, Any], scale: str = "") -> tuple[str, pd.DataFrame]:
    """Return the scale, and the rows of all studies on it; people count from their own mean anyway.

    studies: long tables by name. scale: by default the first that all have. Participants and parts
    are named after their study, so that those of two are never one.
    Errors: InputError for a study without ratings on it, and where it has another good end.
    """
    tables = {name: pd.DataFrame(rows) for name, rows in studies.items()}
    scales = {name: list(rows["scale"].unique()) if len(rows) else [] for name, rows in tables.items()}
    first, *others = scales.values()
    chosen = scale or next((name for name in first if all(name in found for found in others)), "")
    if lacking := [f"'{name}' ({listed(found) or 'nothing'})" for name, found in scales.items() if chosen not in found]:
        wanted = f"on scale '{chosen}'" if chosen else "on one scale"
        raise InputError(f"expected ratings {wanted} in every study, and these have others: {listed(lacking)}")
    own = {name: rows[rows["scale"] == chosen] for name, rows in tables.items()}
    good = {name: bool(rows["low_is_good"].iloc[0]) for name, rows in own.items()}
    if len(set(good.values())) > 1:
        ways = listed([f"{'low' if low else 'high'} is good in '{name}'" for name, low in good.items()])
        raise InputError(f"the scale '{chosen}' is not the same in all studies: {ways}; predict each alone")
    keys = ("participant", "part")
    apart = [rows.assign(**{key: f"{name}: " + rows[key].fillna("") for key in keys}) for name, rows in own.items()]
    return chosen, pd.concat(apart, ignore_index=True)


def prediction_data(rows: Any, scale: str) -> dict[str, Any] | None:
    """Return the results of all measures, with sentences; None where nothing was measured."""
    rows = pd.DataFrame(rows)
    found = predict(rows, scale)
    if found is None:
        return None
    own = rows[rows["scale"] == scale].rename(columns={"value": "y"})
    return {
        "sentences": sentences(found),
        "measures": [{name: _plain(value) for name, value in attrs.asdict(one).items()} for one in found.measures],
        "left_out": [list(pair) for pair in found.left_out],
        "choice": {
            "skill": found.choice_skill,
            "low": found.choice_low,
            "high": found.choice_high,
            "chosen": dict(found.chosen),
        },
        "resamples": found.resamples,
        "seed": found.seed,
        "points": {
            one.name: own.rename(columns={one.name: "x"})[["participant", "x", "y"]].dropna().to_dict("records")
            for one in found.measures[:_CHARTS]
        },
    }


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
