"""Ratings for tests: made by hand, or with known effects."""

from __future__ import annotations

import numpy as np
import pandas as pd

from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo, frame
from hmdwarp.study.design import SHIPPED, Design, design_from_text
from hmdwarp.study.design.orders import williams
from hmdwarp.study.respondents import Model, Population, RatingModel
from hmdwarp.study.scales import load_scale

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
    square = williams(4)
    for person in range(people):
        level, before = random.normal(3, 0.5), None
        for place, condition in enumerate(square[person % 4], 1):
            value = (
                level
                + 0.5 * condition
                + effect * place
                + (carry * before if before is not None else 0)
                + random.normal(0, noise)
            )
            name = "" if before is None else f"c{before}"
            rows.append(
                {"participant": f"p{person}", "condition": f"c{condition}", "scale": "grade", "value": float(value)}
                | {"place": place, "previous": name}
            )
            before = condition
    return frame(rows)


def pairs_of(scale: str = "preference", repeats: int = 1) -> Design:
    """A study of pairs."""
    changes = ('"preference"', f'"{scale}"'), ("repeats = 1", f"repeats = {repeats}")
    return design_from_text(text_of("scored", *changes), "pairs.toml", checked=False)


def judges(scale: str, noise: float, taste: float, threshold: float) -> Model:
    """People with known scores."""
    rating = RatingModel(means=SCORES, noise_sd=noise, condition_sd=taste, threshold=threshold)
    return Model("judges", ratings={scale: rating})


def simulated(design: Design, model: Model, study: int, people: int = 14) -> Ratings:
    """A whole study of pairs, without pictures."""
    scale = design.scales[0]
    population = Population(model, design, "main")
    cohort = population.of(range(people), 7, study)
    orders = population._orders[population._allotted(cohort.why)]  # who saw what first
    names = [condition.name for condition in cohort.part.conditions]
    said = [
        {"participant": f"p{k}", "part": "main", "scale": scale.name, "first": names[first], "second": names[second]}
        | {"answer": float(answer), "allows_ties": scale.allows_ties, "reference": "reference"}
        for k in range(people)
        for (first, second), answer in zip(orders[k], cohort.answers[scale.name][k], strict=True)
    ]
    return Ratings(rows=(), scale_info={}, preferences=said, families=design.families)
