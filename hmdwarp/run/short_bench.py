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
from ..headsets import Headset
from ..link import LinkOptions
from ..metrics import QualityPool, worker_count
from ..options import AUTO
from ..pipeline.auto.levels import best_within, levels_from
from ..pipeline.options import PipelineOptions
from ..pipeline.planning import build_plan_for
from ..pipeline.sizes import guarded_size, memory_bytes
from ..pipeline.source import Source
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


def decided(options: RunOptions, source: Source, say: Say = lambda text: None) -> tuple[RunOptions, LevelSet]:
    """Return the options with what `auto` stands for in them, and the origin of that with notes.

    The guard band becomes a number, and warp "auto" gets its levels. say: called with a sentence
    before a short bench starts.
    Errors: as settled; as levels_from_file; as set_up_replay; InputError if nothing fits the
    budget.
    """
    options, notes = settled(options, source.headset)
    if options.warp != AUTO:
        return options, LevelSet(notes=notes)
    if options.bench is None:
        found = levels_by_short_bench(options, source, say)
    else:
        found = levels_from_file(options.bench, options, lambda: lens_ms(options, source))
    best_within(found.levels, options.budget_ms)
    return attrs.evolve(options, levels=found.levels), attrs.evolve(found, notes=(*notes, *found.notes))


def candidates(options: PipelineOptions, source: Source) -> list[Combination]:
    """Return every warp and variant with each of FILLS, except those that this run cannot use.

    Errors: as build_plan_for.
    """
    headset, scene = source.headset, source.scene
    found = []
    build_plan_for(options.with_pair("none", "none"), headset, scene)
    for warp, fill in product(every_warp(), FILLS):
        try:
            pair = options.with_pair(warp, fill)
            found.append(Combination(warp, fill, build_plan_for(pair, headset, scene, shares_frames=True)))
        except PlanError:
            continue
    return found


def levels_by_short_bench(options: RunOptions, source: Source, say: Say) -> LevelSet:
    """Return the levels measured at a few instants of this run, at its size.

    Errors: as set_up_replay.
    """
    budget_ms, combinations = options.budget_ms or 0.0, candidates(options, source)
    say(
        f"trying {len(combinations)} combinations of warp and fill at {INSTANTS} instants of this run first; --bench "
        "FILE saves that"
    )
    times = dict(_first_times(options, source, [c for c in combinations if not c.plan.fills]))
    within = [warp for warp, ms in times.items() if ms <= REACH * budget_ms] or [min(times, key=times.__getitem__)]
    kept = [c for c in combinations if c.warp in within]
    levels = levels_from(_rows(options, source, kept))
    note = f"Warp 'auto' tried {len(kept)} combinations of warp and fill at {INSTANTS} instants of this run"
    left_out = sorted(set(times) - set(within))
    if left_out:
        note += (
            f"; {', '.join(left_out)} took more than {REACH:g} times the budget, so their pictures were not measured"
        )
    return LevelSet(levels, (f"{note}.",))


def lens_ms(options: RunOptions, source: Source) -> float:
    """Return the time of the run's lens pass for one eye on this machine."""
    alone = Combination("none", "none", build_plan_for(options.with_pair("none", "none"), source.headset, None))
    with _frames_for([alone], options, source) as setup:
        (stages,) = _stages(setup, [alone], INSTANTS * ROUNDS)
    return median([milliseconds for name, milliseconds in stages if name == "lens"])


def _frames_for(combinations: Sequence[Combination], options: RunOptions, source: Source) -> ReplaySetup:
    """Return a set-up of the run, with the cheapest warp, whose frames suit the combinations.

    Its network only delays, so that frames_used knows which frames are shown.
    """
    network = LinkOptions(server_rate_hz=options.network.server_rate_hz)
    alone = attrs.evolve(options.with_pair("none", "none"), lens="none", against="", network=network)
    return set_up_replay(alone, needs_of(c.plan for c in combinations), source=source)


def _first_times(
    options: RunOptions, source: Source, combinations: Sequence[Combination]
) -> Iterator[tuple[str, float]]:
    """Yield (warp, ms per eye) from one timed run in the middle of the replay, after a warm-up."""
    for batch in _batches(options, source.headset, combinations):
        with _frames_for(batch, options, source) as setup:
            for combination, stages in zip(batch, _stages(setup, batch, 1), strict=True):
                yield combination.warp, sum(milliseconds for _, milliseconds in stages) / 2


def _stages(setup: ReplaySetup, combinations: Sequence[Combination], rounds: int) -> Iterator[list[tuple[str, float]]]:
    """Yield the stage times of so many runs of both eyes by each combination, after one warm-up."""
    (_, refresh), *_ = refreshes(setup, setup.run.needs, set(instants_of(setup.schedule.count, 1)))
    for combination in combinations:
        compensator, inputs = setup.compensator(combination.plan), setup.loop.inputs(refresh, combination.plan.needs)
        found: list[tuple[str, float]] = []
        for round_ in range(rounds + 1):
            for eye_inputs in inputs:
                compensator.run(eye_inputs)
            stages = setup.gpu.timer.collect()
            found += stages if round_ else []
        yield found


def _rows(options: RunOptions, source: Source, combinations: Sequence[Combination]) -> Iterator[dict[str, Any]]:
    """Yield the keys of a bench.json row that levels_from reads, for each combination."""
    headset, size = source.headset, options.size or source.headset.eye_size_px
    case = Case(options.scene, options.trace, options.latency_ms, size)
    with QualityPool(worker_count(options.workers), headset.left_fov.pixels_per_degree(size)) as pool:
        for batch in _batches(options, headset, combinations):
            with _frames_for(batch, options, source) as setup:
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
