"""Ratings for tests: made by hand, or with known effects."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pandas as pd

from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo, frame
from hmdwarp.study.design import SHIPPED
from hmdwarp.study.scales import load_scale

PUBLISHED = SHIPPED / "thesis_ratings.csv"
GRADE = ScaleInfo.of(load_scale("grade"))


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
    """Ratings of four conditions in the orders of a Williams square.

    Effect per trial, carry times what the condition before is worth.
    """
    from hmdwarp.study.design.orders import williams

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


def written(path: Path, rows: list[dict[str, object]], delimiter: str = ",", bom: bool = False) -> Path:
    """A long table."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), delimiter=delimiter, lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    path.write_bytes((b"\xef\xbb\xbf" if bom else b"") + text.getvalue().encode())
    return path
