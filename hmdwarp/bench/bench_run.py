"""One bench: every combination of its options, on the loop that every other driver uses."""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import attrs

from ..auto.levels import choose
from ..client.plan import build_plan, needs_of
from ..clients import Client, load_client
from ..errors import InputError
from ..frames import Needs
from ..gpu.context import Gpu
from ..gpu.memory_bandwidth import Bandwidth, ClockCheck, check_clocks, copy_bandwidth
from ..headsets import Headset, load_headset
from ..metrics import QualityPool, worker_count
from ..pipeline.build import check_held
from ..pipeline.options import PipelineOptions
from ..pipeline.planning import build_plan_for
from ..pipeline.recorded_scene import display_of, recorded_scene
from ..pipeline.sizes import eye_sizes, guarded_size, memory_bytes
from ..poses import load_trace
from ..report import SCHEMA, OutputFolder
from ..run.combination_bench import Comparison
from ..run.combinations import GPU_BATCH_BYTES, MEMORY_PART, Case, Combination, batches, instants_of
from ..run.options import RunOptions
from ..run.recorded_frames import about, own_trace
from ..run.replay_setup import schedule_for, set_up_replay
from ..run.run_summary import machine_of
from ..scenes import load_scene
from ..sequences import Sequence
from ..sequences import open as open_sequence
from ..version import __version__
from . import displacement_grid, fused
from .bench_rows import COLUMNS, flat, row_of
from .cases import cases_of, combinations_of, common_start_s, outside_notes, run_options
from .client_notes import left_out_notes
from .options import DEFAULT_SIZES, BenchOptions

OWNED = ("bench.csv", "bench.html")
Progress = Callable[[int, int], None]


@attrs.frozen(eq=False)
class BenchResult:
    """The results of a bench."""

    folder: Path
    # As in bench.json.
    data: dict[str, Any]
    # Why no combination fits the budget, else "".
    refused: str = ""

    @property
    def report(self) -> Path:
        """The page."""
        return self.folder / "bench.html"


@attrs.frozen(eq=False)
class _Work:
    """A case with its run's options and the number of its measured instants."""

    case: Case
    run: Any
    combinations: list[Combination]
    instants: int


class _Steps:
    """A counter of finished steps for the caller's progress."""

    def __init__(self, total: int, progress: Progress) -> None:
        self._done, self._total, self._progress = 0, total, progress
        progress(0, total)

    def __call__(self) -> None:
        self._done += 1
        self._progress(self._done, self._total)


def bench(options: BenchOptions, progress: Progress = lambda done, total: None) -> BenchResult:
    """Run a bench and write bench.csv, bench.json and bench.html into options.out.

    If it fails or is interrupted, partial output is removed.

    All that was asked for is checked before anything runs. progress(done, total) is called after
    each measured refresh.
    Errors: InputError and its kin for what was asked, MachineError for what the machine lacks.
    """
    started = time.perf_counter()
    sequence = None if options.frames is None else open_sequence(options.frames, options.sequence_options)
    headset = load_headset(options.headset) if sequence is None else display_of(sequence)
    client = load_client(options.client)
    if sequence is not None:
        sizes = options.sizes if options.sizes != DEFAULT_SIZES else (headset.eye_size_px,)
        options = attrs.evolve(options, scenes=(sequence.name,), recordings=("",), sizes=sizes)
    works, notes = _checked(options, headset, sequence)
    with OutputFolder(options.out, owned=OWNED, last="bench.json", force=options.force) as out:
        machine, bandwidth, clocks, batched = _examined(options, headset, works)
        steps = _Steps(_total(options, headset, works, batched), progress)
        rows: list[dict[str, Any]] = []
        for size, group in itertools.groupby(works, key=lambda work: work.case.size):
            with _pool(options, headset, size) as pool:
                for work in group:
                    rows += _case_rows(options, work, batched[work.case], pool, bandwidth, client, steps)
        first = works[0]
        has_grid, has_fused = (wanted and bool(_warped(first)) for wanted in _sections(options, headset))
        data = {
            "schema": SCHEMA,
            "hmdwarp": __version__,
            "command": options.command,
            "machine": machine,
            "clock": clocks.clock,
            "clocks": {"wall_ms": clocks.wall_ms, "gpu_ms": clocks.gpu_ms, "note": clocks.note},
            "copy_gb_s": bandwidth.bytes_per_s * 1e-9,
            "client": client.name,
            "notes": [*notes, *left_out_notes(rows, client)],
            "rows": rows,
            "grid": _grid(options, headset, first, steps) if has_grid else [],
            "grid_at": {"scene": rows[0]["scene"], "size": list(displacement_grid.SIZE), "eye": "left"}
            if has_grid
            else None,
            "fused": _fused(options, headset, first, steps) if has_fused else [],
            "fused_at": _fused_at(options, rows[0]) if has_fused else None,
            "choice": None,
        }
        data["choice"], refused = _choice(
            [row for row in rows if not row["lacks"] and not row.get("strategy")], options.budget_ms
        )
        data["seconds"] = time.perf_counter() - started
        _write(out, data)
    return BenchResult(options.out, data, refused)


def _checked(
    options: BenchOptions, headset: Headset, sequence: Sequence | None = None
) -> tuple[list[_Work], list[str]]:
    """Check everything that needs no GPU; return the work, and notes on the scenes.

    Errors: InputError and its kin.
    """
    rate_hz = options.rate_hz or headset.refresh_hz
    combinations_of(options, None)  # names, before any scene is built
    combinations, called, notes = {}, {}, outside_notes(options)
    for name in options.scenes:
        scene = load_scene(name, options.scene_options) if sequence is None else recorded_scene(sequence)
        build_plan_for(
            run_options(options, Case(name, options.recordings[0], 0.0, options.sizes[0]), lens=options.lens),
            headset,
            scene,
        )
        combinations[name], called[name] = combinations_of(options, scene), scene.name
        notes += scene.notes
    _refuse_one_name("scenes", called)
    traces = (
        {recording: load_trace(recording, options.trace_options) for recording in options.recordings}
        if sequence is None
        else {"": own_trace(sequence)}
    )
    _refuse_one_name(
        "recordings", {recording: trace.track.name or trace.path.stem for recording, trace in traces.items()}
    )
    starts = {recording: common_start_s(options, trace.track, rate_hz) for recording, trace in traces.items()}
    works = []
    for case in cases_of(options):
        guarded_size(options.guard_band, headset, case.size)
        run = run_options(options, case, start_s=starts[case.recording])
        count = schedule_for(run, sequence, traces[case.recording], rate_hz).count
        works.append(_Work(case, run, combinations[case.scene], len(instants_of(count, options.instants))))
    notes += [] if sequence is None else [about(sequence, works[0].run)]
    return works, notes


def _refuse_one_name(kind: str, called: Mapping[str, str]) -> None:
    """Raise InputError if two share a name: rows, tables and charts distinguish cases by it.

    called: name by option.
    """
    found: dict[str, str] = {}
    for asked, name in called.items():
        first = found.setdefault(name, asked)
        if first != asked:
            raise InputError(
                f"{kind} '{first}' and '{asked}' are both called '{name}': leave one out, or rename a file"
            )


def _examined(
    options: BenchOptions, headset: Headset, works: list[_Work]
) -> tuple[dict[str, Any], Bandwidth, ClockCheck, dict[Case, list[list[Combination]]]]:
    """Return the machine, its bandwidth and clocks, and the combinations that fit together."""
    with Gpu() as gpu:
        machine = machine_of(gpu)
        most = MEMORY_PART * memory_bytes() if gpu.is_software else GPU_BATCH_BYTES
        batched = {
            work.case: batches(
                work.combinations, guarded_size(options.guard_band, headset, work.case.size), work.case.size, most
            )
            for work in works
        }
        for work in works:
            for batch in batched[work.case]:
                _check_room(gpu, work.run, headset, needs_of(c.plan for c in batch))
        return machine, copy_bandwidth(gpu), check_clocks(gpu), batched


def _check_room(gpu: Gpu, run: PipelineOptions, headset: Headset, needs: Needs) -> None:
    sizes = eye_sizes(run.guard_band, headset, run.size or headset.eye_size_px)
    check_held(gpu, run, needs, sizes, run.rate_hz or headset.refresh_hz)


def _total(
    options: BenchOptions, headset: Headset, works: list[_Work], batched: dict[Case, list[list[Combination]]]
) -> int:
    count = sum(work.instants * len(batched[work.case]) for work in works)
    if not _warped(works[0]):
        return count
    has_grid, has_fused = _sections(options, headset)
    count += len(displacement_grid.offsets()) + 1 if has_grid else 0
    return count + (min(fused.INSTANTS, works[0].instants) if has_fused else 0)


def _sections(options: BenchOptions, headset: Headset) -> tuple[bool, bool]:
    """Return whether warps are compared over displacements, and fused with the lens."""
    return options.grid, options.fused and headset.lens is not None


def _pool(options: BenchOptions, headset: Headset, size: tuple[int, int]) -> QualityPool:
    return QualityPool(worker_count(options.workers), headset.left_fov.pixels_per_degree(size))


def _case_rows(
    options: BenchOptions,
    work: _Work,
    batched: list[list[Combination]],
    pool: QualityPool,
    bandwidth: Bandwidth,
    client: Client,
    steps: _Steps,
) -> Iterator[dict[str, Any]]:
    for batch in batched:
        with set_up_replay(work.run, needs_of(c.plan for c in batch)) as setup:
            comparison = Comparison(setup, work.case, batch, pool, options.rounds)
            comparison.run(options.instants, steps)
            pool.wait()
            yield from (row_of(setup, each, pool, bandwidth.bytes_per_s, client) for each in comparison.measured)


def _grid(options: BenchOptions, headset: Headset, work: _Work, steps: _Steps) -> list[dict[str, Any]]:
    done = {c.warp: c.plan.effects for c in _warped(work)}
    unfilled = [
        Combination(warp, "none", build_plan(effects, warp, "none", "none", client_geometry=True, named=effects))
        for warp, effects in done.items()
    ]
    with (
        _pool(options, headset, displacement_grid.SIZE) as pool,
        set_up_replay(
            _at_size(work.run, work.case.size, displacement_grid.SIZE), needs_of(c.plan for c in unfilled)
        ) as setup,
    ):
        return displacement_grid.grid_rows(setup, unfilled, pool, steps)


def _warped(work: _Work) -> list[Combination]:
    """Return the combinations that compare warps with each other."""
    return [c for c in work.combinations if not c.is_outside and not c.strategy]


def _at_size(run: RunOptions, shown: tuple[int, int], size: tuple[int, int]) -> RunOptions:
    """Return the run at another size, with the same field of view."""
    guard = run.guard_band.factors(shown)
    return attrs.evolve(run, size=size, guard=(guard.x, guard.y), rendered_size=None)


def _fused(options: BenchOptions, headset: Headset, work: _Work, steps: _Steps) -> list[dict[str, Any]]:
    with (
        _pool(options, headset, work.case.size) as pool,
        set_up_replay(work.run, needs_of(c.plan for c in work.combinations)) as setup,
    ):
        warps = list(dict.fromkeys(c.warp for c in _warped(work)))
        return fused.fused_rows(setup, options, warps, _fused_lens(options), pool, work.instants, options.rounds, steps)


def _fused_lens(options: BenchOptions) -> str:
    return options.lens if options.lens != "none" else "radial"


def _fused_at(options: BenchOptions, row: Mapping[str, Any]) -> dict[str, Any]:
    """Return the setting of the fused rows; row: any of the first case."""
    return {
        **{key: row[key] for key in ("scene", "trace", "latency_ms", "size")},
        "lens": _fused_lens(options),
        "eye": "left",
    }


def _choice(rows: list[dict[str, Any]], budget_ms: float | None) -> tuple[dict[str, Any] | None, str]:
    """Return the choice for the budget, or why there is none: too small a one discards no run."""
    if budget_ms is None:
        return None, ""
    try:
        return choose(rows, budget_ms), ""
    except InputError as error:
        return None, str(error)


def _write(out: OutputFolder, data: dict[str, Any]) -> None:
    from ..report.bench import render_bench_page

    out.write_csv("bench.csv", flat(data["rows"]), COLUMNS)
    out.write_text("bench.html", render_bench_page(data))
    out.write_json("bench.json", data)
