"""Figures over time: aggregation into summary.json, and how sure a mean is."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import HmdwarpError
from .metric import PRIMARY, metrics, metrics_in_order

LEAST_INSTANTS = 6  # make three blocks of two; fewer have no interval
LEVEL = 0.95

Interval = tuple[float, float]
Array = NDArray[np.float64]


def interval_of_mean(values: ArrayLike) -> Interval | None:
    """Return the interval of the mean of a figure at instants in their order, None for too few.

    By a moving-block bootstrap: blocks of neighbours are drawn, and a series wraps around at its
    end so that all instants count alike. The deviation of a mean of so many resamples has a closed
    form, so nothing is drawn. Student's t makes up for few blocks.
    Source: Kuensch 1989 (moving blocks); Politis and Romano 1992 (circular ones).
    """
    series = np.asarray(values, dtype=np.float64)
    count = len(series)
    if count < LEAST_INSTANTS:
        return None
    from scipy.special import stdtrit

    length, mean = block_length(series), float(series.mean())
    around = np.concatenate([series, series[: length - 1]]) - mean
    blocks = np.convolve(around, np.full(length, 1 / length), "valid")
    freedom = count / length - 1
    half = float(stdtrit(freedom, (1 + LEVEL) / 2) * math.sqrt((blocks @ blocks) / count / freedom))
    return mean - half, mean + half


def block_length(values: ArrayLike) -> int:
    """Return how many neighbours to draw at once: as many as their likeness calls for.

    At least the cube root of their number, for few instants show little of it; at most a third.
    Source: Politis and White 2004, section 3.2, with the constant for circular blocks as corrected
    by Patton, Politis and White 2009.
    """
    series = np.asarray(values, dtype=np.float64)
    count: int = len(series)
    apart = series - series.mean()
    alike = np.array([apart[: count - lag] @ apart[lag:] for lag in range(count)]) / count
    root: float = count ** (1 / 3)
    least, most = math.ceil(root), max(1, count // 3)
    if alike[0] <= 0:
        return min(least, most)
    small = np.abs(alike) < 2 * math.sqrt(math.log10(count) / count) * alike[0]
    run = max(5, math.ceil(math.log10(count)))
    last = next(lag for lag in range(count) if small[lag + 1 : lag + 1 + run].all())
    lags = np.arange(1, min(2 * max(last, 1), count - 1) + 1)
    weights = np.clip(2 * (1 - lags / (2 * max(last, 1))), 0, 1)
    slope = 2 * float(weights * lags @ alike[lags])
    spectrum = float(alike[0] + 2 * weights @ alike[lags])
    if spectrum <= 0:
        return min(least, most)
    wanted: float = (1.5 * (slope / spectrum) ** 2 * count) ** (1 / 3)
    return min(max(math.ceil(wanted), least), most)


def at_instants(rows: Iterable[Mapping[str, Any]], name: str) -> dict[int, float]:
    """Return a figure by refresh, in order of time: the mean of what was measured of its eyes.

    rows: keyed by the columns of frames.csv; one without a frame is left out.
    """
    found: dict[int, list[float]] = {}
    for row in rows:
        if row.get(name) is not None and "frame" in row:
            found.setdefault(row["frame"], []).append(float(row[name]))
    return {frame: math.fsum(values) / len(values) for frame, values in sorted(found.items())}


def difference(
    first: Sequence[Mapping[str, Any]], second: Sequence[Mapping[str, Any]], name: str
) -> dict[str, float | list[float] | None]:
    """Return {mean, interval} of first - second over the instants at which both were measured."""
    mean, interval = paired(at_instants(first, name), at_instants(second, name))
    return {"mean": mean, "interval": interval and list(interval)}


def paired(first: Mapping[Any, float], second: Mapping[Any, float]) -> tuple[float | None, Interval | None]:
    """Return mean and interval of first - second, figures by instant, over the instants of both."""
    apart = [value - second[at] for at, value in first.items() if at in second]
    return math.fsum(apart) / len(apart) if apart else None, interval_of_mean(apart)


def differ(first: Mapping[Any, float], second: Mapping[Any, float]) -> bool:
    """Return whether the difference of two figures by instant holds, as excludes_zero has it."""
    return excludes_zero(paired(first, second)[1])


def excludes_zero(interval: Sequence[float] | None) -> bool:
    """Return whether a difference holds: it has an interval, and that is all on one side of 0."""
    return interval is not None and (interval[0] > 0 or interval[1] < 0)


STAGES = ("warp", "fill", "effects", "lens", "total")
QUALITY = tuple(metric.name for metric in metrics_in_order())


def aggregate(rows: Iterable[Mapping[str, Any]]) -> dict[str, dict[str, Any]]:
    """Return the `time_ms`, `quality` and `measured` entries of summary.json.

    rows: keyed by the columns of frames.csv.
    time_ms: per stage {median, p95} of the `<stage>_ms` columns, per eye.
    quality: per metric {mean, p95, interval}; interval: interval_of_mean over the instants, within
    what the metric can be. p95 is always the bad tail: 95 % of the pictures are at least as good
    (the 5th percentile where higher is better).
    measured: per metric, how many pictures had it. A picture without a figure (None, or no such
    key) is left out of that metric, never counted as 0; without any, mean, median and p95 are None.
    Errors: HmdwarpError for NaN or infinite values, which no measurement gives.
    """
    rows = list(rows)
    names = (*(f"{stage}_ms" for stage in STAGES), *QUALITY)
    found = aggregate_columns({name: [float(row[name]) for row in rows if row.get(name) is not None] for name in names})
    for name, entry in found["quality"].items():
        interval = interval_of_mean([*at_instants(rows, name).values()])
        metric = metrics.get(name)
        entry["interval"] = interval and [max(interval[0], metric.least), min(interval[1], metric.most)]
    return found


def aggregate_columns(columns: Mapping[str, Sequence[float] | NDArray[np.float64]]) -> dict[str, dict[str, Any]]:
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
            # fsum: the mean must not depend on the order of the rows.
            metric.name: {
                "mean": math.fsum(values) / len(values) if len(values) else None,
                "p95": float(np.percentile(values, 5 if metric.higher_is_better else 95)) if len(values) else None,
            }
            for metric, values in quality.items()
        },
        "measured": {metric.name: len(values) for metric, values in quality.items()},
    }


def middle_and_tail(values: Sequence[float] | NDArray[np.float64]) -> dict[str, float | None]:
    """Return {median, p95}, None for both where there are no values."""
    if not len(values):
        return {"median": None, "p95": None}
    return {"median": float(np.median(values)), "p95": float(np.percentile(values, 95))}


Thing = TypeVar("Thing", bound=Any)
Costs = tuple[float | None, float | None]


def error_and_time(row: Mapping[str, Any], measure: str = PRIMARY) -> Costs:
    """Return a row's mean error and the median time of all its stages, in ms per eye.

    Lower is better in both: a metric where higher is better (PSNR, SSIM) counts negative. None
    where nothing was measured. measure: name of a metric.
    """
    error = row["quality"][measure]["mean"]
    if error is not None and metrics.get(measure).higher_is_better:
        error = -error
    return error, row["time_ms"]["total"]["median"]


def pareto(rows: Iterable[Thing], costs: Callable[[Thing], Costs] = error_and_time) -> list[Thing]:
    """Return the rows that no other row beats, in their order: the Pareto front of their two costs.

    A row beats another if it is at most as large in both costs and smaller in one; rows equal in
    both stay together. A row with a cost of None was not measured and takes no part.
    Errors: HmdwarpError for a cost of NaN, which cannot be ordered.
    """
    found = [(row, pair) for row in rows if None not in (pair := costs(row))]
    known = np.array([pair for _, pair in found], np.float64).reshape(-1, 2)
    if np.isnan(known).any():
        raise HmdwarpError(
            "a cost is not a number: expected an error and a time that were measured, or None for what was not"
        )
    others = known[None], known[:, None]
    beaten = np.any(np.all(np.less_equal(*others), axis=2) & np.any(np.less(*others), axis=2), axis=1)
    return [row for (row, _), is_beaten in zip(found, beaten.tolist(), strict=True) if not is_beaten]
