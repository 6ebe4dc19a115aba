"""Puts together what a run needs: trace, scene, headset, GPU, server, link, compensator, in the order in which they can fail."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import ExitStack

import attrs
import numpy as np

from .client.compensator import Compensator
from .client.plan import Plan, build_plan
from .errors import InputError
from .geometry import Pose
from .gpu.context import Gpu
from .gpu.textures import check_size
from .headsets import Headset, load_headset
from .link import ConstantLink
from .loop import Loop
from .options import RunOptions
from .poses import LoadedTrace, PoseSample, PoseTrack, load_trace
from .poses.predict import PREDICTORS, predict
from .registry import unknown_name
from .scenes import Scene, load_scene
from .server import Server


@attrs.frozen(eq=False)
class Requested:
    """Which head poses the server and the display ask for, and how much the server draws."""

    track: PoseTrack
    latency_ns: int
    predictor: str
    horizon_ns: int
    size: tuple[int, int]
    guard: float

    def for_server(self, now_ns: int) -> PoseSample:
        """The pose a frame drawn now is meant for: now's, or the one predicted for when it will be seen."""
        if self.predictor == "none":
            return self.track.at(now_ns)
        return predict(self.track, now_ns, now_ns + self.latency_ns, self.predictor, self.horizon_ns)

    def for_display(self, shown_ns: int) -> PoseSample:
        """The head when the picture is seen."""
        return self.track.at(shown_ns)


@attrs.frozen
class Timetable:
    """When the display refreshes: integer nanoseconds on the trace's clock, evenly spaced from `first_ns`."""

    first_ns: int
    rate_hz: float
    count: int
    warm_up: int

    def instants(self) -> Iterator[tuple[int, bool]]:
        """(time_ns, shown): the refreshes before the first shown one only draw, so that a frame has arrived by then."""
        for k in range(-self.warm_up, self.count):
            yield self.first_ns + round(k * 1e9 / self.rate_hz), k >= 0


def timetable(track: PoseTrack, options: RunOptions, rate_hz: float) -> Timetable:
    """The refreshes of a run. Errors: InputError if nothing of the trace would be shown."""
    length_s = track.duration_ns * 1e-9
    if options.start_s >= length_s:
        raise InputError(f"start {options.start_s:g} s: the trace '{track.name}' is {length_s:.3f} s long; start before its end")
    if options.latency_ms * 1e-3 >= length_s:
        raise InputError(
            f"latency {options.latency_ms:g} ms is longer than the trace '{track.name}' ({length_s:.3f} s): no frame would arrive; "
            "use a shorter latency or a longer trace"
        )
    # Shown from the start asked for, or from when the first frame can have arrived, whichever is later.
    start_s = max(options.start_s, options.latency_ms * 1e-3)
    left_s = length_s - start_s
    seconds = left_s if options.seconds is None else min(options.seconds, left_s)
    first_ns = track.start_ns + round(start_s * 1e9)
    warm_up = math.floor((first_ns - track.start_ns) * 1e-9 * rate_hz + 1e-6)
    needed = math.ceil(options.latency_ms * 1e-3 * rate_hz - 1e-6)
    if needed > warm_up:  # between two refreshes: the first frame then arrives one refresh later
        first_ns += round((needed - warm_up) * 1e9 / rate_hz)
        warm_up, seconds = needed, seconds - (needed - warm_up) / rate_hz
    return Timetable(first_ns, rate_hz, max(1, math.floor(seconds * rate_hz + 1e-6)), min(warm_up, needed))


def placed(track: PoseTrack, scene: Scene) -> tuple[PoseTrack, list[str]]:
    """The track where the scene can be walked in, and what had to be done for that.

    A track that stays within the scene's walking bounds stays as it is. Others (recorded in other rooms and units) are moved, not
    turned, so that their mean position is the scene's viewpoint.
    """
    low, high = scene.walk_bounds_m
    if ((track.position_m >= low) & (track.position_m <= high)).all():
        return track, []
    shift = scene.viewpoint.position_m - track.position_m.mean(axis=0)
    moved = track.evolve(position_m=track.position_m + shift)
    beyond = float(np.maximum(low - moved.position_m, moved.position_m - high).max())
    told = ", ".join(f"{x:+.2f}" for x in shift)
    notes = [f"The trace leaves the part of scene '{scene.name}' one can walk in, so it was moved by ({told}) m to its viewpoint."]
    if beyond > 0:
        notes.append(f"Even so the head leaves that part by up to {beyond:.2f} m and may pass through things.")
    return moved, notes


@attrs.frozen(eq=False)
class Rig:
    """Everything of one run that is ready to go. Use as a context manager: it frees the GPU at the end."""

    options: RunOptions
    trace: LoadedTrace
    track: PoseTrack
    scene: Scene
    headset: Headset
    size: tuple[int, int]
    plan: Plan
    timetable: Timetable
    gpu: Gpu
    server: Server
    link: ConstantLink
    loop: Loop
    notes: list[str]
    _cleanup: ExitStack

    @property
    def pixels_per_degree(self) -> float:
        """Of the shown view, as the metrics need it."""
        return self.headset.left_fov.pixels_per_degree(self.size)

    def compensator(self, plan: Plan) -> Compensator:
        """A compensator for another plan on the same frames, freed with the rig."""
        made = _compensator(self.gpu, plan, self.headset, self.size, self.options.guard, self.server)
        self._cleanup.callback(made.close)
        return made

    def __enter__(self) -> Rig:
        return self

    def __exit__(self, *_: object) -> None:
        self._cleanup.close()


def _compensator(gpu: Gpu, plan: Plan, headset: Headset, size: tuple[int, int], guard: float, server: Server) -> Compensator:
    late_size = headset.fov(0).guarded(guard, size)[1]
    return Compensator(gpu, plan, headset, late_size, size, server.draw_depth)


def build_rig(options: RunOptions) -> Rig:
    """Load, check, then start the GPU. Errors: InputError and its kin for what was asked, MachineError for what is missing."""
    if options.predict not in PREDICTORS:
        raise unknown_name("predictor", options.predict, sorted(PREDICTORS))
    headset = load_headset(options.headset)
    plan = build_plan_for(options, headset, None)
    trace = load_trace(options.trace, options.trace_options)
    times = timetable(trace.track, options, options.rate_hz or headset.refresh_hz)
    scene = load_scene(options.scene)
    plan = build_plan_for(options, headset, scene)
    track, notes = placed(trace.track, scene)
    size = options.size or headset.eye_size_px
    with ExitStack() as stack:
        gpu = stack.enter_context(Gpu())
        late_size = headset.fov(0).guarded(options.guard, size)[1]
        check_size(gpu.gl, size)
        check_size(gpu.gl, late_size)
        server = Server(gpu, scene)
        stack.callback(server.close)
        latency_ns = round(options.latency_ms * 1e6)
        link: ConstantLink = ConstantLink(latency_ns, server.recycle)
        stack.callback(link.close)
        compensator = _compensator(gpu, plan, headset, size, options.guard, server)
        stack.callback(compensator.close)
        requested = Requested(track, latency_ns, options.predict, round(options.horizon_ms * 1e6), size, options.guard)
        loop = Loop(requested, server, link, compensator, headset)
        notes = [*(f"{d}" for d in trace.defects), *scene.notes, *notes]
        return Rig(options, trace, track, scene, headset, size, plan, times, gpu, server, link, loop, notes, stack.pop_all())


def build_plan_for(options: RunOptions, headset: Headset, scene: Scene | None) -> Plan:
    """The plan of a run. Without a scene yet, only the names are checked. Errors: as build_plan; a lens the headset has not."""
    from .scenes.effects import SceneEffect

    if options.lens != "none" and headset.lens is None:
        raise InputError(f"headset '{headset.name}' has no lens, so --lens {options.lens} cannot be applied: use --lens none")
    effects = scene.effects if scene is not None else SceneEffect.NONE
    return build_plan(effects, options.warp, options.fill, options.lens, client_geometry=True)


__all__ = ["Pose", "Requested", "Rig", "RunOptions", "Timetable", "build_plan_for", "build_rig", "placed", "timetable"]
