"""The set-up of a replay, in an order that fails early: its refresh times, and what it runs on."""

from __future__ import annotations

import functools
import math
import operator
from collections import Counter
from collections.abc import Callable, Hashable, Iterator
from contextlib import ExitStack

import attrs
import numpy as np

from ..errors import InputError, counted
from ..frames import Needs
from ..gpu.context import Gpu
from ..metrics import Alike, PairPass, QualityJob, QualityPool
from ..pipeline.options import SERVER_SCENE
from ..pipeline.proxy import source_of
from ..pipeline.sizes import latency_ns, plan_against, refreshes_of, smaller_size
from ..pipeline.source import Source, motion_notes
from ..poses import LoadedTrace, PoseTrack, RecordedSource, load_trace
from ..scenes import Scene, take_inputs
from .options import RunOptions
from .run import EmulatedScreen, Run

_MANY = 10_000  # refreshes
# Of a refresh: that of a GPU is a guess; llvmpipe took 0.2 s without metrics and 0.6 s with two
# methods beside it, on two cores.
_SECONDS_EACH = 0.05, 0.5
_DAY_S = 86_400.0


@attrs.frozen
class Schedule:
    """Refreshes of a display in integer nanoseconds on the trace's clock, mostly evenly spaced."""

    # Time of the first shown refresh.
    first_ns: int
    rate_hz: float
    # Number of shown refreshes.
    count: int
    # Number of refreshes between drawing a frame and showing it.
    age: int
    # Number of refreshes before that until a proxy has something to draw it from.
    ahead: int = 0
    # Of refreshes that are not evenly spaced, those that only draw included; None for even ones.
    instants_ns: tuple[int, ...] | None = None

    @property
    def age_ns(self) -> int:
        """Time from drawing to showing, within 1 ns."""
        return round(self.age * 1e9 / self.rate_hz)

    def link_latency_ns(self, options: RunOptions) -> int:
        """Delay of the link.

        At most the time between any two refreshes `age` apart, which are rounded to whole ns.
        """
        return (
            min(latency_ns(options), max(0, self.age_ns - 2)) if options.client_link.is_plain else latency_ns(options)
        )

    def numbered(self) -> Iterator[tuple[int, int]]:
        """Yield (number, time_ns) of every refresh.

        Those with a negative number only draw, so that a frame has arrived by the first shown one.
        """
        if self.instants_ns is not None:
            yield from enumerate(self.instants_ns, -self.age)
            return
        for number in range(-self.age - self.ahead, self.count):
            yield number, self.first_ns + round(number * 1e9 / self.rate_hz)


def schedule_for(options: RunOptions, source: Source, trace: LoadedTrace, rate_hz: float) -> Schedule:
    """Return the refreshes of a run: evenly spaced, or at the instants of recorded frames.

    The truth of those is what was recorded. The first is at the requested start, or when the first
    frame can have arrived. Errors: InputError if the run would show nothing.
    """
    times, place, rate_hz_of_frames = source.instants_ns, trace.path, source.headset.refresh_hz
    if not times or options.trace or options.rate_hz is not None:
        return schedule_of(trace.track, options, rate_hz)
    if len(times) < 2:
        raise InputError(f"{place}: one frame; expected two or more: one that is late, and what is seen then")
    age, _ = _refreshes_before(options, rate_hz_of_frames)
    first = next((i for i, at in enumerate(times) if i >= age and at >= options.start_s * 1e9), len(times))
    if first == len(times):
        raise InputError(
            f"{place}: its {len(times)} frames last {times[-1] * 1e-9:.3f} s: with --latency {options.latency_ms:g} ms "
            f"and --start {options.start_s:g} s none is left to show; use a shorter latency, an earlier start, or say "
            "how fast they were taken by --frames-rate"
        )
    seconds = math.inf if options.seconds is None else options.seconds
    end = next((i for i, at in enumerate(times) if at >= times[first] + seconds * 1e9), len(times))
    instants = tuple(times[first - age : max(end, first + 1)])
    return Schedule(times[first], rate_hz_of_frames, max(1, end - first), age, instants_ns=instants)


def schedule_of(track: PoseTrack, options: RunOptions, rate_hz: float) -> Schedule:
    """Return the refreshes of a run.

    The first is at the requested start, or when the first frame can have arrived if that is later.
    There are as many as fit into the requested seconds and into the trace, at least one.
    Errors: InputError if the run would show nothing of the trace.
    """
    length_s = track.duration_ns * 1e-9
    if length_s == 0:
        raise InputError(f"the trace '{track.name}' has a single sample: expected head motion over time")
    if options.start_s >= length_s:
        raise InputError(
            f"--start {options.start_s:g} s: the trace '{track.name}' is {length_s:.3f} s long; start before its end"
        )
    age, ahead = _refreshes_before(options, rate_hz)
    first = (age + ahead) / rate_hz
    if first > length_s:
        raise InputError(
            f"--latency {options.total_latency_ms:g} ms is longer than the trace '{track.name}' ({length_s:.3f} s): no "
            "frame would arrive; use a shorter latency or a longer trace; if its length is wrong, state the unit of "
            "its clock by --time-unit"
        )
    start_s = max(options.start_s, first)
    seconds = length_s - start_s if options.seconds is None else min(options.seconds, length_s - start_s)
    if options.seconds is None and seconds > _DAY_S and rate_hz > 1:
        raise InputError(
            f"the trace '{track.name}' has {seconds / _DAY_S:.1f} days to show, {math.floor(seconds * rate_hz)} "
            "refreshes: expected at most one day unless stated; say how much of it by --seconds"
        )
    # Within 1e-6 of a refresh: 1 s at 90 Hz is 90 refreshes despite rounding.
    count = max(1, math.floor(seconds * rate_hz + 1e-6))
    return Schedule(track.start_ns + round(start_s * 1e9), rate_hz, count, age, ahead)


def first_shown_s(options: RunOptions, rate_hz: float) -> float:
    """Return the seconds into a trace after which the first frame has arrived for certain."""
    return sum(_refreshes_before(options, rate_hz)) / rate_hz


def _refreshes_before(options: RunOptions, rate_hz: float) -> tuple[int, int]:
    """Return how many refreshes a frame is under way to the client, and to a proxy before that."""
    options.client_link.check(latency_ns(options))
    link_ms = options.client_link.longest_ns(latency_ns(options)) / 1e6
    return refreshes_of(link_ms, rate_hz), refreshes_of(options.proxy.longest_ms(options.network), rate_hz)


@attrs.define(eq=False)
class ReplayRun(Run[RunOptions]):
    """Everything that one replay runs on: it frees the GPU too."""

    trace: LoadedTrace = attrs.field(init=False)
    # The trace, moved to where the scene can be walked in.
    track: PoseTrack = attrs.field(init=False)
    schedule: Schedule = attrs.field(init=False)
    notes: list[str] = attrs.field(init=False)

    @property
    def pixels_per_degree(self) -> float:
        """Resolution of the shown view, for the metrics."""
        return self.source.headset.eyes[0].fov.pixels_per_degree(self.sizes.shown)

    @functools.cached_property
    def _pairs(self) -> PairPass:
        made = PairPass(self.target.gpu, self.sizes.shown, self.pixels_per_degree)
        self.cleanup.callback(made.close)
        return made

    def hand_in(self, pool: QualityPool, key: Hashable, job: QualityJob, *, keep: bool = False) -> Alike:
        """Submit a picture, with what the GPU finds of it; return that. Errors: as pool.submit."""
        alike = self._pairs.run(job.now.shown, job.now.truth)
        if job.previous is not None and (flicker := self._pairs.flicker(job.now, job.previous)) is not None:
            job = attrs.evolve(job, previous=None)
            alike = attrs.evolve(alike, flicker=flicker)
        pool.submit(key, attrs.evolve(job, alike=alike), keep=keep)
        return alike


def set_up_replay(
    options: RunOptions,
    also: Needs | None = None,
    say: Callable[[str], None] = lambda text: None,
    *,
    alone: bool = False,
    source: Source | None = None,
) -> ReplayRun:
    """Load, check, then start the GPU.

    options: nothing in them is "auto". also: layers that frames must carry for plans other
    than the run's. say: called with a sentence once all is checked, before what takes seconds.
    alone: whether other plans on these frames take their inputs from WholePictures; a picture that
    the run's own plan does not read is not drawn then. source: if it is open already; it is closed
    with the set-up.
    Errors: InputError and its subclasses for wrong options, MachineError for missing hardware or
    software.
    """
    source = source or source_of(options)
    options, headset = source.fitted(options), source.headset
    of_others = [also or Needs(), *(plan_against(options, *pair).needs for pair in options.compared)]
    trace = source.head(load_trace(options.trace, options.trace_options) if options.trace else None)
    assert trace is not None, "options without a trace have a source with a head"
    if options.as_recorded:  # on the trace's own clock
        own = trace.track
        own = own.evolve(time_ns=own.time_ns + own.epoch_ns, epoch_ns=0, max_gap_ns=own.max_gap_ns)
        trace = attrs.evolve(trace, track=own)
    rate_hz = options.rate_hz or headset.refresh_hz
    schedule = None if source.kind.is_timed else schedule_for(options, source, trace, rate_hz)
    if options.scene == SERVER_SCENE and not source.kind.is_timed:
        raise InputError(f"--scene {SERVER_SCENE}: it is what the server at --connect draws: name that, or a scene")
    run = ReplayRun.of(
        options,
        source,
        EmulatedScreen(headset, headset),
        functools.reduce(operator.or_, of_others),
        all_pictures=not alone,
    )
    track, notes = (trace.track, []) if options.as_recorded else placed(trace.track, source.scene)
    with ExitStack() as unfinished:
        unfinished.callback(run.close)
        run.cleanup.callback(source.close)
        notes += acted(options.input, source, trace.track)

        def say_and_note(text: str) -> None:
            say(text)
            notes.append(text)

        run.measure(track.at(track.start_ns), holds=True, keeps=True, say=say_and_note)
        schedule = schedule or schedule_of(trace.track, run.options, rate_hz)
        cost = ""
        if schedule.count >= _MANY:
            least, most = (schedule.count * each / 3600 for each in _SECONDS_EACH)
            cost = f", about {least:.1f} h on a GPU to {most:.1f} h without one; --seconds shows less"
        name = track.name or trace.path.stem
        say(f"preparing {source.title}, OpenGL and metrics; then {schedule.count} refreshes of '{name}'{cost}")
        gpu = run.cleanup.enter_context(Gpu())
        if slow := smaller_size(gpu, options, headset.eye_size_px):
            say(slow)
        poses = RecordedSource(track)
        poses.start()
        run.cleanup.callback(poses.close)
        run.start(gpu, poses, lambda now_ns: track, schedule.age_ns, schedule.link_latency_ns(run.options))
        notes[:0] = [*source.notes, *trace.notes, *source.scene.notes]
        notes.extend([*run.options.notes, *motion_notes(run.options, source.scene, run.plans[0])])
        run.trace, run.track, run.schedule, run.notes = trace, track, schedule, notes
        unfinished.pop_all()
    return run


def acted(spec: str, source: Source, track: PoseTrack) -> list[str]:
    """Add the inputs of a run to the scene, and return what there is to know of them.

    spec: as RunOptions.input. track: the head's, on the clock of a file's inputs.
    Errors: as Source.inputs, and as take_inputs.
    """
    if not spec:
        return []
    try:
        inputs = source.inputs
    except InputError as error:
        raise InputError(f"--input {spec}: {error}") from error
    lost = take_inputs(inputs, spec, (track.start_ns, track.end_ns), track.epoch_ns)
    kinds = Counter(f"{event.action} {event.target}" for event in inputs)
    found = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items())) or "none"
    more = f"; {counted(lost, 'input')} meant nothing that takes it" if lost else ""
    return [f"Inputs by {spec}: {found}{more}. The server knows each from its own instant on."]


def placed(track: PoseTrack, scene: Scene) -> tuple[PoseTrack, list[str]]:
    """Return the track moved to where the scene can be walked in, and notes on the move.

    A track within the scene's walking bounds is unchanged. Others (recorded in other rooms and
    units) are translated, not rotated, so that their mean position is the scene's viewpoint.
    """
    low, high = scene.walk_bounds_m
    if ((track.position_m >= low) & (track.position_m <= high)).all():
        return track, []
    shift = scene.viewpoint.position_m - track.position_m.mean(axis=0)
    moved = track.evolve(position_m=track.position_m + shift)
    beyond = float(np.maximum(low - moved.position_m, moved.position_m - high).max())
    by = ", ".join(f"{x:+.2f}" for x in shift)
    notes = [f"The trace does not fit scene '{scene.name}': its positions were shifted by ({by}) m."]
    if beyond > 0:
        notes.append(f"The head still goes up to {beyond:.2f} m outside and may clip through geometry.")
    return moved, notes
