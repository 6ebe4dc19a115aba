"""Quality levels: the Pareto-optimal combinations of warp and fill in a benchmark."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import attrs

from .. import report
from ..errors import NO_NUMBERS, InputError, in_brief
from ..options.documents import json_in
from ..options.named_files import RESULTS

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
    # Per eye.
    total_ms: float
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
    combined, shared = _compared(rows)
    return front([_level(*key, [f for case in shared for f in cases[case]]) for key, cases in combined.items()])


def _compared(
    rows: Iterable[Row],
) -> tuple[dict[tuple[str, str], dict[tuple[Any, ...], list[Figures]]], set[tuple[Any, ...]]]:
    """Return figures of each warp and fill by case, and the cases that all have in common.

    Errors: as levels_from.
    """
    measured = _measured(rows)
    pixels = [row["size"][0] * row["size"][1] for row, _ in measured]
    measured = _of_one_machine([each for each, count in zip(measured, pixels, strict=True) if count == max(pixels)])
    combined: dict[tuple[str, str], dict[tuple[Any, ...], list[Figures]]] = {}
    for row, figures in measured:
        combined.setdefault((row["warp"], row["fill"]), {}).setdefault(_case(row), []).append(figures)
    shared = set.intersection(*(set(cases) for cases in combined.values()))
    if not shared:
        raise InputError(
            f"the {len(combined)} combinations of warp and fill were measured in no common case, so they cannot be "
            "compared: "
            "measure all of them with the same traces, scenes and latencies"
        )
    return combined, shared


def choose(rows: Iterable[Row], budget_ms: float) -> dict[str, Any]:
    """Return the `choice` entry of bench.json: the most accurate combination within the budget.

    Includes the next level up. budget_ms: per eye. sizes, cases: the size (several only if they
    have as many pixels) and the number of cases that the means are taken over.
    Errors: as levels_from; InputError for a budget that is not positive, or in which nothing fits.
    """
    rows = list(rows)
    levels, (_, shared) = levels_from(rows), _compared(rows)
    at = best_within(levels, budget_ms)
    following = _entry(levels[at + 1]) if at + 1 < len(levels) else None
    terms = {"sizes": sorted({case[_CASE.index("size")] for case in shared}), "cases": len(shared)}
    return {
        "budget_ms": float(budget_ms),
        **_entry(levels[at]),
        "settings": settings_of(levels[at].warp),
        **terms,
        "next": following,
    }


def best_within(levels: tuple[QualityLevel, ...], budget_ms: float | None, name: str = "--budget") -> int:
    """Return the index of the most accurate level within the budget.

    name: of the budget, in errors. Errors: InputError with the cheapest time if none fits.
    """
    budget_ms = check_budget(budget_ms, name)
    fitting = [number for number, level in enumerate(levels) if level.total_ms <= budget_ms]
    if not fitting:
        cheapest = levels[0]
        raise InputError(
            f"{name} {budget_ms:g} ms: nothing is that fast here; the cheapest, {cheapest}, takes "
            f"{cheapest.total_ms:.2f} ms per eye: "
            "allow that much, or use a smaller size"
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


def settings_of(warp: str) -> dict[str, str]:
    """Return the settings of a warp's spec.

    'iterative:seed=forward,steps=3' gives {'seed': 'forward', 'steps': '3'}.
    """
    _, _, settings = warp.partition(":")
    return dict(part.split("=", 1) for part in settings.split(",") if "=" in part)


def _entry(level: QualityLevel) -> dict[str, Any]:
    return {
        "warp": level.warp,
        "fill": level.fill,
        "total_ms": level.total_ms,
        "flip": level.error,
        "psnr_db": level.psnr_db,
    }


def _measured(rows: Iterable[Row]) -> list[tuple[Row, Figures]]:
    found = []
    for row in rows:
        total = row["time_ms"]["total"]["median"]
        error = row["quality"]["flip"]["mean"]
        if total is None or error is None or not total > 0:
            continue
        found.append((row, (float(total), float(error), row["quality"]["psnr_db"]["mean"])))
    if not found:
        raise InputError(
            "no combination of warp and fill was measured with a time and a FLIP: run the benchmark with both"
        )
    return found


def _of_one_machine(measured: list[tuple[Row, Figures]]) -> list[tuple[Row, Figures]]:
    """Return the rows of the machine that has the most: times of two are not comparable."""
    hosts = Counter((row.get("machine") or {}).get("host") for row, _ in measured)
    (most, _), *_ = hosts.most_common(1)
    return [found for found in measured if (found[0].get("machine") or {}).get("host") == most]


def _case(row: Row) -> tuple[Any, ...]:
    return tuple(tuple(value) if isinstance(value := row.get(key), list) else value for key in _CASE)


def _level(warp: str, fill: str, figures: list[Figures]) -> QualityLevel:
    times, errors, psnr = zip(*figures, strict=True)
    return QualityLevel(warp, fill, _mean(times), _mean(errors), None if None in psnr else _mean(psnr))


def _mean(values: tuple[float, ...]) -> float:
    # fsum: the mean must not depend on the order of the rows.
    return math.fsum(values) / len(values)


def front(levels: list[QualityLevel]) -> tuple[QualityLevel, ...]:
    """Return those that nothing as cheap is more accurate than, from the cheapest on."""
    front: list[QualityLevel] = []
    for level in sorted(levels, key=lambda r: (r.total_ms, r.error, r.warp, r.fill)):
        if not front or level.error < front[-1].error:
            front.append(level)
    return tuple(front)


def read_rows(path: Path) -> list[Row]:
    """Return the rows of a bench.json, less those of strategies.

    Errors: InputError naming the file and its fault.
    """
    wanted = attrs.evolve(RESULTS, what="the bench.json that hmdwarp bench wrote")
    bench = json_in(path, wanted)
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
