"""Choose warp, fill and guard band for a budget, by a benchmark or a short bench of its own."""

from __future__ import annotations

import itertools
import math
import shlex
import tomllib
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from pathlib import Path
from statistics import fmean, median

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import AUTO, InputError, PlanError, memory_bytes
from ..client import PANEL, SHOWN, SHOWN_DEPTH, Plan, every_warp, needs_of
from ..client.classes import Client, load_client
from ..frames import EyeSizes, frame_bytes
from ..headsets import Headset, load_headset
from ..link import LinkOptions
from ..metrics import MeasuringThreads, QualityPool, worker_count
from ..pipeline import PipelineOptions, Source, source_of
from ..pipeline.governor import QualityLevel, Row, best_within, levels_from, read_rows
from ..pipeline.sizes import build_plan_for, expected_age_ns, guarded_size
from ..poses import PoseTrack, load_trace, predict
from ..poses.quaternions import conjugate, rotate
from .measuring import GPU_BATCH_BYTES, MEMORY_PART, Case, Combination, Comparison, batches, instants_of, refreshes
from .options import RunOptions
from .replay_run import Progress
from .run import ReplayRun, Schedule, schedule_of, set_up_replay

QUANTILE = 0.95
# A guard of 2 has four times the pixels; a second, wide view (fill `wide`) costs half a picture
# and reaches farther.
MOST = 2.0
NEAR_M = 1.0  # nearest surface considered; nearer ones enter the view from farther in
MOST_INSTANTS = 2000
_STEP = 100  # factors are rounded up to a hundredth

Array = NDArray[np.float64]


def guard_for(headset: Headset, track: PoseTrack, schedule: Schedule, options: RunOptions) -> tuple[float, str]:
    """Return the factor that holds the middles of the pictures' sides in 95 of 100 refreshes.

    And what there is to know of it. All four sides of both eyes count, for scenery from 1 m to
    infinity, of the poses that the server draws for and the trace's. Jitter counts as typical.
    """
    age_ns = expected_age_ns(options, schedule.age_ns, schedule.rate_hz)
    stride = -(-schedule.count // MOST_INSTANTS)
    every = range(0, schedule.count, stride)
    shown_ns = np.array([schedule.first_ns + round(k * 1e9 / schedule.rate_hz) for k in every], dtype=np.int64)
    shown = track.sample_many(shown_ns)
    drawn = [
        track.at(t - age_ns)
        if options.predict == "none"
        else predict(track, t - age_ns, t, options.predict, options.horizon_ns)
        for t in shown_ns.tolist()
    ]
    needed = needed_factors(
        headset,
        (np.array([pose.pose.position_m for pose in drawn]), np.array([pose.pose.orientation_xyzw for pose in drawn])),
        (shown.position_m, shown.orientation_xyzw),
    )
    # Infinite where the head turns a side behind the eye.
    wanted = float(np.quantile(needed, QUANTILE, method="higher"))
    flat = math.isfinite(wanted)
    factor = min(MOST, math.ceil(max(wanted, 1) * _STEP - 1e-6) / _STEP) if flat else MOST
    size = f"a picture {wanted:.2f} times as large in tangents" if flat else "more than any flat picture holds"
    told = f"Guard auto: to lose nothing at {QUANTILE:.0%} of the refreshes takes {size}; {factor:g} is drawn"
    beyond = ", auto's most. A second, wide view (--fill wide+..) reaches farther and costs less"
    return factor, f"{told}{'' if wanted <= MOST else beyond}."


def needed_factors(headset: Headset, drawn: tuple[Array, Array], shown: tuple[Array, Array]) -> Array:
    """Return how much larger, in tangents, each picture must be drawn: (n,) factors from 1.

    Infinite where the middle of a side lies beside or behind the rendered eye. drawn, shown: head
    positions (n, 3) in metres and orientations (n, 4).
    """
    most = np.ones(len(drawn[0]))
    for eye in headset.eyes:
        left, right, down, up = eye.fov.tangents
        axes = eye.head_from_eye.rotation_matrix
        middles = np.array([(left, 0, -1), (right, 0, -1), (0, down, -1), (0, up, -1)]) @ axes.T
        offset = np.broadcast_to(eye.head_from_eye.position_m, drawn[0].shape)
        places = [position + rotate(turned, offset) for position, turned in (drawn, shown)]
        for middle, inverse_depth in product(middles, (0.0, 1 / NEAR_M)):
            moved = (places[1] - places[0]) * inverse_depth
            towards = rotate(shown[1], np.broadcast_to(middle, moved.shape)) + moved
            x, y, z = (rotate(conjugate(drawn[1]), towards) @ axes).T
            with np.errstate(divide="ignore", invalid="ignore"):
                sides = np.stack([x / -z / left, x / -z / right, y / -z / down, y / -z / up])
            most = np.maximum(most, np.where(z < 0, sides.max(axis=0), np.inf))
    return most


@attrs.frozen
class _LevelSet:
    """Quality levels, from cheapest to most accurate, and how they were obtained."""

    levels: tuple[QualityLevel, ...]
    notes: tuple[str, ...]


_TERMS = ("scene", "latency_ms", "guard", "lens")  # which may differ from the run's own


def levels_from_file(path: Path, options: PipelineOptions, device: Client | None = None) -> _LevelSet:
    """Return the levels of a benchmark for a run, with its times or those modelled of a device.

    Uses the rows of the run's size, else those of the largest size, with times scaled by the number
    of pixels. Combinations that this run cannot use are left out, with a note.
    Errors: InputError for a file that is no benchmark, and if none of its combinations can run.
    """
    name, headset, usable = path.name, load_headset(options.headset), list[Row]()
    size = options.size or headset.eye_size_px
    build_plan_for(options.with_pair("none", "none"), headset, None)
    rows = read_rows(path)
    machines = {f"{row['machine']['gl_renderer']} with {row['machine']['cpu_count']} cores": None for row in rows}
    terms = {key: dict.fromkeys(str(row[key]) for row in rows if key in row) for key in _TERMS}
    told = "; ".join(f"{key} {', '.join(values)}" for key, values in terms.items() if values)
    notes = [f"{name} was measured on {', and on '.join(machines)}: {told}."]
    for warp, fill in sorted({(row["warp"], row["fill"]) for row in rows}):
        try:
            plan = build_plan_for(options.with_pair(warp, fill), headset, None)
            ours = (row for row in rows if (row["warp"], row["fill"]) == (warp, fill))
            usable += [_timed_for(options, row, plan, device) for row in ours]
        except InputError as error:
            notes.append(f"{name}: warp '{warp}' with fill '{fill}' is left out: {error}.")
    if not usable:
        raise InputError(f"{path}: nothing of its {len(rows)} rows can be run here; {notes[-1]}")
    same = [row for row in usable if tuple(row["size"]) == size]
    try:
        levels = levels_from(same or usable)
    except InputError as error:
        raise InputError(f"{name}: {error}") from error
    if not same:
        width, height = max((row["size"] for row in usable), key=lambda s: s[0] * s[1])
        factor = size[0] * size[1] / (width * height)
        sizes = f"{name} was measured at {width}x{height}, this run is {size[0]}x{size[1]}"
        notes.append(f"{sizes}: its times are taken in proportion to the pixels, {factor:.2g} times.")
        levels = tuple(level.scaled(factor) for level in levels)
    return _LevelSet(levels, tuple(notes))


def _timed_for(options: PipelineOptions, row: Row, plan: Plan, device: Client | None) -> Row:
    """Return a row with the time of a device, or without that of a lens that the run has not."""
    times, lens, found = row["time_ms"], row["lens"], row["time_ms"]["total"]["median"]
    if device is not None:
        found = device_ms(plan, tuple(row["size"]), device)[1]
    elif options.lens == "none":
        lens, found = "none", None if found is None else found - (times["lens"]["median"] or 0.0)
    return {**row, "lens": lens, "time_ms": {**times, "total": {"median": found, "p95": None}}}


INSTANTS, ROUNDS = 3, 2  # instants, evenly spread over the run; timed runs of both eyes at each
# Every fill with every warp would be over a hundred pictures per instant, and some fills depend on
# earlier refreshes, which a few instants cannot show. These differ most in cost and quality; use
# --bench FILE for others.
FILLS = ("none", "interpolate", "pyramid")
# A warp beyond twice the budget would need a machine twice as fast: its picture is not measured.
REACH = 2.0
MOST_PIXELS = 1_000_000  # of an eye: more are drawn at a third, where a device's times are modelled

Say = Callable[[str], None]


@attrs.frozen
class Choice:
    """What `auto` stands for in a run, and why."""

    # Names what was chosen; nothing in them is `auto`.
    options: RunOptions
    # The chosen level, and all that it was chosen from, cheapest first; None and () where the run
    # named its warp.
    level: QualityLevel | None
    levels: tuple[QualityLevel, ...]
    notes: tuple[str, ...]
    # Of the level on a client's device that is modelled, the least and the most; None if measured.
    range_ms: tuple[float, float] | None = None

    def command(self, arguments: Sequence[str]) -> str:
        """Return the command line of the chosen replay. arguments: of the one that chose."""
        named = {"--warp": self.options.warp, "--fill": self.options.fill, "--guard": f"{self.options.guard}"}
        dropped, kept, words = {*named, "--budget", "--bench"}, [], iter(arguments)
        for word in words:
            name, has_value, _ = word.partition("=")
            if name in dropped:
                if not has_value:
                    next(words, None)
            elif name not in ("--json", "--quiet"):
                kept.append(word)
        return shlex.join(["hmdwarp", "replay", *kept, *(part for pair in named.items() for part in pair)])


def choose(options: RunOptions, say: Say = lambda text: None, progress: Progress = lambda done, total: None) -> Choice:
    """Return the run with what `auto` stands for: a guard band, a warp and a fill.

    They are the most accurate that take at most `options.budget_ms` for one eye: by
    `options.bench`, or by a short bench on a few instants of this run.

    Parameters
    ----------
    options
        A run whose warp, guard or both are "auto".
    say
        Called with a sentence before a short bench starts.
    progress
        Called with (done, total) of the instants of a short bench.

    Returns
    -------
    Choice
        The options with all of it named, and why.

    Raises
    ------
    InputError
        For wrong options, a file that is no benchmark, and where nothing fits the budget.
    MachineError
        For missing hardware or software.
    """
    source = source_of(options)
    notes: tuple[str, ...] = ()
    options = source.fitted(options)
    if options.guard == AUTO:
        track = load_trace(options.trace, options.trace_options).track
        schedule = schedule_of(track, options, options.rate_hz or source.headset.refresh_hz)
        factor, note = guard_for(source.headset, track, schedule, options)
        options, notes = attrs.evolve(options, guard=factor), (note,)
    if options.warp != AUTO:
        return Choice(options, None, (), notes)
    client = load_client(options.client_name)
    device = client if client.memory_gb_s < math.inf else None
    if options.bench is None:
        found = levels_by_short_bench(options, source, say, device, progress)
    else:
        found = levels_from_file(options.bench, options, device)
    level = found.levels[best_within(found.levels, options.budget_ms)]
    made = Choice(options.with_pair(level.warp, level.fill), level, found.levels, (*notes, *found.notes))
    why = [f"{level}: {level.total_ms:.2f} of {options.budget_ms:g} ms for one eye, mean FLIP {level.error:.4f}."]
    if device is not None:
        plan = build_plan_for(made.options, source.headset, source.scene)
        wide, high = size = options.size or source.headset.eye_size_px
        least, _, most = device_ms(plan, size, device)
        made = attrs.evolve(made, range_ms=(least, most))
        why += [f"That time is a model's, at {wide}x{high}: {least:.1f} to {most:.1f} ms on '{device.name}'. {MODEL}"]
    for more in found.levels[found.levels.index(level) + 1 :][:1]:
        why += [f"The next better is {more}: {more.total_ms:.2f} ms, mean FLIP {more.error:.4f}."]
    return attrs.evolve(made, notes=(*why, *made.notes))


def candidates(options: PipelineOptions, source: Source) -> list[Combination]:
    """Return every warp and variant with each of FILLS, except those that this run cannot use."""
    headset, scene, found = source.headset, source.scene, list[Combination]()
    build_plan_for(options.with_pair("none", "none"), headset, scene)
    for warp, fill in product(every_warp(), FILLS):
        try:
            pair = options.with_pair(warp, fill)
            found.append(Combination(warp, fill, build_plan_for(pair, headset, scene, in_turns=True)))
        except PlanError:
            continue
    return found


def levels_by_short_bench(
    options: RunOptions,
    source: Source,
    say: Say,
    device: Client | None = None,
    progress: Progress = lambda done, total: None,
) -> _LevelSet:
    """Return the levels measured at a few instants of this run, or modelled for a device."""
    budget_ms, combinations = options.budget_ms or 0.0, candidates(options, source)
    say(
        f"trying {len(combinations)} combinations of warp and fill at {INSTANTS} instants of this run first; --bench "
        "FILE saves that"
    )
    size = drawn = options.size or source.headset.eye_size_px
    if device is not None and math.prod(size) > MOST_PIXELS:
        drawn = (round(size[0] / 3), round(size[1] / 3))
    # Frames for all alike; their network only delays.
    network = LinkOptions(server_rate_hz=options.network.server_rate_hz)
    alone = attrs.evolve(options.with_pair("none", "none"), lens="none", against="", network=network)

    def frames_for(
        chosen: Sequence[Combination], size: tuple[int, int]
    ) -> Iterator[tuple[list[Combination], ReplayRun, Callable[[], None]]]:
        rendered = guarded_size(options.guard_band, source.headset, size)
        most = min(GPU_BATCH_BYTES, MEMORY_PART * memory_bytes())
        parts, done = batches(chosen, rendered, size, most), itertools.count(1)
        for batch in parts:
            needs = needs_of(c.plan for c in batch)
            with set_up_replay(attrs.evolve(alone, size=size), needs, source=source) as setup:
                yield batch, setup, lambda: progress(next(done), INSTANTS * len(parts))

    plain = [c for c in combinations if not c.plan.fills]
    times = {} if device is None else {c.warp: device_ms(c.plan, size, device)[1] for c in plain}
    for batch, setup, _ in [] if times else frames_for(plain, size):
        (_, refresh), *_ = refreshes(setup, setup.needs, set(instants_of(setup.schedule.count, 1)))
        for combination in batch:
            compensator = setup.compensator(combination.plan)
            inputs = setup.loop.inputs(refresh, combination.plan.needs)
            for _ in range(2):  # the first warms up
                for eye_inputs in inputs:
                    compensator.run(eye_inputs)
                stages = setup.target.gpu.timer.collect()
            times[combination.warp] = sum(milliseconds for _, milliseconds in stages) / 2
    within = [warp for warp, ms in times.items() if ms <= REACH * budget_ms] or [min(times, key=times.__getitem__)]
    kept = [c for c in combinations if c.warp in within]
    case, rows = Case(options.scene, options.trace, options.latency_ms, drawn), []
    with MeasuringThreads(worker_count(options.workers)) as threads:
        pool = QualityPool(threads)
        for batch, setup, step in frames_for(kept, drawn):
            comparison = Comparison(setup, case, batch, pool, ROUNDS)
            comparison.run(INSTANTS, step)
            pool.wait()
            for made in comparison.measured:
                figures, plan = [pool.results[key] for key in made.keys], made.combination.plan
                both = ("flip", "psnr_db")
                means = {name: {"mean": fmean(each[name] or 0.0 for each in figures)} for name in both}
                total = median(row["total_ms"] for row in made.times)
                time_ms = {"total": {"median": total if device is None else device_ms(plan, size, device)[1]}}
                pair = {"warp": made.combination.warp, "fill": made.combination.fill}
                rows.append({**pair, "size": size, "time_ms": time_ms, "quality": means})
    note = f"Warp 'auto' tried {len(kept)} combinations of warp and fill at {INSTANTS} instants of this run"
    if drawn != size:
        note += f", for errors at {drawn[0]}x{drawn[1]}, a third of its size each way"
    if out := ", ".join(sorted(set(times) - set(within))):
        note += f"; {out} took more than {REACH:g} times the budget, so their pictures were not measured"
    return _LevelSet(levels_from(rows), (f"{note}.",))


_MEASURED = tomllib.loads(Path(__file__).with_name("measured_passes.toml").read_text(encoding="utf-8"))
MODEL = (
    f"The least is by the bytes that it moves and the makers' memory rate, the most by passes measured on an "
    f"{_MEASURED['gpu']['name']}. Measure the device itself: 'hmdwarp serve --web', with &bench in the page's address."
)
_PIXEL_BYTES = {SHOWN: 8, PANEL: 8, SHOWN_DEPTH: 4}


def device_ms(plan: Plan, size: tuple[int, int], client: Client) -> tuple[float, float, float]:
    """Return the least ms, the geometric mean of both ends, and the most, of one eye of (w, h).

    Least: all that is read and written crosses the memory once, at its maker's rate. Most: as on
    the measured GPU, times how much slower the device's memory or arithmetic is, the worse of both;
    a pass that was not measured counts as the slowest that was, a lens as a warp that only copies.
    """
    pixels, gpu, layers, others = math.prod(size), _MEASURED["gpu"], set(plan.layers), plan.needs.others
    frame = sum(frame_bytes(plan.needs, EyeSizes(size, size), layers, eyes=1).values())
    names = [name for step in plan.steps for name in (*step.reads, *step.writes)]
    moved = (1 + others.past + others.recent) * frame + pixels * sum(_PIXEL_BYTES.get(name, 0) for name in names)
    least = moved / client.memory_gb_s * 1e-6
    passes = [("warps", plan.warp.name), *(("fills", fill.entry.name) for fill in plan.fills)]
    passes += [("warps", "none")] if plan.lens.is_pass else []
    there = sum(_MEASURED[kind].get(name, max(_MEASURED[kind].values())) for kind, name in passes)
    there += others.recent * _MEASURED["older_frame"] * _MEASURED["warps"]["iterative"]
    slower = max(gpu["memory_gb_s"] / client.memory_gb_s, gpu["compute_tflops"] / client.compute_tflops)
    most = max(least, there * slower * pixels / math.prod(gpu["size"]))
    return least, math.sqrt(least * most), most
