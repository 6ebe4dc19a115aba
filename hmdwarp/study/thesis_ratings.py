"""What the ratings that the thesis published say, for `hmdwarp thesis`."""

from __future__ import annotations

import functools
from typing import Any

from .analysis import SourceOptions, analyse, from_csv, load_claims
from .design import SHIPPED


def published_ratings(part: str, latency_ms: float) -> dict[str, float | None]:
    """Return what the published ratings of one part and latency say, and what the thesis says.

    mean: of the pairs' differences, positive where the warped picture was rated better, on the
    scale of grades; p: exact, two-sided, after Holm within the part.
    """
    scale = _analysis()["scales"][0]
    claim = next(
        claim
        for claim in scale["claims"]
        if (claim["part"], claim["latency_ms"]) == (part, latency_ms) and claim["difference"] is not None
    )
    place = part, claim["baseline"], claim["condition"]
    row = next(row for row in scale["comparisons"] if (row["part"], row["baseline"], row["condition"]) == place)
    (conditions,) = (found["conditions"] for found in scale["parts"] if found["part"] == part)
    means = {condition["condition"]: condition["mean"] for condition in conditions}
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
