"""Quality levels for warp "auto", from a benchmark file or a short bench on the run's frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from statistics import fmean, median
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..client.plan import needs_of
from ..client.variants import every_warp
from ..errors import PlanError
from ..geometry import Fov, Pose
from ..headsets import Headset
from ..link import LinkOptions
from ..metrics import MeasuringProcesses, QualityPool, worker_count
from ..options import AUTO
from ..pipeline.levels import best_within, levels_from
from ..pipeline.options import PipelineOptions
from ..pipeline.planning import build_plan_for
from ..pipeline.sizes import expected_age_ns, guarded_size
from ..pipeline.source import Source
from ..platforms import memory_bytes
from ..poses import PoseSample, PoseTrack, load_trace
from ..poses.prediction import predict
from ..poses.quaternions import conjugate, rotate
from .bench_levels import LevelSet, levels_from_file
from .combinations import GPU_BATCH_BYTES, MEMORY_PART, Case, Combination, batches, instants_of
from .options import RunOptions
from .replay_setup import ReplaySetup, set_up_replay
from .setup import Schedule, schedule_of
from .side_by_side import Comparison, Measured, refreshes

QUANTILE = 0.95
# A guard of 2 has four times the pixels; a second wide view (`--wide`) costs half a picture and
# reaches farther.
MOST = 2.0
NEAR_M = 1.0  # nearest surface considered; nearer ones enter the view from farther in
MOST_INSTANTS = 2000
_STEP = 100  # factors are rounded up to a hundredth

Array = NDArray[np.float64]


@attrs.frozen
class Guard:
    """The chosen guard band.

    factor: to draw with. wanted: the quantile over the refreshes; infinite where the head turns a
    side behind the eye.
    """

    factor: float
    wanted: float

    def __str__(self) -> str:
        flat = math.isfinite(self.wanted)
        needed = (
            f"a picture {self.wanted:.2f} times as large in tangents" if flat else "more than any flat picture holds"
        )
        told = f"Guard auto: to lose nothing at {QUANTILE:.0%} of the refreshes takes {needed}"
        if self.wanted <= MOST:
            return f"{told}; {self.factor:g} is drawn."
        return f"{told}; {MOST:g} is drawn, auto's most. A second wide view (--wide) reaches farther and costs less."


def settled(options: RunOptions, headset: Headset) -> tuple[RunOptions, tuple[str, ...]]:
    """Return the options with a number in place of guard `auto`, and notes on it.

    Errors: as load_trace and schedule_of.
    """
    if options.guard != AUTO:
        return options, ()
    track = load_trace(options.trace, options.trace_options).track
    schedule = schedule_of(track, options, options.rate_hz or headset.refresh_hz)
    found = guard_for(headset, track, schedule, options)
    return attrs.evolve(options, guard=found.factor), (str(found),)


def guard_for(headset: Headset, track: PoseTrack, schedule: Schedule, options: RunOptions) -> Guard:
    """Return the factor that holds the middles of the pictures' sides in 95 of 100 refreshes.

    All four sides of both eyes count, for scenery from 1 m to infinity. The server draws for its
    predicted or current pose, as in the run; the display shows the pose of the trace. The latency
    is that of the run, for a link with jitter the typical one.
    """
    age_ns = expected_age_ns(options, schedule.age_ns, schedule.rate_hz)
    stride = -(-schedule.count // MOST_INSTANTS)
    shown_ns = np.array(
        [schedule.first_ns + round(k * 1e9 / schedule.rate_hz) for k in range(0, schedule.count, stride)],
        dtype=np.int64,
    )
    shown = track.sample_many(shown_ns)
    drawn = [_drawn_for(track, t - age_ns, age_ns, options) for t in shown_ns.tolist()]
    needed = needed_factors(
        headset,
        (np.array([pose.pose.position_m for pose in drawn]), np.array([pose.pose.orientation_xyzw for pose in drawn])),
        (shown.position_m, shown.orientation_xyzw),
    )
    wanted = float(np.quantile(needed, QUANTILE, method="higher"))
    factor = min(MOST, math.ceil(max(wanted, 1) * _STEP - 1e-6) / _STEP) if math.isfinite(wanted) else MOST
    return Guard(factor, wanted)


def _drawn_for(track: PoseTrack, now_ns: int, age_ns: int, options: RunOptions) -> PoseSample:
    if options.predict == "none":
        return track.at(now_ns)
    return predict(track, now_ns, now_ns + age_ns, options.predict, options.horizon_ns)


def needed_factors(headset: Headset, drawn: tuple[Array, Array], shown: tuple[Array, Array]) -> Array:
    """Return how much larger, in tangents, each picture must be drawn: (n,) factors.

    1 for a head that has not moved, infinite where the middle of a side lies beside or behind the
    rendered eye. drawn, shown: head positions (n, 3) in metres and orientations (n, 4).
    """
    needed = np.ones(len(drawn[0]))
    for eye in headset.eyes:
        for inverse_depth in (0.0, 1 / NEAR_M):
            needed = np.maximum(needed, _needed(eye.fov, eye.head_from_eye, inverse_depth, drawn, shown))
    return needed


def _needed(
    fov: Fov, head_from_eye: Pose, inverse_depth: float, drawn: tuple[Array, Array], shown: tuple[Array, Array]
) -> Array:
    left, right, down, up = fov.tangents
    axes = head_from_eye.rotation_matrix
    middles = np.array([(left, 0, -1), (right, 0, -1), (0, down, -1), (0, up, -1)]) @ axes.T
    eyes = [
        position + rotate(turned, np.broadcast_to(head_from_eye.position_m, position.shape))
        for position, turned in (drawn, shown)
    ]
    moved = (eyes[1] - eyes[0]) * inverse_depth
    most = np.ones(len(moved))
    for middle in middles:
        towards = rotate(shown[1], np.broadcast_to(middle, moved.shape)) + moved
        x, y, z = (rotate(conjugate(drawn[1]), towards) @ axes).T
        with np.errstate(divide="ignore", invalid="ignore"):
            sides = np.stack([x / -z / left, x / -z / right, y / -z / down, y / -z / up])
        most = np.maximum(most, np.where(z < 0, sides.max(axis=0), np.inf))
    return most


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
    with MeasuringProcesses(worker_count(options.workers)) as processes:
        pool = QualityPool(processes)
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
