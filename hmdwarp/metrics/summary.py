"""Aggregation of one row per frame and eye into the few figures of summary.json."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import HmdwarpError
from .metric import metrics_in_order

STAGES = ("warp", "fill", "effects", "lens", "total")
QUALITY = tuple(metric.name for metric in metrics_in_order())


def aggregate(rows: Iterable[Mapping[str, Any]]) -> dict[str, dict]:
    """Return the `time_ms`, `quality` and `measured` entries of summary.json.

    rows: keyed by the columns of frames.csv.
    time_ms: per stage {median, p95} of the `<stage>_ms` columns, per eye.
    quality: per metric {mean, p95}. p95 is always the bad tail: 95 % of the pictures are at least
    as good. It is the 5th percentile where higher is better (psnr_db, ssim), else the 95th.
    measured: per metric, how many pictures had it. A picture without a figure (None, or no such
    key) is left out of that metric, never counted as 0; without any, mean, median and p95 are None.
    Errors: HmdwarpError for NaN or infinite values, which no measurement gives.
    """
    rows = list(rows)
    names = (*(f"{stage}_ms" for stage in STAGES), *QUALITY)
    return aggregate_columns({name: [float(row[name]) for row in rows if row.get(name) is not None] for name in names})


def aggregate_columns(columns: Mapping[str, Sequence[float] | NDArray[np.float64]]) -> dict[str, dict]:
    """Aggregate whole columns that hold only measured values; a missing column was not measured.

    Errors: as aggregate.
    """
    for name, values in columns.items():
        if not np.isfinite(values).all():
            raise HmdwarpError(f"a {name} is not a finite number; expected a number, or None for not measured")
    quality = {metric: columns.get(metric.name, ()) for metric in metrics_in_order()}
    return {
        "time_ms": {stage: middle_and_tail(columns.get(f"{stage}_ms", ())) for stage in STAGES},
        "quality": {
            metric.name: _mean_and_tail(values, 5 if metric.higher_is_better else 95)
            for metric, values in quality.items()
        },
        "measured": {metric.name: len(values) for metric, values in quality.items()},
    }


def _mean_and_tail(values: Sequence[float] | NDArray[np.float64], percentile: int) -> dict[str, float | None]:
    if not len(values):
        return {"mean": None, "p95": None}
    # fsum: the mean must not depend on the order of the rows.
    return {"mean": math.fsum(values) / len(values), "p95": float(np.percentile(values, percentile))}


def middle_and_tail(values: Sequence[float] | NDArray[np.float64]) -> dict[str, float | None]:
    """Return {median, p95}, None for both where there are no values."""
    if not len(values):
        return {"median": None, "p95": None}
    return {"median": float(np.median(values)), "p95": float(np.percentile(values, 95))}
