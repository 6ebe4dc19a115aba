"""The ladder of a run that chooses its warp by itself: from the figures of a benchmark, or of a short trial on the run's own frames."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import attrs

from .client.choice import Rung, ladder
from .errors import InputError
from .headsets import load_headset
from .options import RunOptions
from .report.schema import SCHEMA, summary_faults
from .rig import build_plan_for

Row = Mapping[str, Any]


@attrs.frozen
class Ladder:
    """The rungs, from cheapest to most accurate. notes: how they were found. machine: where, as in summary.json; None for here."""

    rungs: tuple[Rung, ...] = ()
    notes: tuple[str, ...] = ()
    machine: Mapping[str, Any] | None = None

    def notes_on(self, renderer: str, cpu_count: int) -> list[str]:
        """The notes of a run on this machine."""
        there = None if self.machine is None else (self.machine["gl_renderer"], self.machine["cpu_count"])
        if there is None or there == (renderer, cpu_count):
            return list(self.notes)
        told = f"The benchmark was run on {there[0]} with {there[1]} cores, this is {renderer} with {cpu_count}"
        return [*self.notes, f"{told}: its times hold here up to a common factor, which the run finds out by itself."]


def read_rows(path: Path) -> list[Row]:
    """The rows of a bench.json. Errors: InputError naming the file and what is wrong with it."""
    try:
        bench = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}; wanted the bench.json that hmdwarp bench wrote") from error
    except ValueError as error:
        raise InputError(f"{path}: no JSON ({error}); wanted the bench.json that hmdwarp bench wrote") from error
    if not isinstance(bench, dict) or not isinstance(bench.get("rows"), list):
        raise InputError(f"{path}: it has no list of 'rows'; wanted the bench.json that hmdwarp bench wrote")
    if bench.get("schema") != SCHEMA:
        raise InputError(f"{path}: its schema is {bench.get('schema')!r}, this program reads {SCHEMA}: run hmdwarp bench again")
    for number, row in enumerate(bench["rows"]):
        faults = summary_faults(row)
        if faults:
            raise InputError(f"{path}: row {number}: {'; '.join(faults)}")
    return bench["rows"]


def ladder_from_file(path: Path, options: RunOptions) -> Ladder:
    """The ladder of a benchmark for a run.

    Rows of the run's size are taken if there are any; else those of the largest size, their times in proportion to the pixels. What
    this run cannot have is left out, and told.
    Errors: InputError for a file that is no benchmark, and if nothing of it can be run.
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
    rungs, more = _at_size(usable, options.size or headset.eye_size_px, path.name)
    lenses = sorted({row["lens"] for row in usable} - {options.lens})
    if lenses:
        more.append(f"{path.name} was measured with lens {', '.join(lenses)}, this run has {options.lens}: its times are off by that.")
    return Ladder(rungs, (*notes, *more), usable[0]["machine"])


def _at_size(rows: list[Row], size: tuple[int, int], name: str) -> tuple[tuple[Rung, ...], list[str]]:
    same = [row for row in rows if tuple(row["size"]) == size]
    if same:
        return ladder(same), []
    width, height = max((row["size"] for row in rows), key=lambda s: s[0] * s[1])
    factor = size[0] * size[1] / (width * height)
    told = f"{name} was measured at {width}x{height}, this run is {size[0]}x{size[1]}"
    note = f"{told}: its times are taken in proportion to the pixels, {factor:.2g} times."
    return tuple(rung.scaled(factor) for rung in ladder(rows)), [note]
