"""Numbers that need no picture: of the program, and of the ratings that the thesis published."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

from ..pipeline.link_times import refreshes_of
from ..scenes import load_scene
from ..study.analysis import SourceOptions, analyse, from_csv, load_claims
from ..study.design import SHIPPED
from .run_kinds import RATE_HZ, FactRun, Figures, RatingsRun

_FACTS: dict[str, Callable[[], float]] = {
    "triangles": lambda: float(load_scene("room").triangle_count),
    "place_of_500_ms": lambda: float(refreshes_of(500.0, RATE_HZ)),
}


def fact(run: FactRun) -> Figures:
    """Return the number of a fact."""
    return {"value": _FACTS[run.fact]()}


def ratings(run: RatingsRun) -> Figures:
    """Return what the published ratings of one part and latency say, and what the thesis says.

    mean: of the pairs' differences, positive where the warped picture was rated better, on the
    scale of grades; p: exact, two-sided, after Holm within the part.
    """
    scale = _analysis()["scales"][0]
    claim = next(
        one
        for one in scale["claims"]
        if (one["part"], one["latency_ms"]) == (run.part, run.latency_ms) and one["difference"] is not None
    )
    row = next(
        one
        for one in scale["comparisons"]
        if (one["part"], one["baseline"], one["condition"]) == (run.part, claim["baseline"], claim["condition"])
    )
    (part,) = (part for part in scale["parts"] if part["part"] == run.part)
    means = {one["condition"]: one["mean"] for one in part["conditions"]}
    return {
        "mean": row["mean"],
        "p": row["holm"],
        "published": claim["difference"],
        "off": abs(row["mean"] - claim["difference"]),
        "late": means[row["baseline"]],
        "warped": means[row["condition"]],
    }


@functools.cache
def _analysis() -> dict[str, Any]:
    found = from_csv(SHIPPED / "thesis_ratings.csv", SourceOptions(scale="grade"))
    return analyse(found, claims=load_claims(SHIPPED / "thesis_claims.toml"))
