"""Named benchmarks: what they set, what they cost, and their means with intervals."""

from __future__ import annotations

import functools
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from ...errors import InputError, unknown_name
from ...metrics import LEVEL, PRIMARY, metrics, worker_count
from ...run.combinations import ORACLE

if TYPE_CHECKING:
    from numpy.typing import NDArray


# Halves of scenes and heads.
FIT, HELD_OUT = "fit", "held_out"
_FILE = Path(__file__).with_name("suites.toml")
# FLIP and SSIM of a 1280x800 picture take 0.6 s of a core; drawing and warping for 30 pictures of
# 480x300, two instants of a case of `standard`, 8 to 13 s without a GPU.
_S_PER_PIXEL, _DRAWN_S_PER_PIXEL = 0.6 / (1280 * 800), 10 / (30 * 480 * 300)
# A comparison draws, codes and warps every refresh: 72 runs of 64 pictures of 640x400 took 14 min.
_S_PER_RUN, _RUN_S_PER_PIXEL = 2.5, 9 / (64 * 640 * 400)


@attrs.frozen
class Suite:
    """A named benchmark."""

    name: str
    version: int
    summary: str
    # Names of the scenes by others that it takes where they are: see further.toml.
    recipes: tuple[str, ...]
    # Values by option, as the command line has them: of a bench, and of a comparison, where `scene`
    # and `links` may have several.
    sets: Mapping[str, Any]
    compare: Mapping[str, Any]


def _entries() -> dict[str, Any]:
    return tomllib.loads(_FILE.read_text(encoding="utf-8"))


@functools.cache
def halves() -> dict[str, dict[str, list[str]]]:
    """Return `scenes` and `heads` of the half that parameters are fitted on, and of the other."""
    found: dict[str, dict[str, list[str]]] = _entries()["halves"]
    return found


def half_of(head: str, scene: str) -> str:
    """Return the half that a case belongs to; "" for one of both, or of neither."""
    return next((name for name, half in halves().items() if head in half["heads"] and scene in half["scenes"]), "")


def suites() -> dict[str, Suite]:
    """Return all suites by name."""
    entries = _entries()
    del entries["halves"]
    found = {}
    for name, entry in entries.items():
        version, summary, recipes, own = (entry.pop(key) for key in ("version", "summary", "recipes", "compare"))
        shared = {name: entry[name] for name in ("scene", "traces", "headset", "samples")} | {"size": entry["size"][0]}
        found[name] = Suite(name, version, summary, tuple(recipes), entry, shared | own)
    return found


def with_suite(said: Mapping[str, Any], usual: Mapping[str, Any], *, compares: bool = False) -> Mapping[str, Any]:
    """Return the set options with those of the suite that they name, if any.

    usual: the default of each option. compares: whether they are those of a comparison.
    Errors: InputError for an unknown suite, and for an option that the suite sets.
    """
    if not said.get("suite"):
        if said.get("also") is not None:
            raise InputError("--also without --suite: give scenes by --scene and recorded frames by --frames")
        return said
    if said["suite"] not in suites():
        raise unknown_name("suite", said["suite"], list(suites()))
    suite = suites()[said["suite"]]
    sets = suite.compare if compares else suite.sets
    for name in (*sets, "frames", "trace", *(sets["links"][-1] if compares else ())):
        if said.get(name) not in (None, [], (), usual.get(name)):
            flag = "a trace" if name in ("traces", "trace") else f"--{name.replace('_', '-')}"
            raise InputError(f"{flag} with --suite {suite.name}: the suite says what is run; leave one of them out")
    return {**said, **{name: value for name, value in sets.items() if not compares or name not in ("scene", "links")}}


def cost_text(
    name: str,
    sizes: Sequence[tuple[int, int]],
    pictures: Sequence[int],
    workers: int | None,
    drawn: Sequence[int] | None = None,
) -> str:
    """Return what a suite will cost, in one sentence.

    sizes, pictures: (w, h) and the number of measured pictures of each case. drawn: of those that
    are drawn and shown, for runs.
    """
    suite, count = suites()[name], max(worker_count(workers), 1)
    pixels = sum(w * h * n for (w, h), n in zip(sizes, pictures, strict=True))
    drawn_s = pixels * _DRAWN_S_PER_PIXEL
    if drawn is not None:
        drawn_s = sum(_S_PER_RUN + w * h * n * _RUN_S_PER_PIXEL for (w, h), n in zip(sizes, drawn, strict=True))
    return (
        f"suite {name} {suite.version}: {len(sizes)} cases, {sum(pictures)} pictures to measure, about "
        f"{math.ceil(pixels * _S_PER_PIXEL / count / 60)} min for the metrics of {count} processes; without a GPU "
        f"drawing and warping take about {math.ceil(drawn_s / 60)} min of one core more"
    )


Row = Mapping[str, Any]
Method = tuple[str, str]
MEASURES = ("flip", "psnr_db")
# Of two, Student's t makes an interval 12.7 deviations wide each way, which says nothing.
LEAST_CLUSTERS = 3
# Draws of heads and scenes: the ends of a 95 % interval then hold to 1.4 % of all draws (two
# standard errors of a share of 2.5 % in 500).
_DRAWS = 500


def suite_entry(name: str, rows: Iterable[Row], sequences: Sequence[Row] = ()) -> dict[str, Any]:
    """Return `suite` of bench.json: name, version, sequences, over_all; empty for no suite.

    sequences: what it took that was recorded: see about_sequence.
    """
    if not name:
        return {}
    about = {"name": name, "version": suites()[name].version, "sequences": list(sequences)}
    return {"suite": {**about, "over_all": over_all(rows)}}


def compared_entry(name: str, rows: Iterable[Row]) -> dict[str, Any]:
    """Return `suite` of compare.json, as suite_entry: each strategy over each link at each latency.

    `over` says over which link. A run that showed nothing is in no mean.
    """
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

    Each has `heads`, `scenes`; by measure {mean, interval, p95, p95_interval}, where p95 is that of
    all pictures; `behind`: how much more FLIP it has than the best of its latency in the same
    cases; `halves`: see half_of; `where_seen_db`: PSNR where the late frame saw what the eye should
    see; `rank` {best, interval}: the share of draws in which it is the best by FLIP, and its rank
    in 95 % of them. The oracle is neither best nor ranked.
    """
    by_latency: dict[float, dict[Method, list[Row]]] = {}
    for row in rows:
        by_latency.setdefault(row["latency_ms"], {}).setdefault((row["warp"], row["fill"]), []).append(row)
    return [entry for latency_ms, methods in sorted(by_latency.items()) for entry in _of_latency(latency_ms, methods)]


def _of_latency(latency_ms: float, methods: Mapping[Method, list[Row]]) -> list[dict[str, Any]]:
    compared = {method: group for method, group in methods.items() if method[0] != ORACLE} or methods
    best = min(compared.values(), key=lambda group: _mean(_values(group, PRIMARY)))
    best_of = {_case(row): _value(row, PRIMARY) for row in best}
    ranks = ranks_of(compared)
    entries = [
        {"latency_ms": latency_ms, "warp": method[0], "fill": method[1], **_entry(group, best_of)}
        | {"rank": ranks.get(method)}
        for method, group in methods.items()
    ]
    return sorted(entries, key=lambda entry: entry[PRIMARY]["mean"])


def _entry(group: Sequence[Row], best_of: Mapping[tuple[str, str], float]) -> dict[str, Any]:
    clusters = Clusters.of(map(_case, group))
    entry: dict[str, Any] = {"heads": len(set(clusters.heads)), "scenes": len(set(clusters.scenes))}
    entry |= {name: clusters.mean(_values(group, name)) | clusters.tail(group, name) for name in MEASURES}
    halves = {half: [row for row in group if half_of(*_case(row)) == half] for half in (FIT, HELD_OUT)}
    entry["halves"] = {
        half: {"cases": len(rows), **{name: _mean(_values(rows, name)) if rows else None for name in MEASURES}}
        for half, rows in halves.items()
    }
    both = [(row, best_of[_case(row)]) for row in group if _case(row) in best_of]
    entry["behind"] = Clusters.of(_case(row) for row, _ in both).mean([_value(row, PRIMARY) - of for row, of in both])
    seen = [row["where_seen"]["psnr_db"] for row in group if "where_seen" in row]
    entry["where_seen_db"] = clusters.mean(seen) if len(seen) == len(group) else None
    return entry


def _case(row: Row) -> tuple[str, str]:
    return row["trace"], row["scene"]


def _value(row: Row, measure: str) -> float:
    value: float = row["quality"][measure]["mean"]
    return value


def _values(group: Iterable[Row], measure: str) -> list[float]:
    return [_value(row, measure) for row in group]


def _mean(values: Sequence[float]) -> float:
    return math.fsum(values) / len(values)


@attrs.frozen(slots=False)
class Clusters:
    """Cases that share heads and scenes, one of each for each case."""

    heads: tuple[str, ...]
    scenes: tuple[str, ...]

    @classmethod
    def of(cls, cases: Iterable[tuple[str, str]]) -> Clusters:
        """Return the clusters of cases, given as (head, scene)."""
        return cls(*zip(*cases, strict=True))

    @property
    def are_few(self) -> bool:
        """Whether there are too few heads or scenes to say how sure a figure is."""
        return min(len(set(self.heads)), len(set(self.scenes))) < LEAST_CLUSTERS

    @cached_property
    def draws(self) -> NDArray[Any]:
        """Weights (draws, cases): how often a draw of heads has a case's, times that of scenes.

        Heads and scenes are drawn with replacement, the same ones at every call.
        Source: Owen 2007, The pigeonhole bootstrap.
        """
        import numpy as np

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

    def tail(self, group: Sequence[Row], measure: str) -> dict[str, Any]:
        """Return p95 of the pictures of all cases, and its interval over the draws.

        95 % of the pictures are at least as good.
        """
        import numpy as np

        at = [list(row["at_instants"][measure].values()) for row in group]
        values, case = np.concatenate(at), np.repeat(np.arange(len(at)), [len(each) for each in at])
        order = np.argsort(values if not metrics.get(measure).higher_is_better else -values)
        every = np.vstack([np.ones(len(at)), *([] if self.are_few else [self.draws])])
        summed = np.cumsum(every[:, case[order]], axis=1)
        places = (summed >= LEVEL * summed[:, -1:]).argmax(axis=1)
        found = values[order][places]
        return {"p95": float(found[0]), "p95_interval": None if self.are_few else _middle(found[1:])}


def _middle(draws: NDArray[Any]) -> list[float]:
    import numpy as np

    found: list[float] = np.quantile(draws, [(1 - LEVEL) / 2, (1 + LEVEL) / 2]).tolist()
    return found


def ranks_of(methods: Mapping[Method, Sequence[Row]]) -> dict[Method, dict[str, Any]]:
    """Return the `rank` of each method in the cases that all have; none for few heads or scenes."""
    import numpy as np
    from scipy.stats import rankdata

    found = [{_case(row): _value(row, PRIMARY) for row in group} for group in methods.values()]
    cases = [case for case in found[0] if all(case in each for each in found)]
    if not cases or (clusters := Clusters.of(cases)).are_few:
        return {}
    values = np.array([[each[case] for case in cases] for each in found])
    ranks = rankdata(clusters.draws @ values.T, method="min", axis=1)
    return {
        method: {"best": float((of == 1).mean()), "interval": [round(end) for end in _middle(of)]}
        for method, of in zip(methods, ranks.T, strict=True)
    }


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
    half = float(stdtrit(min(counts[:2]) - 1, (1 + LEVEL) / 2)) * math.sqrt(variance)
    return mean - half, mean + half
