"""A plan that several tests share, and ratings of whole studies of simulated people."""

from __future__ import annotations

import attrs
import numpy as np

from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo
from hmdwarp.study.design import Comparison, Design
from hmdwarp.study.respondents import Cohort, Model, Population
from hmdwarp.study.scales import Scale
from hmdwarp.study.store import COMPLETE, SICK, SIMULATED

LATE_OR_WARPED = """
schema = 1
name = "late-or-warped"
title = "Does a warp help?"
seed = 3
[common]
scene = "planes"
[trial]
seconds = 1
scales = ["grade"]
[practice]
seconds = 1
[sickness]
scale = "fms"
[questionnaires]
before = ["vrsq"]
after = ["vrsq"]
[[condition]]
name = "late"
latency = 400
warp = "none"
fill = "none"
[[condition]]
name = "warped"
latency = 400
warp = "forward"
guard = 1.5
[[condition]]
name = "reference"
latency = 0
warp = "none"
fill = "none"
reference = true
"""


def simulate_study(design: Design, model: Model, n: int, seed: int, study: int = 0) -> Ratings:
    """n people in each part, who are all other people.

    The same numbers give the same ratings; study: another one of the same seed.
    Errors: InputError where the model lacks a scale or a condition of the study.
    """
    rows: list[dict] = []
    sessions: list[dict] = []
    for part in design.parts:
        cohort = Population(model, design, part.name).of(range(n), seed, study)
        for person in range(n):
            rows += _rows(design, cohort, person)
            sessions.append(_session(cohort, person))
    return Ratings(
        rows=rows, scale_info={scale.name: ScaleInfo.of(scale) for scale in design.scales}, families=design.families,
        origin=SIMULATED, source=f"simulated people ({model.title}), seed {seed}, study {study}", title=design.title,
        sessions=sessions,
    )  # fmt: skip


def _name(cohort: Cohort, person: int) -> str:
    return f"{cohort.part.name}-{person + 1}"


def _rows(design: Design, cohort: Cohort, person: int) -> list[dict]:
    names = [cohort.part.conditions[number] for number in cohort.order[person]]
    rows = []
    for trial, condition in enumerate(names):
        for scale in design.scales:
            value = cohort.answers[scale.name][person, trial]
            rows.append(
                {
                    "participant": _name(cohort, person), "part": cohort.part.name, "condition": condition.name,
                    "scale": scale.name, "value": None if np.isnan(value) else float(value),
                    "why_missing": _why(cohort, person, trial) if np.isnan(value) else "",
                    "reference": condition.reference, "repeat": trial // len(cohort.part.conditions) + 1,
                    "place": trial + 1, "previous": names[trial - 1].name if trial else "",
                }
            )  # fmt: skip
    return rows


def _why(cohort: Cohort, person: int, trial: int) -> str:
    if trial < cohort.trials[person]:
        return "the participant could not say"
    return (
        "the stop rule for sickness ended the session before"
        if cohort.why[person] == SICK
        else "the session was stopped before"
    )


def _session(cohort: Cohort, person: int) -> dict:
    why = cohort.why[person]
    trials = int(cohort.trials[person])
    about = {"participant": _name(cohort, person), "part": cohort.part.name, "session": 1, "status": why}
    return {**about, "why": "" if why == COMPLETE else why, "rated": trials, "planned": cohort.order.shape[1]}


def unlimited(design: Design) -> Design:
    """The study on scales without ends or steps worth the name: people answer what they feel."""
    scales = (attrs.evolve(scale, least=-1000.0, most=1000.0, step=1e-6) for scale in design.scales)
    return attrs.evolve(design, scales=tuple(scales))


def per_condition(cohort: Cohort, scale: str) -> np.ndarray:
    """(n, conditions) means of each person's answers over the repeats."""
    values = cohort.answers[scale]
    found = [np.where(cohort.order == k, values, np.nan) for k in range(len(cohort.part.conditions))]
    with np.errstate(invalid="ignore"):
        sums, counts = np.nansum(found, axis=2), (~np.isnan(found)).sum(axis=2)
        return np.where(counts, sums / counts, np.nan).T


def differences(cohort: Cohort, scale: Scale, comparison: Comparison) -> np.ndarray:
    """How much better `better` was rated than the baseline, by each who rated both."""
    names = [condition.name for condition in cohort.part.conditions]
    rated = per_condition(cohort, scale.name)
    out = rated[:, names.index(comparison.baseline)] - rated[:, names.index(comparison.better)]
    return (out if scale.low_is_good else -out)[~np.isnan(out)]
