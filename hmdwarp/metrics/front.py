"""The Pareto front: the methods that no other beats in both error and time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any, TypeVar

from ..errors import HmdwarpError
from .metric import PRIMARY, metrics

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

    A row beats another if it is at most as large in both costs and smaller in one. Rows equal in
    both do not beat each other: all of them stay, or none. A row with a cost of None was not
    measured and takes no part. Each other row that is left out is beaten by one that stays. O(n log
    n).
    Errors: HmdwarpError for a cost of NaN, which cannot be ordered.
    """
    rows = list(rows)
    measured = [
        (index, error, time)
        for index, (error, time) in enumerate(map(costs, rows))
        if error is not None and time is not None
    ]
    if any(math.isnan(error) or math.isnan(time) for _, error, time in measured):
        raise HmdwarpError(
            "a cost is not a number: expected an error and a time that were measured, or None for what was not"
        )
    kept: set[int] = set()
    least: tuple[float, float] | None = None  # (error, time) of the last row kept; times only grow from here on
    for index, error, time in sorted(measured, key=lambda entry: (entry[2], entry[1])):
        if least is None or error < least[0] or (error, time) == least:
            least = (error, time)
            kept.add(index)
    return [row for index, row in enumerate(rows) if index in kept]
