"""Named benchmarks: what they set, what they cost, and their means over all heads and scenes."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import attrs

from ... import metrics
from ...errors import InputError

Row = Mapping[str, Any]
_FILE = Path(__file__).with_name("suites.toml")
MEASURES = ("flip", "psnr_db")
# Of two, Student's t makes an interval 12.7 deviations wide each way, which says nothing.
LEAST_CLUSTERS = 3
# FLIP and SSIM of a 1280x800 picture take 0.6 s of a core.
_S_PER_PIXEL = 0.6 / (1280 * 800)


@attrs.frozen
class Suite:
    """A named benchmark."""

    name: str
    version: int
    summary: str
    # Values by option, as the command line has them.
    sets: Mapping[str, Any]


def suites() -> dict[str, Suite]:
    """Return all suites by name."""
    entries = tomllib.loads(_FILE.read_text(encoding="utf-8"))
    return {name: Suite(name, entry.pop("version"), entry.pop("summary"), entry) for name, entry in entries.items()}


def with_suite(said: Mapping[str, Any], usual: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the set options with those of the suite that they name, if any.

    usual: the default of each option. Errors: InputError for an option that the suite sets.
    """
    if not said.get("suite"):
        return said
    suite = suites()[said["suite"]]
    for name in (*suite.sets, "frames", "trace"):
        if said.get(name) not in (None, [], (), usual.get(name)):
            flag = "a trace" if name in ("traces", "trace") else f"--{name.replace('_', '-')}"
            raise InputError(f"{flag} with --suite {suite.name}: the suite says what is run; leave one of them out")
    return {**said, **suite.sets}


def cost_text(name: str, sizes: Sequence[tuple[int, int]], pictures: Sequence[int], workers: int | None) -> str:
    """Return what a suite will cost, in one sentence.

    sizes, pictures: (w, h) and the number of measured pictures of each case.
    """
    suite, count = suites()[name], metrics.worker_count(workers)
    seconds = sum(w * h * n for (w, h), n in zip(sizes, pictures, strict=True)) * _S_PER_PIXEL
    return (
        f"suite {name} {suite.version}: {len(sizes)} cases, {sum(pictures)} pictures to measure, about "
        f"{math.ceil(seconds / max(count, 1) / 60)} min for the metrics of {max(count, 1)} processes; "
        "drawing and warping come on top, most of them without a GPU"
    )


def suite_entry(name: str, rows: Iterable[Row]) -> dict[str, Any]:
    """Return `suite` of bench.json: name, version and over_all; empty for a bench of no suite."""
    return {"suite": {"name": name, "version": suites()[name].version, "over_all": over_all(rows)}} if name else {}


def over_all(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """Return the means of each method at each latency, over all heads and scenes, the best first.

    Each has `heads`, `scenes`, by measure {mean, interval}, and `behind`: how much more FLIP it has
    than the best of its latency in the same cases. interval: see clustered_interval.
    """
    by_latency: dict[float, dict[tuple[str, str], list[Row]]] = {}
    for row in rows:
        by_latency.setdefault(row["latency_ms"], {}).setdefault((row["warp"], row["fill"]), []).append(row)
    found = []
    for latency_ms, methods in sorted(by_latency.items()):
        best = min(methods.values(), key=lambda group: _mean(group, MEASURES[0]))
        best_of = {_case(row): _value(row, MEASURES[0]) for row in best}
        entries = [_entry(latency_ms, *method, group, best_of) for method, group in methods.items()]
        found += sorted(entries, key=lambda entry: entry[MEASURES[0]]["mean"])
    return found


def _entry(
    latency_ms: float, warp: str, fill: str, group: Sequence[Row], best_of: Mapping[tuple[str, str], float]
) -> dict[str, Any]:
    heads, scenes = zip(*map(_case, group), strict=True)
    series = {measure: [_value(row, measure) for row in group] for measure in MEASURES}
    series["behind"] = [_value(row, MEASURES[0]) - best_of[_case(row)] for row in group]
    entry: dict[str, Any] = {"latency_ms": latency_ms, "warp": warp, "fill": fill}
    entry |= {"heads": len(set(heads)), "scenes": len(set(scenes))}
    for name, values in series.items():
        interval = clustered_interval(values, heads, scenes)
        entry[name] = {"mean": math.fsum(values) / len(values), "interval": interval and list(interval)}
    return entry


def _case(row: Row) -> tuple[str, str]:
    return row["trace"], row["scene"]


def _value(row: Row, measure: str) -> float:
    value: float = row["quality"][measure]["mean"]
    return value


def _mean(group: Sequence[Row], measure: str) -> float:
    return math.fsum(_value(row, measure) for row in group) / len(group)


def clustered_interval(
    values: Sequence[float], heads: Sequence[str], scenes: Sequence[str]
) -> tuple[float, float] | None:
    """Return the 95 % interval of a mean of cases that share heads and scenes.

    None below three of each. The variances of the sums by head and by scene are added, that of
    single cases taken off; it is at least the larger of the two. Each has the correction for few
    clusters, and Student's t as many degrees of freedom as there are clusters of the rarer kind,
    less one.
    Source: Cameron, Gelbach and Miller 2011, Robust Inference With Multiway Clustering, 2.2.
    """
    kinds: tuple[Sequence[object], ...] = (heads, scenes, range(len(values)))
    counts = [len(set(kind)) for kind in kinds]
    if min(counts) < LEAST_CLUSTERS:
        return None
    import numpy as np
    from scipy.special import stdtrit

    series = np.asarray(values, np.float64)
    mean = float(series.mean())
    variances = []
    for kind, count in zip(kinds, counts, strict=True):
        places = {one: number for number, one in enumerate(dict.fromkeys(kind))}
        sums = np.bincount([places[one] for one in kind], weights=series - mean)
        variances.append(float(sums @ sums) / len(series) ** 2 * count / (count - 1))
    by_head, by_scene, single = variances
    variance = max(by_head + by_scene - single, by_head, by_scene)
    half = float(stdtrit(min(counts[:2]) - 1, (1 + metrics.LEVEL) / 2)) * math.sqrt(variance)
    return mean - half, mean + half
