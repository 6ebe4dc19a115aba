"""Quality levels for warp "auto", from a benchmark file or a short bench on the run's frames."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from statistics import fmean, median
from typing import Any

import attrs

from ..client.plan import needs_of
from ..client.variants import every_warp
from ..errors import PlanError
from ..headsets import Headset, load_headset
from ..link import LinkOptions
from ..metrics import QualityPool, worker_count
from ..options import AUTO
from ..pipeline.auto.levels import best_within, levels_from
from ..pipeline.options import PipelineOptions
from ..pipeline.planning import build_plan_for
from ..pipeline.sizes import guarded_size, memory_bytes
from ..scenes import load_scene
from .bench_levels import LevelSet, levels_from_file
from .combination_bench import Comparison, Measured
from .combinations import GPU_BATCH_BYTES, MEMORY_PART, Case, Combination, batches, instants_of
from .guard import settled
from .options import RunOptions
from .replay_setup import ReplaySetup, set_up_replay
from .side_by_side import refreshes

INSTANTS, ROUNDS = 3, 2  # instants, evenly spread over the run; timed runs of both eyes at each
# Every fill with every warp would be over a hundred pictures per instant, and some fills depend on
# earlier refreshes, which a few instants cannot show. These differ most in cost and quality; use
# --bench FILE for others.
FILLS = ("none", "interpolate", "pyramid")
# A warp beyond twice the budget would need a machine twice as fast: its picture is not measured.
REACH = 2.0
Say = Callable[[str], None]


def decided(options: RunOptions, say: Say = lambda text: None) -> tuple[RunOptions, LevelSet]:
    """Return the options with what `auto` stands for in them, and the origin of that with notes.

    The guard band becomes a number, and warp "auto" gets its levels. say: called with a sentence
    before a short bench starts.
    Errors: as settled; as levels_from_file; as set_up_replay; InputError if nothing fits the
    budget.
    """
    options, notes = settled(options)
    if options.warp != AUTO:
        return options, LevelSet(notes=notes)
    if options.bench is None:
        found = levels_by_short_bench(options, say)
    else:
        found = levels_from_file(options.bench, options, lambda: lens_ms(options))
    best_within(found.levels, options.budget_ms)
    return attrs.evolve(options, levels=found.levels), attrs.evolve(found, notes=(*notes, *found.notes))


def candidates(options: PipelineOptions) -> list[Combination]:
    """Return every warp and variant with each of FILLS, except those that this run cannot use.

    Errors: as build_plan_for.
    """
    headset, scene = load_headset(options.headset), load_scene(options.scene, options.scene_options)
    found = []
    build_plan_for(options.with_pair("none", "none"), headset, scene)
    for warp, fill in product(every_warp(), FILLS):
        try:
            pair = options.with_pair(warp, fill)
            found.append(Combination(warp, fill, build_plan_for(pair, headset, scene, shares_frames=True)))
        except PlanError:
            continue
    return found


def levels_by_short_bench(options: RunOptions, say: Say) -> LevelSet:
    """Return the levels measured at a few instants of this run, at its size.

    Errors: as set_up_replay.
    """
    headset, budget_ms = load_headset(options.headset), options.budget_ms or 0.0
    combinations = candidates(options)
    say(
        f"trying {len(combinations)} combinations of warp and fill at {INSTANTS} instants of this run first; --bench "
        "FILE saves that"
    )
    times = dict(_first_times(options, headset, [c for c in combinations if not c.plan.fills]))
    within = [warp for warp, ms in times.items() if ms <= REACH * budget_ms] or [min(times, key=times.__getitem__)]
    kept = [c for c in combinations if c.warp in within]
    levels = levels_from(_rows(options, headset, kept))
    note = f"Warp 'auto' tried {len(kept)} combinations of warp and fill at {INSTANTS} instants of this run"
    left_out = sorted(set(times) - set(within))
    if left_out:
        note += (
            f"; {', '.join(left_out)} took more than {REACH:g} times the budget, so their pictures were not measured"
        )
    return LevelSet(levels, (f"{note}.",))


def lens_ms(options: RunOptions) -> float:
    """Return the time of the run's lens pass for one eye on this machine."""
    headset = load_headset(options.headset)
    plan = build_plan_for(options.with_pair("none", "none"), headset, None)
    with set_up_replay(_beside(options)) as setup:
        (stages,) = _stages(setup, [Combination("none", "none", plan)], INSTANTS * ROUNDS)
    return median([milliseconds for name, milliseconds in stages if name == "lens"])


def _beside(options: RunOptions) -> RunOptions:
    """Return the run whose frames are used, with the cheapest warp of its own.

    Its network only delays, so that frames_used knows which frames are shown.
    """
    network = LinkOptions(server_rate_hz=options.network.server_rate_hz)
    return attrs.evolve(options.with_pair("none", "none"), lens="none", against="", network=network)


def _first_times(
    options: RunOptions, headset: Headset, combinations: Sequence[Combination]
) -> Iterator[tuple[str, float]]:
    """Yield (warp, ms per eye) from one timed run in the middle of the replay, after a warm-up."""
    for batch in _batches(options, headset, combinations):
        with set_up_replay(_beside(options), needs_of(c.plan for c in batch)) as setup:
            for combination, stages in zip(batch, _stages(setup, batch, 1), strict=True):
                yield combination.warp, sum(milliseconds for _, milliseconds in stages) / 2


def _stages(setup: ReplaySetup, combinations: Sequence[Combination], rounds: int) -> Iterator[list[tuple[str, float]]]:
    """Yield the stage times of so many runs of both eyes by each combination, after one warm-up."""
    needs = needs_of(c.plan for c in combinations)
    (_, refresh), *_ = refreshes(setup, needs, set(instants_of(setup.schedule.count, 1)))
    for combination in combinations:
        compensator, inputs = setup.compensator(combination.plan), setup.loop.inputs(refresh, combination.plan.needs)
        found: list[tuple[str, float]] = []
        for round_ in range(rounds + 1):
            for eye_inputs in inputs:
                compensator.run(eye_inputs)
            stages = setup.gpu.timer.collect()
            found += stages if round_ else []
        yield found


def _rows(options: RunOptions, headset: Headset, combinations: Sequence[Combination]) -> Iterator[dict[str, Any]]:
    """Yield the keys of a bench.json row that levels_from reads, for each combination."""
    size = options.size or headset.eye_size_px
    case = Case(options.scene, options.trace, options.latency_ms, size)
    with QualityPool(worker_count(options.workers), headset.left_fov.pixels_per_degree(size)) as pool:
        for batch in _batches(options, headset, combinations):
            with set_up_replay(_beside(options), needs_of(c.plan for c in batch)) as setup:
                comparison = Comparison(setup, case, batch, pool, ROUNDS)
                comparison.run(INSTANTS, lambda: None)
            pool.wait()
            yield from (_row(measured, pool, size) for measured in comparison.measured)


def _row(measured: Measured, pool: QualityPool, size: tuple[int, int]) -> dict[str, Any]:
    figures = [pool.results[key] for key in measured.keys]
    return {
        "warp": measured.combination.warp,
        "fill": measured.combination.fill,
        "size": size,
        "time_ms": {"total": {"median": median(row["total_ms"] for row in measured.times)}},
        "quality": {name: {"mean": fmean(figure[name] or 0.0 for figure in figures)} for name in ("flip", "psnr_db")},
    }


def _batches(options: RunOptions, headset: Headset, combinations: Sequence[Combination]) -> list[list[Combination]]:
    size = options.size or headset.eye_size_px
    most = min(GPU_BATCH_BYTES, MEMORY_PART * memory_bytes())
    return batches(combinations, guarded_size(options.guard_band, headset, size), size, most)
