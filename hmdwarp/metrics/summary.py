"""From one row per frame and eye to the few figures of summary.json."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import HmdwarpError
from . import QUALITY, STAGES

HIGHER_IS_BETTER = frozenset({"psnr_db", "ssim"})


def aggregate(rows: Iterable[Mapping[str, Any]]) -> dict[str, dict]:
    """The `time_ms`, `quality` and `measured` entries of summary.json, from rows keyed by frames.csv's columns.

    time_ms: per stage {median, p95} of the `<stage>_ms` columns, per eye.
    quality: per figure {mean, p95}. p95 always tells of the bad tail: 95 % of the pictures are at least as good. It is the
    95th percentile of flip, the shares and flicker, and the 5th of psnr_db and ssim, where larger is better.
    measured: per figure, how many pictures had it. A picture without a figure (None, or no such key: not measured, first
    frame of a flicker pair) is left out of that figure, never counted as 0; without any, mean, median and p95 are None.
    Errors: HmdwarpError for NaN or infinite values, which no measurement gives.
    """
    rows = list(rows)
    names = (*(f"{stage}_ms" for stage in STAGES), *QUALITY)
    return aggregate_columns({name: [float(row[name]) for row in rows if row.get(name) is not None] for name in names})


def aggregate_columns(columns: Mapping[str, Sequence[float] | NDArray[np.float64]]) -> dict[str, dict]:
    """`aggregate` for whole columns, without what was not measured; a column that is not there was never measured. Errors: as aggregate."""
    for name, values in columns.items():
        if not np.isfinite(values).all():
            raise HmdwarpError(
                f"a {name} that is no finite number was measured; wanted a number, or None for not measured"
            )
    quality = {name: columns.get(name, ()) for name in QUALITY}
    return {
        "time_ms": {stage: middle_and_tail(columns.get(f"{stage}_ms", ())) for stage in STAGES},
        "quality": {
            name: _mean_and_tail(values, 5 if name in HIGHER_IS_BETTER else 95) for name, values in quality.items()
        },
        "measured": {name: len(values) for name, values in quality.items()},
    }


def _mean_and_tail(values: Sequence[float] | NDArray[np.float64], percentile: int) -> dict[str, float | None]:
    if not len(values):
        return {"mean": None, "p95": None}
    # fsum: the mean must not depend on the order of the rows.
    return {"mean": math.fsum(values) / len(values), "p95": float(np.percentile(values, percentile))}


def middle_and_tail(values: Sequence[float] | NDArray[np.float64]) -> dict[str, float | None]:
    """{median, p95}, None for both where there are no values."""
    if not len(values):
        return {"median": None, "p95": None}
    return {"median": float(np.median(values)), "p95": float(np.percentile(values, 95))}
