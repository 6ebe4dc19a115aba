"""Set-up of a replay, in an order that fails early."""

from __future__ import annotations

import functools
import operator
from collections.abc import Callable
from contextlib import ExitStack
from typing import TYPE_CHECKING

import attrs
import numpy as np

from ..client.plan import Plan, needs_of
from ..errors import InputError
from ..frames import Needs
from ..geometry import Pose
from ..gpu.context import Gpu
from ..headsets import Headset, load_headset
from ..pipeline.auto.levels import QualityLevel
from ..pipeline.build import Pipeline, Target, build_pipeline, expected_age_ns
from ..pipeline.feed_coding import wish_of
from ..pipeline.layers_read import Reads
from ..pipeline.loop import Loop
from ..pipeline.planning import plan_against, plans_for
from ..pipeline.recorded_scene import RecordedScene, fitted, headset_of, scene_of
from ..pipeline.remote import Remote, check_carried, check_remote
from ..pipeline.remote_server import SERVER_SCENE, scene_elsewhere
from ..pipeline.sizes import guarded_size
from ..poses import LoadedTrace, PoseTrack, RecordedSource, load_trace
from ..scenes import Scene
from .host import refuse_one_eye
from .options import RunOptions
from .pose_request import check_names, pose_request
from .recorded_frames import ONE_EYE, beside, own_trace, recorded_notes, schedule_at_frames
from .schedule import Schedule, schedule_of

if TYPE_CHECKING:
    from ..client.compensator import Compensator
    from ..pipeline.auto.adaptive import AdaptiveCompensator
    from ..pipeline.channel import Channel
    from ..sources.sequences import Sequence
    from ..sources.server import Server


@attrs.frozen(eq=False)
class ReplaySetup:
    """Everything that one replay runs on.

    Use as a context manager: it frees the GPU on exit.
    """

    options: RunOptions
    trace: LoadedTrace
    # The trace, moved to where the scene can be walked in.
    track: PoseTrack
    scene: Scene
    headset: Headset
    # (w, h) of one eye.
    size: tuple[int, int]
    schedule: Schedule
    gpu: Gpu
    pipeline: Pipeline
    # Draws the frames; None where they are drawn here.
    remote: Remote | None
    notes: list[str]
    _cleanup: ExitStack

    @property
    def plan(self) -> Plan:
        """The plan that runs first."""
        return self.pipeline.plan

    @property
    def server(self) -> Server:
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
    def auto(self) -> AdaptiveCompensator | None:
        """Chooses the warp; None where the options name one."""
        return self.pipeline.auto

    @property
    def true_eyes(self) -> int:
        """How many eyes have a truth: of recorded frames the camera's alone."""
        return 1 if self.options.is_recorded else 2

    @property
    def pixels_per_degree(self) -> float:
        """Resolution of the shown view, for the metrics."""
        return self.headset.left_fov.pixels_per_degree(self.size)

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
    levels: tuple[QualityLevel, ...] = (),
    say: Callable[[str], None] = lambda text: None,
    *,
    alone: bool = False,
) -> ReplaySetup:
    """Load, check, then start the GPU.

    also: layers that frames must carry for plans other than the run's. levels: candidates of warp
    "auto". say: called with a sentence once all is checked, before what takes seconds. alone:
    whether other plans on these frames take their inputs from WholePictures; a picture that the
    run's own plan does not read is not drawn then.
    Errors: InputError and its subclasses for wrong options, MachineError for missing hardware or
    software.
    """
    check_names(options)
    scene = scene_of(options) if options.is_recorded else None
    sequence = scene.sequence if isinstance(scene, RecordedScene) else None
    options = fitted(options, scene) if scene is not None else options
    headset = load_headset(options.headset) if scene is None else headset_of(options, scene)
    plans_for(options, headset, None, levels)
    against = _needs_of_against(options)
    trace = _trace(options, sequence)
    rate_hz = options.rate_hz or headset.refresh_hz
    schedule = None if options.feed.is_used else schedule_for(options, sequence, trace, rate_hz)
    size = options.size or headset.eye_size_px
    guarded_size(options.guard_band, headset, size)
    if options.feed.is_used:
        check_remote(options, recorded=sequence is not None)
    scene = scene or _scene(options)
    plans = plans_for(options, headset, scene, levels)
    needs = needs_of(plans) | against | (also or Needs())
    refuse_one_eye(needs, len(headset.views(Pose())) if sequence is None else 1, ONE_EYE)
    track, notes = (trace.track, []) if options.as_recorded else placed(trace.track, scene)
    name = track.name or trace.path.stem
    with ExitStack() as stack:
        remote = None
        if options.feed.is_used:
            check_carried(needs)
            remote = Remote(options.feed, holds=True, keeps=True, say=_both(say, notes.append))
            stack.callback(remote.close)
            options = _with_latency_to(remote, options, headset, size, track, rate_hz, needs)
        if schedule is None:
            schedule = schedule_of(trace.track, options, rate_hz)
        say(f"making ready: {_seen(scene, sequence)}, OpenGL, measuring; then {schedule.count} refreshes of '{name}'")
        gpu = stack.enter_context(Gpu())
        source = RecordedSource(track)
        source.start()
        stack.callback(source.close)
        age_ns = expected_age_ns(options, schedule.age_ns, rate_hz)
        pictures = not alone or Reads.of(plans).pictures
        request = pose_request(options, source, lambda now_ns: track, age_ns, size, needs, pictures=pictures)
        target = Target(gpu, headset, rate_hz, schedule.link_latency_ns(options), headset)
        pipeline = stack.enter_context(build_pipeline(options, scene, target, plans, request, levels, remote))
        notes[:0] = [*recorded_notes(options, scene), *trace.notes(), *scene.notes]
        notes.extend(options.notes)
        parts = (options, trace, track, scene, headset, size, schedule, gpu, pipeline, remote, notes)
        return ReplaySetup(*parts, stack.pop_all())


def _scene(options: RunOptions) -> Scene:
    if options.scene != SERVER_SCENE:
        return scene_of(options)
    if not options.feed.is_used:
        raise InputError(f"--scene {SERVER_SCENE}: it is what the server at --connect draws: name that, or a scene")
    return scene_elsewhere(options.feed.connect)


def _both(*takers: Callable[[str], None]) -> Callable[[str], None]:
    def take(text: str) -> None:
        for taker in takers:
            taker(text)

    return take


def _with_latency_to(
    remote: Remote,
    options: RunOptions,
    headset: Headset,
    size: tuple[int, int],
    track: PoseTrack,
    rate_hz: float,
    needs: Needs,
) -> RunOptions:
    """Return the options with the latency that is measured, in place of the one that is set."""
    head = track.at(track.start_ns)
    views = headset.views(head.pose)
    remote.wish = wish_of(options.coding, rate_hz, views, size, options.latency_ms * 1e-3)
    longest_ns = remote.measure(head, views, options.guard_band, size, needs)
    remote.wish = wish_of(options.coding, rate_hz, views, size, longest_ns * 1e-9 + 1 / rate_hz)
    return attrs.evolve(options, latency_ms=longest_ns / 1e6)


def schedule_for(options: RunOptions, sequence: Sequence | None, trace: LoadedTrace, rate_hz: float) -> Schedule:
    """Return the refreshes of a run: evenly spaced, or at the instants of recorded frames."""
    if sequence is not None and not options.trace and options.rate_hz is None:
        return schedule_at_frames(sequence, options)
    return schedule_of(trace.track, options, rate_hz)


def _trace(options: RunOptions, sequence: Sequence | None) -> LoadedTrace:
    """Return the head's motion: a trace, or that of the recorded frames."""
    if sequence is not None and not options.trace:
        return own_trace(sequence)
    trace = load_trace(options.trace, options.trace_options)
    if sequence is not None:
        return beside(trace, sequence)
    return _on_its_own_clock(trace) if options.as_recorded else trace


def _seen(scene: Scene, sequence: Sequence | None) -> str:
    return f"scene '{scene.name}'" if sequence is None else f"recorded frames '{scene.name}'"


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


def _needs_of_against(options: RunOptions) -> Needs:
    return functools.reduce(operator.or_, (plan_against(options, *pair).needs for pair in options.compared), Needs())
