"""Quality levels: the Pareto-optimal combinations of warp and fill in a benchmark."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from statistics import fmean
from typing import Any

import attrs

from .. import report
from ..base import NO_NUMBERS, InputError, in_brief
from ..base.documents import json_in
from ..base.named_files import RESULTS

# The keys that two rows must share for their figures to be comparable.
_CASE = (
    *("trace", "scene", "latency_ms", "lens", "headset", "size"),
    *("rate_hz", "server_rate_hz", "guard", "predict", "frames"),
)
Row = Mapping[str, Any]
Figures = tuple[float, float, float | None]  # ms per eye, mean FLIP, mean PSNR in dB


@attrs.frozen
class QualityLevel:
    """One Pareto-optimal combination: nothing as cheap is more accurate."""

    # A registered name with its settings, as --warp takes it.
    warp: str
    fill: str
    total_ms: float  # per eye
    # Mean FLIP; 0 is perfect.
    error: float
    psnr_db: float | None = None

    def __str__(self) -> str:
        return self.warp if self.fill == "none" else f"{self.warp} + {self.fill}"

    def scaled(self, factor: float) -> QualityLevel:
        """Return the level on a machine, or at a size, that takes `factor` times as long."""
        return attrs.evolve(self, total_ms=self.total_ms * factor)


def levels_from(rows: Iterable[Row]) -> tuple[QualityLevel, ...]:
    """Return the Pareto front of error against time, from the cheapest level to the most accurate.

    Each is slower and better than the last. rows: as in bench.json. Figures are means over the
    cases (trace, scene, latency, ..) that every combination was measured in; of several sizes the
    largest counts, where time is scarcest; of several machines the one with the most rows. Rows
    without a time or a FLIP are ignored.
    Errors: InputError if no combination was measured, or no case is common to all.
    """
    measured = []
    for row in rows:
        total, error = row["time_ms"]["total"]["median"], row["quality"]["flip"]["mean"]
        if total is not None and error is not None and total > 0:
            measured.append((row, (float(total), float(error), row["quality"]["psnr_db"]["mean"])))
    if not measured:
        raise InputError(
            "no combination of warp and fill was measured with a time and a FLIP: run the benchmark with both"
        )
    most = max(math.prod(row["size"]) for row, _ in measured)
    # Times of two machines are not comparable.
    hosts = [(row.get("machine") or {}).get("host") for row, _ in measured if math.prod(row["size"]) == most]
    host = Counter(hosts).most_common(1)[0][0]
    combined: dict[tuple[str, str], dict[tuple[Any, ...], list[Figures]]] = {}
    for row, figures in measured:
        if math.prod(row["size"]) == most and (row.get("machine") or {}).get("host") == host:
            case = tuple(tuple(value) if isinstance(value := row.get(key), list) else value for key in _CASE)
            combined.setdefault((row["warp"], row["fill"]), {}).setdefault(case, []).append(figures)
    shared = set.intersection(*(set(cases) for cases in combined.values()))
    if not shared:
        raise InputError(
            f"the {len(combined)} combinations of warp and fill were measured in no common case, so they cannot be "
            "compared: measure all of them with the same traces, scenes and latencies"
        )
    levels = []  # fmean: no mean depends on the order of the rows
    for (warp, fill), cases in combined.items():
        times, errors, psnr = zip(*(figures for case in shared for figures in cases[case]), strict=True)
        levels.append(QualityLevel(warp, fill, fmean(times), fmean(errors), None if None in psnr else fmean(psnr)))
    return front(levels)


def best_within(levels: tuple[QualityLevel, ...], budget_ms: float | None, name: str = "--budget") -> int:
    """Return the index of the most accurate level within the budget.

    name: of the budget, in errors. Errors: InputError with the cheapest time if none fits.
    """
    budget_ms = check_budget(budget_ms, name)
    fitting = [number for number, level in enumerate(levels) if level.total_ms <= budget_ms]
    if not fitting:
        raise InputError(
            f"{name} {budget_ms:g} ms: nothing is that fast here; the cheapest, {levels[0]}, takes "
            f"{levels[0].total_ms:.2f} ms per eye: allow that much, or use a smaller size"
        )
    return fitting[-1]


def check_budget(budget_ms: float | None, name: str) -> float:
    """Return the budget. Errors: InputError for one that is no time above 0."""
    try:
        found = float(budget_ms or 0)
    except NO_NUMBERS:
        found = math.nan
    if budget_ms is None or not 0 < found < math.inf:
        said = in_brief(budget_ms) if math.isnan(found) else f"{found:g}"
        raise InputError(f"{name} {said} ms: expected a time above 0 ms for one eye")
    return budget_ms


def front(levels: list[QualityLevel]) -> tuple[QualityLevel, ...]:
    """Return those that nothing as cheap is more accurate than, from the cheapest on."""
    found: list[QualityLevel] = []
    for level in sorted(levels, key=lambda one: (one.total_ms, one.error, one.warp, one.fill)):
        if not found or level.error < found[-1].error:
            found.append(level)
    return tuple(found)


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a bench.json, less those of strategies.

    Errors: InputError naming the file and its fault.
    """
    bench = json_in(path, attrs.evolve(RESULTS, what="the bench.json that hmdwarp bench wrote"))
    if not isinstance(bench, dict) or not isinstance(bench.get("rows"), list):
        raise InputError(f"{path}: it has no list of 'rows'; expected the bench.json that hmdwarp bench wrote")
    if bench.get("schema") != report.SCHEMA:
        found = f"its schema is {bench.get('schema')!r}, this program reads {report.SCHEMA}"
        raise InputError(f"{path}: {found}: run hmdwarp bench again")
    for number, row in enumerate(bench["rows"]):
        faults = report.summary_faults(row)
        if faults:
            raise InputError(f"{path}: row {number}: {'; '.join(faults)}")
    return [row for row in bench["rows"] if not row.get("strategy")]
