"""What a run that chooses its warp by itself chooses from: a benchmark's figures, or those of a short bench on the run's own frames."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import product
from statistics import fmean, median
from typing import Any

import attrs

from ..auto.levels import best_within, ladder
from ..bench.cases import GPU_BATCH_BYTES, MEMORY_PART, Case, Combination, batches, instants_of
from ..bench.casework import Casework, Measured, refreshes
from ..client.plan import needs_of
from ..client.variants import every_warp
from ..errors import PlanError
from ..headsets import Headset, load_headset
from ..metrics import QualityPool, worker_count
from ..pipeline.options import AUTO, PipelineOptions, RunOptions
from ..pipeline.planning import build_plan_for
from ..pipeline.sizes import guarded_size, memory_bytes
from ..scenes import load_scene
from .bench_levels import Ladder, ladder_from_file
from .rig import Rig, build_rig

INSTANTS, ROUNDS = 3, 2  # of the run, evenly spread; timed runs of both eyes at each
# Every fill with every warp would be a hundred and more pictures at each instant, and some fills live on what they saw before, which a
# few instants cannot show. These differ most in what they cost and give; others come in by --bench FILE.
FILLS = ("none", "interpolate", "pyramid")
# Beyond twice the budget a warp is out of reach until the machine becomes twice as fast: its picture is not measured.
REACH = 2.0
Say = Callable[[str], None]


def ladder_for(options: RunOptions, say: Say = lambda text: None) -> Ladder:
    """What warp "auto" chooses from; an empty ladder for any other warp. say: gets a sentence before a trial starts.

    Errors: as ladder_from_file; as build_rig; InputError if nothing fits the budget.
    """
    if options.warp != AUTO:
        return Ladder()
    found = tried(options, say) if options.bench is None else ladder_from_file(options.bench, options, lens_ms)
    best_within(found.levels, options.budget_ms)
    return found


def candidates(options: PipelineOptions) -> list[Combination]:
    """Every warp and variant with each of FILLS, but for those this run cannot have. Errors: as build_plan_for."""
    headset, scene = load_headset(options.headset), load_scene(options.scene)
    found = []
    build_plan_for(options.with_pair("none", "none"), headset, scene)
    for warp, fill in product(every_warp(), FILLS):
        try:
            found.append(Combination(warp, fill, build_plan_for(options.with_pair(warp, fill), headset, scene)))
        except PlanError:
            continue
    return found


def tried(options: RunOptions, say: Say) -> Ladder:
    """The ladder of what a short bench finds at a few instants of this run, at its size. Errors: as build_rig."""
    headset = load_headset(options.headset)
    combinations = candidates(options)
    say(
        f"trying {len(combinations)} combinations of warp and fill at {INSTANTS} instants of this run first; --bench FILE saves that"
    )
    took = dict(_first_times(options, headset, [c for c in combinations if not c.plan.fills]))
    within = [warp for warp, ms in took.items() if ms <= REACH * options.budget_ms] or [min(took, key=took.__getitem__)]
    kept = [c for c in combinations if c.warp in within]
    levels = ladder(_rows(options, headset, kept))
    told = f"Warp 'auto' tried {len(kept)} combinations of warp and fill at {INSTANTS} instants of this run"
    left_out = sorted(set(took) - set(within))
    if left_out:
        told += (
            f"; {', '.join(left_out)} took more than {REACH:g} times the budget, so their pictures were not measured"
        )
    return Ladder(levels, (f"{told}.",))


def lens_ms(options: RunOptions) -> float:
    """What the lens of a run takes for one eye on this machine."""
    headset = load_headset(options.headset)
    plan = build_plan_for(options.with_pair("none", "none"), headset, None)
    with build_rig(_beside(options)) as rig:
        (stages,) = _stages(rig, [Combination("none", "none", plan)], INSTANTS * ROUNDS)
    return median([milliseconds for name, milliseconds in stages if name == "lens"])


def _beside(options: RunOptions) -> RunOptions:
    """The run whose frames are used; its own warp does as little as possible."""
    return attrs.evolve(options.with_pair("none", "none"), lens="none", against="")


def _first_times(
    options: RunOptions, headset: Headset, combinations: Sequence[Combination]
) -> Iterator[tuple[str, float]]:
    """(warp, ms per eye) from one timed run of both eyes in the middle of the run, after one to warm up."""
    for batch in _batches(options, headset, combinations):
        with build_rig(_beside(options), needs_of(c.plan for c in batch)) as rig:
            for combination, stages in zip(batch, _stages(rig, batch, 1), strict=True):
                yield combination.warp, sum(milliseconds for _, milliseconds in stages) / 2


def _stages(rig: Rig, combinations: Sequence[Combination], rounds: int) -> Iterator[list[tuple[str, float]]]:
    """The stages of so many runs of both eyes by each combination, after one to warm up."""
    needs = needs_of(c.plan for c in combinations)
    (_, refresh), *_ = refreshes(rig, needs, set(instants_of(rig.timetable.count, 1)))
    for combination in combinations:
        compensator, inputs = rig.compensator(combination.plan), rig.loop.inputs(refresh, combination.plan.needs)
        found: list[tuple[str, float]] = []
        for round_ in range(rounds + 1):
            for one in inputs:
                compensator.run(one)
            stages = rig.gpu.timer.collect()
            found += stages if round_ else []
        yield found


def _rows(options: RunOptions, headset: Headset, combinations: Sequence[Combination]) -> Iterator[dict[str, Any]]:
    """What choice.ladder reads of a row of bench.json, for each combination."""
    size = options.size or headset.eye_size_px
    case = Case(options.scene, options.trace, options.latency_ms, size)
    with QualityPool(worker_count(options.workers), headset.left_fov.pixels_per_degree(size)) as pool:
        for batch in _batches(options, headset, combinations):
            with build_rig(_beside(options), needs_of(c.plan for c in batch)) as rig:
                casework = Casework(rig, case, batch, pool, ROUNDS)
                casework.run(INSTANTS, lambda: None)
            pool.wait()
            yield from (_row(measured, pool, size) for measured in casework.measured)


def _row(measured: Measured, pool: QualityPool, size: tuple[int, int]) -> dict[str, Any]:
    figures = [pool.results[key] for key in measured.keys]
    return {
        "warp": measured.combination.warp,
        "fill": measured.combination.fill,
        "size": size,
        "time_ms": {"total": {"median": median(row["total_ms"] for row in measured.times)}},
        "quality": {name: {"mean": fmean(figure[name] for figure in figures)} for name in ("flip", "psnr_db")},
    }


def _batches(options: RunOptions, headset: Headset, combinations: Sequence[Combination]) -> list[list[Combination]]:
    size = options.size or headset.eye_size_px
    most = min(GPU_BATCH_BYTES, MEMORY_PART * memory_bytes())
    return batches(combinations, guarded_size(options.guard, headset, size), size, most)
