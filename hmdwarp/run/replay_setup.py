"""Set-up of a replay, in an order that fails early."""

from __future__ import annotations

import functools
import operator
from collections import Counter
from collections.abc import Callable, Hashable
from contextlib import ExitStack

import attrs
import numpy as np

from ..client.compensator import Compensator
from ..client.inputs import PassInputs
from ..client.plan import Plan
from ..errors import InputError, counted
from ..frames import Needs
from ..gpu.context import Gpu
from ..headsets import Headset
from ..metrics import PairPass, QualityJob, QualityPool
from ..pipeline.build import Pipeline
from ..pipeline.channel import Channel
from ..pipeline.loop import Loop
from ..pipeline.planning import plan_against
from ..pipeline.proxy import source_of
from ..pipeline.proxy_options import SERVER_SCENE
from ..pipeline.source import Source, motion_notes
from ..poses import LoadedTrace, PoseTrack, RecordedSource, load_trace
from ..scenes import Scene, take_inputs
from ..sources.server import Renderer
from .options import RunOptions
from .setup import EmulatedScreen, RunSetup, Schedule, schedule_for, schedule_of
from .truth import TruePicture, true_picture

_MANY = 10_000  # refreshes
# Of a refresh: that of a GPU is a guess; llvmpipe took 0.2 s without metrics and 0.6 s with two
# methods beside it, on two cores.
_SECONDS_EACH = 0.05, 0.5


@attrs.frozen(eq=False)
class ReplaySetup:
    """Everything that one replay runs on.

    Use as a context manager: it frees the GPU on exit.
    """

    run: RunSetup[RunOptions]
    trace: LoadedTrace
    # The trace, moved to where the scene can be walked in.
    track: PoseTrack
    schedule: Schedule
    pipeline: Pipeline
    notes: list[str]
    _cleanup: ExitStack
    _alike: list[PairPass] = attrs.field(factory=list)  # once it is needed

    @property
    def options(self) -> RunOptions:
        """The options, with the measured latency where frames come from elsewhere."""
        return self.run.options

    @property
    def source(self) -> Source:
        """What gives the frames."""
        return self.run.source

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) of one eye."""
        return self.run.size

    @property
    def gpu(self) -> Gpu:
        """The GPU that all of it is on."""
        return self.pipeline.gpu

    @property
    def scene(self) -> Scene:
        """What the frames show."""
        return self.source.scene

    @property
    def headset(self) -> Headset:
        """The display."""
        return self.source.headset

    @property
    def plan(self) -> Plan:
        """The plan that runs first."""
        return self.pipeline.plan

    @property
    def server(self) -> Renderer:
        """The renderer of the scene."""
        return self.pipeline.server

    @property
    def channel(self) -> Channel:
        """The transport of the frames."""
        return self.pipeline.channel

    @property
    def loop(self) -> Loop:
        """The loop over refreshes."""
        return self.pipeline.loop

    @property
    def pixels_per_degree(self) -> float:
        """Resolution of the shown view, for the metrics."""
        return self.headset.left_fov.pixels_per_degree(self.size)

    def truth(self, inputs: PassInputs, *, depth: bool = True) -> TruePicture:
        """Return what an eye should see at a refresh. Errors: NoTruth."""
        return true_picture(self.server, inputs, self.size, depth=depth)

    def hand_in(self, pool: QualityPool, key: Hashable, job: QualityJob, *, keep: bool = False) -> None:
        """Submit a picture, with what the GPU finds of it. Errors: as pool.submit."""
        if not self._alike:
            self._alike.append(PairPass(self.gpu, self.size, self.pixels_per_degree))
            self._cleanup.callback(self._alike[0].close)
        alike = self._alike[0].run(job.now.shown, job.now.truth)
        if job.previous is not None and (flicker := self._alike[0].flicker(job.now, job.previous)) is not None:
            job = attrs.evolve(job, previous=None)
            alike = attrs.evolve(alike, flicker=flicker)
        pool.submit(key, attrs.evolve(job, alike=alike), keep=keep)

    def compensator(self, plan: Plan) -> Compensator:
        """Return a compensator for another plan on the same frames, freed with this object."""
        return self.pipeline.compensator(plan)

    def __enter__(self) -> ReplaySetup:
        return self

    def __exit__(self, *_: object) -> None:
        self._cleanup.close()


def set_up_replay(
    options: RunOptions,
    also: Needs | None = None,
    say: Callable[[str], None] = lambda text: None,
    *,
    alone: bool = False,
    source: Source | None = None,
) -> ReplaySetup:
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
    trace = _on_its_own_clock(trace) if options.as_recorded else trace
    rate_hz = options.rate_hz or headset.refresh_hz
    schedule = None if source.is_timed else schedule_for(options, source, trace, rate_hz)
    if options.scene == SERVER_SCENE and not source.is_timed:
        raise InputError(f"--scene {SERVER_SCENE}: it is what the server at --connect draws: name that, or a scene")
    run = RunSetup.of(options, source, EmulatedScreen(headset, headset), functools.reduce(operator.or_, of_others))
    track, notes = (trace.track, []) if options.as_recorded else placed(trace.track, source.scene)
    with ExitStack() as stack:
        stack.callback(source.close)
        notes += acted(options.input, source, trace.track)
        run = run.measured(
            track.at(track.start_ns), holds=True, keeps=True, all_pictures=not alone, say=_both(say, notes.append)
        )
        if options.input:
            source.pass_on(source.inputs)
        options = run.options
        schedule = schedule or schedule_of(trace.track, options, rate_hz)
        name = track.name or trace.path.stem
        say(
            f"preparing {source.title}, OpenGL and metrics; then {schedule.count} refreshes of "
            f"'{name}'{_cost(schedule.count)}"
        )
        gpu = stack.enter_context(Gpu())
        poses = RecordedSource(track)
        poses.start()
        stack.callback(poses.close)
        link_ns = schedule.link_latency_ns(options)
        pipeline = stack.enter_context(
            run.build(gpu, poses, lambda now_ns: track, schedule.age_ns, link_ns, all_pictures=not alone)
        )
        notes[:0] = [*source.notes, *trace.notes(), *source.scene.notes]
        notes.extend([*options.notes, *motion_notes(options, source.scene, pipeline.plan)])
        return ReplaySetup(run, trace, track, schedule, pipeline, notes, stack.pop_all())


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


def _cost(refreshes: int) -> str:
    """Return about how long a long run takes, "" for a short one."""
    if refreshes < _MANY:
        return ""
    least, most = (refreshes * each / 3600 for each in _SECONDS_EACH)
    return f", about {least:.1f} h on a GPU to {most:.1f} h without one; --seconds shows less"


def _both(*takers: Callable[[str], None]) -> Callable[[str], None]:
    def take(text: str) -> None:
        for taker in takers:
            taker(text)

    return take


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


def _on_its_own_clock(trace: LoadedTrace) -> LoadedTrace:
    track = trace.track
    return attrs.evolve(
        trace, track=track.evolve(time_ns=track.time_ns + track.epoch_ns, epoch_ns=0, max_gap_ns=track.max_gap_ns)
    )
