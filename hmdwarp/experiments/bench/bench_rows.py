"""The rows of bench.json and the flat columns of bench.csv, from the measurements."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import reduce
from operator import add
from typing import Any

from ...client.capability import lacking
from ...client.classes import Client
from ...metrics import (
    JOD,
    QUALITY,
    REGIONS,
    STAGES,
    TRUTH_JOD,
    TRUTH_PREFERRED,
    Mismatch,
    QualityPool,
    at_instants,
    blocks_text,
    pooled,
    ratings_of,
)
from ...run.combination_bench import Measured
from ...run.combinations import Case
from ...run.replay_results import summary_of_rows
from ...run.replay_setup import ReplaySetup
from .cases import baselines
from .traffic import passes_of

OUTSIDE_LACKS = "it is another library's, run on the CPU to compare with"
PASSES = ("client_depth", "warp", "fill", "effects", "lens")
_PASS_FIGURES = ("bytes", "bound_ms", "median_ms", "times_bound")
_REGION_FIGURES = ("share", "psnr_db", "flip")
_PLAIN = (
    "trace",
    "scene",
    "latency_ms",
    "strategy",
    "warp",
    "fill",
    "lens",
    "headset",
    "frames",
    "rate_hz",
    "server_rate_hz",
    "guard",
    "predict",
    "clock",
)

COLUMNS = (
    *_PLAIN,
    "width",
    "height",
    *(f"{stage}_ms{tail}" for stage in STAGES for tail in ("", "_p95")),
    *(f"{name}{tail}" for name in QUALITY for tail in ("", "_p95", "_low", "_high")),
    *(f"{region}_{figure}" for region in REGIONS for figure in _REGION_FIGURES),
    "mismatch",
    JOD.name,
    TRUTH_PREFERRED.name,
    "client",
    "lacks",
    "baseline",
    *(f"{name}_pass_{figure}" for name in PASSES for figure in _PASS_FIGURES),
    "gl_renderer",
    "cpu_count",
    "host",
)
# Columns that are no numbers, and those that are whole ones.
TEXTS = (
    *("trace", "scene", "strategy", "warp", "fill", "lens", "headset", "guard", "predict"),
    *("clock", "client", "lacks", "baseline", "gl_renderer", "host"),
)
# Keys of a row that grow with its pictures and passes.
LONG = ("at_instants", "blocks", "passes", "jod")
WHOLE = ("frames", "width", "height", "cpu_count")


def row_of(
    setup: ReplaySetup, case: Case, measured: Measured, pool: QualityPool, bytes_per_s: float, client: Client
) -> dict[str, Any]:
    """Return one row of bench.json.

    It has the keys of summary.json, the error by region, the eyes' mismatch, the time and bound of
    each pass, the pictures in few numbers, the strategy where it was asked for as one, why the
    client cannot run it ("" if it can), and the system that the warp stands for as a baseline (""
    if none).
    """
    combination = measured.combination
    figures, regions = pool.results, pool.regions
    pictures = [{"frame": key[3], **figures[key]} for key in measured.keys]
    passes = combination.warp, combination.fill, combination.plan.lens.name
    base = summary_of_rows(setup, passes, [*measured.times, *pictures])
    rendered_pixels, shown_pixels = (w * h for w, h in (setup.pipeline.sizes.rendered, setup.pipeline.sizes.shown))
    return {
        **base,
        "latency_ms": case.latency_ms,  # of the whole way, with a proxy too
        **({"strategy": combination.strategy} if combination.strategy else {}),
        "frames": len(pictures),
        "client": client.name,
        "lacks": OUTSIDE_LACKS if combination.is_outside else lacking(combination.plan, client),
        "baseline": baselines().get(combination.warp, ""),
        "at_instants": {
            name: {str(frame): value for frame, value in at_instants(pictures, name).items()} for name in QUALITY
        },
        "blocks": {str(frame): blocks_text(blocks) for frame, blocks in measured.blocks.items()},
        "regions": pooled(regions[key] for key in measured.keys),
        "mismatch": reduce(add, measured.mismatch, Mismatch()).share,
        "passes": []
        if combination.is_outside
        else passes_of(combination.plan, rendered_pixels, shown_pixels, measured.stages, bytes_per_s),
    }


def flat(rows: Iterable[Mapping[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the rows under COLUMNS: medians and means without a suffix, the bad tail with _p95.

    The ends of a mean's interval have _low and _high.
    """
    for row in rows:
        yield {**_plain(row), **_times(row), **_regions(row), **ratings_of(row), **_passes(row)}


def about_rating(clip_s: float, rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return what a bench says of its JOD, nothing where it has none. rows: all of it."""
    if not clip_s:
        return []
    display = rows[0]["jod"]["display"]
    return [
        f"JOD by ColorVideoVDP, where {TRUTH_JOD:g} is like the truth: of clips of {clip_s:g} s that end at each "
        f"instant, before the lens, at {display['rate_hz']:g} Hz, {display['pixels_per_degree']:.1f} pixels per degree "
        f"and {display['peak_cd_m2']:g} cd/m2. Predicted from the pictures: no one was asked."
    ]


def _plain(row: Mapping[str, Any]) -> dict[str, Any]:
    machine = {key: row["machine"].get(key) for key in ("gl_renderer", "cpu_count", "host")}
    return {
        **{key: row.get(key, "") for key in _PLAIN},
        "width": row["size"][0],
        "height": row["size"][1],
        "mismatch": row["mismatch"],
        "client": row["client"],
        "lacks": row["lacks"],
        "baseline": row["baseline"],
        **machine,
    }


def _times(row: Mapping[str, Any]) -> dict[str, Any]:
    times: dict[str, Any] = {}
    for names, table, suffix, main in ((STAGES, "time_ms", "_ms", "median"), (QUALITY, "quality", "", "mean")):
        for name in names:
            entry = row[table][name]
            times |= {f"{name}{suffix}": entry[main], f"{name}{suffix}_p95": entry["p95"]}
            if entry.get("interval") is not None:
                times |= {f"{name}_low": entry["interval"][0], f"{name}_high": entry["interval"][1]}
    return times


def _regions(row: Mapping[str, Any]) -> dict[str, Any]:
    return {f"{region}_{figure}": row["regions"][region][figure] for region in REGIONS for figure in _REGION_FIGURES}


def _passes(row: Mapping[str, Any]) -> dict[str, Any]:
    return {f"{entry['name']}_pass_{figure}": entry[figure] for entry in row["passes"] for figure in _PASS_FIGURES}
