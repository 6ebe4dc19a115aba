"""Ratings of whole studies of simulated people."""

from __future__ import annotations

import attrs
import numpy as np

from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo
from hmdwarp.study.design import Comparison, Design
from hmdwarp.study.respondents import Cohort, Model, Population
from hmdwarp.study.scales import Scale
from hmdwarp.study.store import SIMULATED


def simulate_study(design: Design, model: Model, n: int, seed: int, study: int = 0) -> Ratings:
    """n people in each part, who are all other people. The same numbers give the same ratings;
    study: another one of the same seed. Errors: InputError where the model lacks a scale or a
    condition of the study.
    """
    rows: list[dict] = []
    for part in design.parts:
        cohort = Population(model, design, part.name).of(range(n), seed, study)
        for person, order in enumerate(cohort.order):
            shown = [part.conditions[number] for number in order]
            for trial, condition in enumerate(shown):
                about = {
                    "participant": f"{part.name}-{person + 1}", "part": part.name, "condition": condition.name,
                    "reference": condition.reference, "repeat": trial // len(part.conditions) + 1,
                    "place": trial + 1, "previous": shown[trial - 1].name if trial else "",
                }  # fmt: skip
                for scale in design.scales:
                    value = cohort.answers[scale.name][person, trial]
                    rated = {"value": None, "why_missing": "x"} if np.isnan(value) else {"value": float(value)}
                    rows.append({"scale": scale.name, "why_missing": "", **about, **rated})
    measures = {scale.name: ScaleInfo.of(scale) for scale in design.scales}
    return Ratings(rows=rows, scale_info=measures, families=design.families, origin=SIMULATED)


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
