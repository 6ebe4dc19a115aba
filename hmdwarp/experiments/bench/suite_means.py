"""What a suite says of each method over all heads and scenes: means, bad tails, ranks."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...metrics import LEVEL, PRIMARY, metrics
from ...run.measuring import ORACLE
from .suites import FIT, HELD_OUT, half_of, suites

Row = Mapping[str, Any]
Method = tuple[str, str]
MEASURES = ("flip", "psnr_db")
# Of two, Student's t makes an interval 12.7 deviations wide each way, which says nothing.
_LEAST_CLUSTERS = 3
# Draws of heads and scenes: the ends of a 95 % interval then hold to 1.4 % of all draws (two
# standard errors of a share of 2.5 % in 500).
_DRAWS = 500


def suite_entry(name: str, rows: Iterable[Row], also: Sequence[Row] = ()) -> dict[str, Any]:
    """Return `suite` of bench.json, if any; also: what it took besides: see further."""
    if not name:
        return {}
    about = {"name": name, "version": suites()[name].version, "also": list(also)}
    return {"suite": {**about, "over_all": over_all(rows)}}


def compared_entry(name: str, rows: Iterable[Row]) -> dict[str, Any]:
    """Return `suite` of compare.json: each strategy over each link at each latency."""
    if not name:
        return {}
    by_link: dict[str, list[Row]] = {}
    for row in rows:
        if all(row["quality"][measure]["mean"] is not None for measure in MEASURES):
            used = {key: row[key] for key in ("trace", "scene", "latency_ms", "quality", "at_instants")}
            by_link.setdefault(row["over"], []).append({**used, "warp": row["strategy"], "fill": "none"})
    found = [
        {"over": over, "strategy": entry.pop("warp"), **entry}
        for over, group in by_link.items()
        for entry in over_all(group)
    ]
    return {"suite": {"name": name, "version": suites()[name].version, "over_all": found}}


def over_all(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """Return the means of each method at each latency, over all heads and scenes, the best first.

    By measure {mean, interval, p95 of all pictures}; `behind`: how much more FLIP it has than the
    best of its latency in the same cases, also of each of `halves`: see half_of; `where_seen_db`:
    PSNR where the late frame saw what the eye should see; `rank` {best, interval}: the share of
    draws in which it is the best by FLIP, and its rank in 95 % of them. The oracle is not ranked.
    """
    by_latency: dict[float, dict[Method, list[Row]]] = {}
    for row in rows:
        by_latency.setdefault(row["latency_ms"], {}).setdefault((row["warp"], row["fill"]), []).append(row)
    return [entry for latency_ms, methods in sorted(by_latency.items()) for entry in _of_latency(latency_ms, methods)]


def _of_latency(latency_ms: float, methods: Mapping[Method, list[Row]]) -> list[dict[str, Any]]:
    compared = {method: group for method, group in methods.items() if method[0] != ORACLE} or methods
    best = min(compared.values(), key=lambda group: _mean(_values(group, PRIMARY)))
    best_of = _by_case(best)
    ranks = ranks_of(compared)
    entries = [
        {"latency_ms": latency_ms, "warp": method[0], "fill": method[1], **_entry(group, best_of)}
        | {"rank": ranks.get(method)}
        for method, group in methods.items()
    ]
    return sorted(entries, key=lambda entry: entry[PRIMARY]["mean"])


def _entry(group: Sequence[Row], best_of: Mapping[tuple[str, str], float]) -> dict[str, Any]:
    clusters = _Clusters.of(map(_case, group))
    entry: dict[str, Any] = {"heads": len(set(clusters.heads)), "scenes": len(set(clusters.scenes))}
    entry |= {name: clusters.mean(_values(group, name)) | {"p95": _tail(group, name)} for name in MEASURES}
    halves = {half: [row for row in group if half_of(*_case(row)) == half] for half in (FIT, HELD_OUT)}
    entry["halves"] = {
        half: {"cases": len(rows), **{name: _mean(_values(rows, name)) if rows else None for name in MEASURES}}
        | {"behind": _behind(rows, best_of)}
        for half, rows in halves.items()
    }
    entry["behind"] = _behind(group, best_of)
    seen = [row["where_seen"]["psnr_db"] for row in group if "where_seen" in row]
    entry["where_seen_db"] = clusters.mean(seen) if len(seen) == len(group) else None
    return entry


def _behind(group: Sequence[Row], best_of: Mapping[tuple[str, str], float]) -> dict[str, Any] | None:
    both = [row for row in group if _case(row) in best_of]
    apart = [flip - best_of[_case(row)] for row, flip in zip(both, _values(both, PRIMARY), strict=True)]
    return _Clusters.of(map(_case, both)).mean(apart) if both else None


def _case(row: Row) -> tuple[str, str]:
    return row["trace"], row["scene"]


def _values(group: Iterable[Row], measure: str) -> list[float]:
    return [row["quality"][measure]["mean"] for row in group]


def _tail(group: Iterable[Row], measure: str) -> float:
    """Return what 95 % of all pictures are at least as good as."""
    values, sign = np.concatenate([[*row["at_instants"][measure].values()] for row in group]), 1
    if metrics.get(measure).higher_is_better:
        sign = -1
    return sign * float(np.quantile(sign * values, LEVEL, method="inverted_cdf"))


def _by_case(group: Iterable[Row]) -> dict[tuple[str, str], float]:
    return {_case(row): row["quality"][PRIMARY]["mean"] for row in group}


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values)


@attrs.frozen(slots=False)
class _Clusters:
    """Cases that share heads and scenes, one of each for each case."""

    heads: tuple[str, ...]
    scenes: tuple[str, ...]

    @classmethod
    def of(cls, cases: Iterable[tuple[str, str]]) -> _Clusters:
        """Return the clusters of cases, given as (head, scene)."""
        return cls(*zip(*cases, strict=True))

    @property
    def are_few(self) -> bool:
        """Whether there are too few heads or scenes to say how sure a figure is."""
        return min(len(set(self.heads)), len(set(self.scenes))) < _LEAST_CLUSTERS

    @cached_property
    def draws(self) -> NDArray[Any]:
        """Weights (draws, cases): how often a draw of heads has a case's, times that of scenes.

        Heads and scenes are drawn with replacement, the same ones at every call.
        Source: Owen 2007, The pigeonhole bootstrap.
        """
        rng, weights = np.random.default_rng(0), np.ones((_DRAWS, len(self.heads)))
        for kind in (self.heads, self.scenes):
            names, place = np.unique(kind, return_inverse=True)
            weights *= rng.multinomial(len(names), np.full(len(names), 1 / len(names)), _DRAWS)[:, place]
        drawn: NDArray[Any] = weights[weights.sum(axis=1) > 0]
        return drawn

    def mean(self, values: Sequence[float]) -> dict[str, Any]:
        """Return the mean of one value of each case and its interval: see clustered_interval."""
        interval = clustered_interval(values, self.heads, self.scenes)
        return {"mean": _mean(values), "interval": interval and list(interval)}


def ranks_of(methods: Mapping[Method, Sequence[Row]]) -> dict[Method, dict[str, Any]]:
    """Return the `rank` of each method in the cases that all have; none for few heads or scenes."""
    from scipy.stats import rankdata

    found = [_by_case(group) for group in methods.values()]
    cases = [case for case in found[0] if all(case in each for each in found)]
    if not cases or (clusters := _Clusters.of(cases)).are_few:
        return {}
    values = np.array([[each[case] for case in cases] for each in found])
    ranks = rankdata(clusters.draws @ values.T, method="min", axis=1)
    ends = ((1 - LEVEL) / 2, (1 + LEVEL) / 2)
    return {
        method: {"best": float((of == 1).mean()), "interval": [round(end) for end in np.quantile(of, ends)]}
        for method, of in zip(methods, ranks.T, strict=True)
    }


def clustered_interval(
    values: Sequence[float], heads: Sequence[str], scenes: Sequence[str]
) -> tuple[float, float] | None:
    """Return the 95 % interval of a mean of cases that share heads and scenes; None for few.

    The variances of the sums by head and by scene are added, that of single cases taken off; it is
    at least the larger of the two. Each has the correction for few clusters, and Student's t as
    many degrees of freedom as there are clusters of the rarer kind, less one.
    Source: Cameron, Gelbach and Miller 2011, Robust Inference With Multiway Clustering, 2.2.
    """
    kinds: tuple[Sequence[object], ...] = (heads, scenes, range(len(values)))
    counts = [len(set(kind)) for kind in kinds]
    if min(counts) < _LEAST_CLUSTERS:
        return None
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
    half = float(stdtrit(min(counts[:2]) - 1, (1 + LEVEL) / 2)) * math.sqrt(variance)
    return mean - half, mean + half
