"""Quality levels for warp "auto", from the figures of a benchmark."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import attrs

from ..errors import InputError
from ..headsets import Headset, load_headset
from ..pipeline.bench_file import read_rows
from ..pipeline.levels import QualityLevel, levels_from
from ..pipeline.options import PipelineOptions
from ..pipeline.planning import build_plan_for

Row = Mapping[str, Any]
LensTime = Callable[[], float]


@attrs.frozen
class LevelSet:
    """Quality levels and their origin."""

    # From cheapest to most accurate.
    levels: tuple[QualityLevel, ...] = ()
    # How they were obtained.
    notes: tuple[str, ...] = ()
    # The machine that measured them, as in summary.json; None for this one.
    machine: Mapping[str, Any] | None = None

    def notes_on(self, renderer: str, cpu_count: int) -> list[str]:
        """Return the notes to show when running on this machine."""
        there = None if self.machine is None else (self.machine["gl_renderer"], self.machine["cpu_count"])
        if there is None or there == (renderer, cpu_count):
            return list(self.notes)
        where = f"The benchmark was run on {there[0]} with {there[1]} cores, this is {renderer} with {cpu_count}"
        return [*self.notes, f"{where}: its times hold here up to a common factor, which the run finds out by itself."]


def levels_from_file(path: Path, options: PipelineOptions, lens_ms: LensTime | None) -> LevelSet:
    """Return the levels of a benchmark for a run.

    Uses the rows of the run's size if there are any; otherwise those of the largest size, with
    times scaled by the number of pixels. If they were measured with another lens, the time of the
    run's lens replaces theirs; lens_ms measures it here (None: leave it out). Combinations that
    this run cannot use are left out, with a note.
    Errors: InputError for a file that is no benchmark, and if none of its combinations can run.
    """
    headset = load_headset(options.headset)
    build_plan_for(options.with_pair("none", "none"), headset, None)
    rows, notes, usable = read_rows(path), [], []
    for warp, fill in sorted({(row["warp"], row["fill"]) for row in rows}):
        try:
            build_plan_for(options.with_pair(warp, fill), headset, None)
            usable += [row for row in rows if (row["warp"], row["fill"]) == (warp, fill)]
        except InputError as error:
            notes.append(f"{path.name}: warp '{warp}' with fill '{fill}' is left out: {error}.")
    if not usable:
        raise InputError(f"{path}: nothing of its {len(rows)} rows can be run here{'; ' + notes[0] if notes else ''}")
    return _fitted(
        usable,
        options,
        headset,
        lens_ms,
        [*notes, *_other_terms(usable, options, options.size or headset.eye_size_px, path.name)],
        path.name,
    )


def _fitted(
    rows: list[Row], options: PipelineOptions, headset: Headset, lens_ms: LensTime | None, notes: list[str], name: str
) -> LevelSet:
    other = {row["lens"] for row in rows} - {options.lens}
    try:
        levels, more = _at_size(
            [_without_lens(row) for row in rows] if other else rows, options.size or headset.eye_size_px, name
        )
    except InputError as error:
        raise InputError(f"{name}: {error}") from error
    if other:
        added = 0.0 if options.lens == "none" or lens_ms is None else lens_ms()
        levels = tuple(attrs.evolve(level, total_ms=level.total_ms + added) for level in levels)
        counts = f"with {added:.2f} ms" if lens_ms else "which a run times first: these are without it"
        more.append(
            f"{name} was measured with lens {', '.join(sorted(other))}: lens {options.lens} counts instead, {counts}."
        )
    return LevelSet(levels, (*notes, *more), rows[0]["machine"])


def _without_lens(row: Row) -> Row:
    times = row["time_ms"]
    median = times["total"]["median"]
    total = {"median": None if median is None else median - (times["lens"]["median"] or 0.0), "p95": None}
    return {**row, "lens": "none", "time_ms": {**times, "total": total}}


def _other_terms(rows: list[Row], options: PipelineOptions, size: tuple[int, int], name: str) -> list[str]:
    """Return notes on differences between the benchmark and this run that are not corrected for."""
    differing = []
    for key, mine, unit in (
        ("guard", options.guard_band.factors(size).entry, ""),
        ("latency_ms", options.latency_ms, " ms"),
        ("scene", options.scene, ""),
    ):
        theirs = list(dict.fromkeys(row[key] for row in rows if key in row))
        if theirs and mine not in theirs:
            differing.append(
                f"{key.removesuffix('_ms')} {', '.join(str(value) for value in theirs)}{unit} (this run: {mine}{unit})"
            )
    return [f"{name} was measured with {'; '.join(differing)}."] if differing else []


def _at_size(rows: list[Row], size: tuple[int, int], name: str) -> tuple[tuple[QualityLevel, ...], list[str]]:
    same = [row for row in rows if tuple(row["size"]) == size]
    if same:
        return levels_from(same), []
    width, height = max((row["size"] for row in rows), key=lambda s: s[0] * s[1])
    factor = size[0] * size[1] / (width * height)
    terms = f"{name} was measured at {width}x{height}, this run is {size[0]}x{size[1]}"
    note = f"{terms}: its times are taken in proportion to the pixels, {factor:.2g} times."
    return tuple(level.scaled(factor) for level in levels_from(rows)), [note]
