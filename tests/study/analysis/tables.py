"""Ratings for tests: made by hand, of simulated people, or with known effects."""

from __future__ import annotations

from collections.abc import Iterable

import attrs
import numpy as np
import pandas as pd

from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo, frame
from hmdwarp.study.design import PAIR, SHIPPED, Comparison, Design, design_from_text, pair_of, rows_for
from hmdwarp.study.design.orders import williams
from hmdwarp.study.respondents import Model, RatingModel, answers_of
from hmdwarp.study.scales import Scale, load_scale

from ..plans import text_of

PUBLISHED = SHIPPED / "thesis_ratings.csv"
GRADE = ScaleInfo.of(load_scale("grade"))
SCORES = {"late": -2.0, "turned": -1.4, "warped": -0.8, "reference": 0.0}


def ratings_of(
    values: dict[str, list[float | None]], part: str = "", reference: str = "", measure: ScaleInfo = GRADE
) -> Ratings:
    """values: by condition, a rating of each participant (called a, b, c, ..)."""
    rows = [
        {
            "participant": chr(ord("a") + k), "part": part, "condition": name, "scale": measure.name, "value": value,
            "why_missing": "" if value is not None else "not answered", "reference": name == reference,
        }
        for name, column in values.items()
        for k, value in enumerate(column)
    ]  # fmt: skip
    return Ratings(rows, {measure.name: measure})


def in_order(
    effect: float = 0.0, carry: float = 0.0, people: int = 24, noise: float = 0.3, seed: int = 1
) -> pd.DataFrame:
    """Ratings of four conditions in the orders of a Williams square. Effect per trial, carry times
    what the condition before is worth.
    """
    random, rows = np.random.default_rng(seed), []
    for person in range(people):
        level, order = random.normal(3, 0.5), williams(4)[person % 4]
        for place, condition in enumerate(order, 1):
            before = order[place - 2] if place > 1 else 0
            value = level + 0.5 * condition + effect * place + carry * before + random.normal(0, noise)
            name = f"c{before}" if place > 1 else ""
            about = {"participant": f"p{person}", "condition": f"c{condition}", "scale": "grade"}
            rows.append({**about, "value": float(value), "place": place, "previous": name})
    return frame(rows)


def pairs_of(scale: str = "preference", repeats: int = 1) -> Design:
    """A study of pairs."""
    changes = ('"preference"', f'"{scale}"'), ("repeats = 1", f"repeats = {repeats}")
    return design_from_text(text_of("scored", *changes), "pairs.toml", checked=False)


def judges(scale: str, noise: float, taste: float, threshold: float) -> Model:
    """People with known scores."""
    rating = RatingModel(means=SCORES, noise_sd=noise, condition_sd=taste, threshold=threshold)
    return Model("judges", ratings={scale: rating})


@attrs.frozen(eq=False)
class Cohort:
    """Simulated people, who saw the orders of a part by turns. NaN where there is no answer."""

    names: list[str]  # of the conditions
    order: np.ndarray  # (n, T, 2) numbers of those of a pair; of a single one twice
    why: list[str]  # status of the session
    answers: dict[str, np.ndarray]  # (n, T) by scale


def cohort_of(model: Model, design: Design, part: str, people: Iterable[int], seed: int) -> Cohort:
    rows = rows_for(design, part)
    names = [condition.name for condition in design.part(part).conditions]
    seen, found = [], []
    for k, person in enumerate(people):
        order = rows[k % len(rows)]
        pairs = (pair_of(one) if design.shows == PAIR else (one, one) for repeat in order for one in repeat)
        seen.append([tuple(map(names.index, pair)) for pair in pairs])
        found.append(answers_of(model, design, part, seed, person, order))
    answers = {scale: np.array([one.ratings[scale] for one in found]) for scale in found[0].ratings}
    return Cohort(names, np.array(seen), [one.why for one in found], answers)


def simulated(design: Design, model: Model, study: int, people: int = 14) -> Ratings:
    """A whole study of pairs, without pictures."""
    scale, cohort = design.scales[0], cohort_of(model, design, "main", range(people), study)
    common = {"part": "main", "scale": scale.name, "allows_ties": scale.allows_ties, "reference": "reference"}
    said = [
        {**common, "participant": f"p{k}", "first": cohort.names[a], "second": cohort.names[b], "answer": float(answer)}
        for k in range(people)
        for (a, b), answer in zip(cohort.order[k], cohort.answers[scale.name][k], strict=True)
    ]
    return Ratings(rows=(), scale_info={}, preferences=said, families=design.families)


def unlimited(design: Design) -> Design:
    """The study on scales without ends or steps worth the name: people answer what they feel."""
    scales = (attrs.evolve(scale, least=-1000.0, most=1000.0, step=1e-6) for scale in design.scales)
    return attrs.evolve(design, scales=tuple(scales))


def per_condition(cohort: Cohort, scale: str) -> np.ndarray:
    """(n, conditions) means of each person's answers over the repeats."""
    values = cohort.answers[scale]
    found = [np.where(cohort.order[..., 0] == k, values, np.nan) for k in range(len(cohort.names))]
    with np.errstate(invalid="ignore"):
        sums, counts = np.nansum(found, axis=2), (~np.isnan(found)).sum(axis=2)
        return np.where(counts, sums / counts, np.nan).T


def differences(cohort: Cohort, scale: Scale, comparison: Comparison) -> np.ndarray:
    """How much better `better` was rated than the baseline, by each who rated both."""
    rated, names = per_condition(cohort, scale.name), cohort.names
    out = rated[:, names.index(comparison.baseline)] - rated[:, names.index(comparison.better)]
    return (out if scale.low_is_good else -out)[~np.isnan(out)]
