"""One run: what it shows, on which display, by which plans; checked first, then made on a GPU."""

from __future__ import annotations

import functools
import math
import operator
from collections import Counter
from collections.abc import Callable, Hashable, Iterator
from contextlib import ExitStack
from typing import ClassVar, Generic, Self, TypeVar

import attrs
import numpy as np

from ..base import InputError, counted
from ..client import ClientScene, Compensator, Plan, needs_of
from ..client.classes import load_client
from ..display import Display
from ..frames import EyeSizes, Needs, frame_bytes, video_pixels
from ..frames.layers import PICTURE
from ..geometry import Eyes, Pose
from ..gpu import Gpu
from ..headsets import Headset
from ..link import CHANGES
from ..link.codec import codecs
from ..metrics import Alike, PairPass, QualityJob, QualityPool
from ..pipeline import Changes, Channel, Coder, Loop, Reads, source_of
from ..pipeline.governor import AdaptiveCompensator, Governor
from ..pipeline.options import SERVER_SCENE, PipelineOptions
from ..pipeline.sizes import (
    check_held,
    expected_age_ns,
    eye_sizes,
    guarded_size,
    latency_ns,
    plan_against,
    plans_for,
    refreshes_of,
    smaller_size,
)
from ..pipeline.source import MomentOf, PoseRequest, Source, Target, client_scene, joined, motion_notes
from ..poses import (
    LoadedTrace,
    PoseSample,
    PoseSource,
    PoseTrack,
    RecordedSource,
    known_gaze,
    load_trace,
    predict,
    predictors,
)
from ..poses.track import Gaze, Moment
from ..scenes import Scene, take_inputs
from ..sources.server import Renderer
from .options import RunOptions

Options = TypeVar("Options", bound=PipelineOptions)


@attrs.frozen(eq=False)
class EmulatedScreen:
    """What a run without a display is shown on: a headset, whose lens the plans correct."""

    headset: Headset
    eyes: Eyes
    # As of build_plan.
    distorts: ClassVar[str] = ""
    takes_depth: ClassVar[str] = ""
    takes_panels: ClassVar[str] = ""

    @property
    def size(self) -> tuple[int, int]:
        return self.headset.eye_size_px

    @property
    def rate_hz(self) -> float:
        return self.headset.refresh_hz


@attrs.define(eq=False)
class Run(Generic[Options]):
    """What a driver runs: `of` checks it, `start` makes it on a GPU; a context frees it."""

    # Its size is that of the display, where none is set; its latency is measured by `measure`.
    options: Options
    source: Source
    screen: Display | EmulatedScreen | None
    # One, or one for each quality level.
    plans: list[Plan]
    # Of all plans on its frames.
    needs: Needs
    # What is read of the eyes' pictures, as of PoseRequest.
    pictures: frozenset[str] = frozenset(PICTURE)
    # The rest is there once it has started.
    requested: PoseRequest = attrs.field(init=False)
    target: Target = attrs.field(init=False)
    sizes: EyeSizes = attrs.field(init=False)
    server: Renderer = attrs.field(init=False)
    geometry: ClientScene = attrs.field(init=False)
    channel: Channel = attrs.field(init=False)
    loop: Loop = attrs.field(init=False)
    # Chooses the warp; None where the options name one.
    auto: AdaptiveCompensator | None = attrs.field(init=False, default=None)
    # Frees what the run holds, the last first.
    cleanup: ExitStack = attrs.field(init=False, factory=ExitStack)
    _made: list[Compensator | AdaptiveCompensator] = attrs.field(init=False, factory=list)

    @classmethod
    def of(
        cls,
        options: Options,
        source: Source,
        screen: Display | EmulatedScreen,
        also: Needs | None = None,
        *,
        all_pictures: bool = False,
    ) -> Self:
        """Return a run that is checked.

        screen: gives size and rate to options that set none. also: needs of further plans.
        all_pictures: draw pictures even if no plan reads them. Errors: InputError.
        """
        options = attrs.evolve(options, size=options.size or screen.size)
        beyond = {name: getattr(screen, name) for name in ("distorts", "takes_depth", "takes_panels")}
        plans = plans_for(options, screen.headset, source.scene, **beyond)
        needs = needs_of(plans) | (also or Needs())
        source.check(plans, needs, len(screen.eyes.views(Pose())))
        assert options.size is not None
        guarded_size(options.guard_band, screen.eyes, options.size)
        pictures = Reads.of(plans).pictures | frozenset(PICTURE if all_pictures else ())
        return cls(options, source, screen, plans, needs, pictures)

    def measure(self, head: PoseSample, *, holds: bool, keeps: bool = False, say: Callable[[str], None]) -> None:
        """Connect where frames come from elsewhere, for the real latency. Errors: as of source."""
        assert self.screen is not None
        self.options = self.source.measured(
            self.options,
            head=head,
            views=self.screen.eyes.views(head.pose),
            rate_hz=self.options.rate_hz or self.screen.rate_hz,
            needs=self.needs,
            pictures=self.pictures,
            holds=holds,
            keeps=keeps,
            say=say,
        )

    def start(
        self,
        gpu: Gpu,
        poses: PoseSource,
        known: Callable[[int], PoseTrack],
        plain_age_ns: int,
        link_latency_ns: int,
        moment_of: MomentOf = Moment,
    ) -> Self:
        """Compile and allocate all of it, and return it.

        known(now_ns): motion of the head up to that instant, and maybe later. plain_age_ns: as of
        expected_age_ns. Errors, moment_of: as build.
        """
        options, screen = self.options, self.screen
        assert options.size is not None and screen is not None
        rate_hz = options.rate_hz or screen.rate_hz

        predictor, horizon_ns = predictors.get(options.predict), options.horizon_ns

        def predicted(now_ns: int, ahead_ns: int) -> PoseSample:
            return predict(known(now_ns), now_ns, now_ns + ahead_ns, predictor, horizon_ns)

        def gaze(now_ns: int, head: Pose) -> Gaze | None:
            return known_gaze(known(now_ns), now_ns, head)

        requested = PoseRequest(
            poses,
            predicted if options.predict != "none" else None,
            options.size,
            options.guard_band,
            self.needs,
            round(options.scanout_ms * 1e6),
            expected_age_ns(options, plain_age_ns, rate_hz),
            # What has moved since a frame was sent is known from its picture.
            self.pictures | frozenset(PICTURE if options.network.send == CHANGES else ()),
            gaze if options.fovea is not None else None,
        )
        return self.build(Target(gpu, screen.eyes, rate_hz, link_latency_ns, screen.headset), requested, moment_of)

    def build(self, target: Target, requested: PoseRequest, moment_of: MomentOf = Moment) -> Self:
        """Compile and allocate all of it for these poses.

        moment_of: where recorded frames are at an instant.
        Errors: InputError for sizes beyond the GPU's limits, MachineError for too little memory.
        """
        options, source, needs, rate_hz = self.options, self.source, requested.needs, target.rate_hz
        self.requested, self.target = requested, target
        self.sizes = eye_sizes(requested.guard, target.eyes, requested.size)
        check_held(target.gpu, options, needs, self.sizes, rate_hz)
        if options.client_name and not codecs.get(options.coding.codec).is_none:  # it decodes as fast as frames come
            client = load_client(options.client_name)
            weights = frame_bytes(
                needs_of(self.plans), self.sizes, {name for plan in self.plans for name in plan.layers}
            )
            frame_mpx = video_pixels(weights) * 1e-6
            if frame_mpx * rate_hz > client.decoder_mpx_s:
                raise InputError(
                    f"frames of {frame_mpx:.1f} Mpx at {rate_hz:g} Hz are {frame_mpx * rate_hz:.0f} Mpx/s to decode: "
                    f"client '{client.name}' decodes {client.decoder_mpx_s:g}; use a smaller --size or --guard, or "
                    "another client"
                )
        with ExitStack() as unfinished:
            unfinished.callback(self.close)
            self.server = source.renderer(target.gpu, options, moment_of)
            self.cleanup.callback(self.server.close)
            self.geometry = client_scene(options, source.scene, self.server, self.cleanup)
            frames = source.frames(options, self.server, target, requested, self.cleanup)
            # It waits for the next refresh at most.
            age_ns = expected_age_ns(options, target.link_latency_ns + round(1e9 / rate_hz), rate_hz)
            coder = Coder.of(options.coding, rate_hz, age_ns)
            link = (options.client_link, target.link_latency_ns, rate_hz, coder)
            self.channel, history = joined(frames, self.geometry, requested, self.plans, link, self.cleanup)

            def close_passes() -> None:
                for made in self._made:
                    made.close()

            self.cleanup.callback(close_passes)
            each = [self._compensator(plan) for plan in self.plans]
            if options.levels and options.budget_ms is not None:
                governor = Governor(options.levels, options.budget_ms)
                self.auto = AdaptiveCompensator(governor, dict(zip(options.levels, each, strict=True)))
                self._made = [self.auto]
            draws_changes = options.network.send == CHANGES and not options.source_kind.is_timed
            changes = Changes(source.scene, self.server.content) if draws_changes else None
            self.loop = Loop(requested, frames, self.channel, history, self.auto or each[0], target.eyes, changes)
            unfinished.pop_all()
        return self

    def compensator(self, plan: Plan) -> Compensator:
        """Return a compensator for another plan on the same frames, freed with the run."""
        self.channel.read_beside(Reads.of([plan]))
        return self._compensator(plan)

    def _compensator(self, plan: Plan) -> Compensator:
        target, sizes = self.target, self.sizes
        hides = any(view.hidden is not None for view in target.eyes.views(Pose()))
        made = Compensator(target.gpu, plan, target.lens_of, sizes.rendered, sizes.shown, self.geometry, hides=hides)
        self._made.append(made)
        return made

    def exchange(self, plan: Plan) -> None:
        """Run this plan, whose layers frames carry, in place of the present one."""
        made, before = self._compensator(plan), self.loop.compensator
        self.channel.read(Reads.of([plan]))
        self.loop.exchange(made)
        self._made.remove(before)
        before.close()
        self.plans, self.auto = [plan], None

    def close(self) -> None:
        """Free everything; safe to call twice."""
        self.cleanup.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


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
        """Delay of the link, at most the time between refreshes `age` apart, in whole ns."""
        most_ns = max(0, self.age_ns - 2) if options.client_link.is_plain else latency_ns(options)
        return min(latency_ns(options), most_ns)

    def numbered(self) -> Iterator[tuple[int, int]]:
        """Yield (number, time_ns) of every refresh; those before 0 only draw."""
        if self.instants_ns is not None:
            yield from enumerate(self.instants_ns, -self.age)
            return
        for number in range(-self.age - self.ahead, self.count):
            yield number, self.first_ns + round(number * 1e9 / self.rate_hz)


def schedule_for(options: RunOptions, source: Source, trace: LoadedTrace, rate_hz: float) -> Schedule:
    """Return the refreshes of a run: as schedule_of, or at the instants of recorded frames.

    The truth of those is what was recorded. Errors: InputError if the run would show nothing.
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
    """Return the refreshes of a run: as many as fit into the requested seconds, at least one.

    The first is at the requested start, or when the first frame can have arrived if that is later.
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
    options.client_link.delay.check(latency_ns(options))
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
    def pairs(self) -> PairPass:
        """What measures pairs of pictures on the GPU."""
        made = PairPass(self.target.gpu, self.sizes.shown, self.pixels_per_degree)
        self.cleanup.callback(made.close)
        return made

    def hand_in(self, pool: QualityPool, key: Hashable, job: QualityJob, *, keep: bool = False) -> Alike:
        """Submit a picture, with what the GPU finds of it; return that. Errors: as pool.submit."""
        alike = self.pairs.run(job.now.shown, job.now.truth)
        if job.previous is not None:
            alike = attrs.evolve(alike, flicker=self.pairs.flicker(job.now, job.previous))
            job = attrs.evolve(job, previous=None)
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

    also: layers that frames must carry for other plans. say: called with a sentence before what
    takes seconds. alone: whether these take their inputs from WholePictures; a picture that the
    run's own plan does not read is not drawn then. source: if it is open; the set-up closes it.
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
        if options.input:
            notes.append(_acted(options.input, source, trace.track))

        def say_and_note(text: str) -> None:
            say(text)
            notes.append(text)

        run.measure(track.at(track.start_ns), holds=True, keeps=True, say=say_and_note)
        schedule = schedule or schedule_of(trace.track, run.options, rate_hz)
        name = track.name or trace.path.stem
        say(f"preparing {source.title}, OpenGL and metrics; then {schedule.count} refreshes of '{name}'")
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


def _acted(spec: str, source: Source, track: PoseTrack) -> str:
    """Add what people do to the scene, and return what there is to know of it.

    track: the head's, on the clock of a file's inputs. Errors: as Source.inputs, and take_inputs.
    """
    try:
        inputs = source.inputs
    except InputError as error:
        raise InputError(f"--input {spec}: {error}") from error
    lost = take_inputs(inputs, spec, (track.start_ns, track.end_ns), track.epoch_ns)
    kinds = Counter(f"{event.action} {event.target}" for event in inputs)
    found = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items())) or "none"
    more = f"; {counted(lost, 'input')} meant nothing that takes it" if lost else ""
    return f"Inputs by {spec}: {found}{more}. The server knows each from its own instant on."


def placed(track: PoseTrack, scene: Scene) -> tuple[PoseTrack, list[str]]:
    """Return the track moved to where the scene can be walked in, and notes on the move.

    One outside, of another room, is translated so that its mean position is the scene's viewpoint.
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
