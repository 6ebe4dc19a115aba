"""Puts together what a run needs: trace, scene, headset, GPU, server, link, compensator, in the order in which they can fail."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack

import attrs
import numpy as np

from .channel import Channel, Coder
from .client.adaptive import AdaptiveCompensator
from .client.choice import Rung
from .client.compensator import Compensator
from .client.governor import Governor
from .client.history import History
from .client.plan import Plan, build_plan, needs_of
from .client.weight import EyeSizes, eye_bytes
from .client_scene import ClientScene
from .codec import CODECS, check_codec
from .errors import InputError, MachineError
from .frame import Needs
from .geometry.cube import cube_size
from .geometry.wide import wide_size
from .gpu.context import Gpu
from .gpu.textures import check_size
from .headsets import Headset, load_headset
from .loop import Loop
from .options import AUTO, RunOptions
from .poses import LoadedTrace, PoseSample, PoseSource, PoseTrack, RecordedSource, load_trace
from .poses.predict import PREDICTORS, predict
from .registry import unknown_name
from .scenes import Scene, load_scene
from .scenes.effects import SceneEffect, asked_effects, effect_names
from .server import Server


@attrs.frozen(eq=False)
class Requested:
    """Which head poses the server and the display ask for, what the server draws, and how long the display takes to show it."""

    source: PoseSource
    predicted: Callable[[int], PoseSample] | None
    size: tuple[int, int]
    guard: float
    needs: Needs
    scanout_ns: int = 0

    def for_server(self, now_ns: int) -> PoseSample:
        """The pose a frame drawn now is meant for: now's, or the one predicted for when it will be seen."""
        return self.source.head_at(now_ns) if self.predicted is None else self.predicted(now_ns)

    def for_display(self, shown_ns: int) -> PoseSample:
        """The head when the picture is seen."""
        return self.source.head_at(shown_ns)


def predictor(track: PoseTrack, method: str, age_ns: int, horizon_ms: float) -> Callable[[int], PoseSample] | None:
    """The head when a frame drawn now will be seen, `age_ns` later, from what is known now; None for no prediction."""
    if method == "none":
        return None
    return lambda now_ns: predict(track, now_ns, now_ns + age_ns, method, round(horizon_ms * 1e6))


# A latency this near to a whole number of refreshes means that number: 16.67 ms is one refresh at 60 Hz, not a little more.
_SAME_REFRESH = 1e-3


def refreshes_of(latency_ms: float, rate_hz: float) -> int:
    """How many refreshes after it was drawn a frame is shown: it waits for the next one after it has arrived."""
    return math.ceil(latency_ms * 1e-3 * rate_hz - _SAME_REFRESH)


def frames_held(options: RunOptions, rate_hz: float, needs: Needs) -> int:
    """The most frames there are at a time: under way, shown, being drawn, and older ones kept."""
    if options.network.is_plain:
        return refreshes_of(options.latency_ms, rate_hz) + 2 + needs.past
    return options.network.most_under_way(latency_ns(options), rate_hz) + 2 + needs.past


def latency_ns(options: RunOptions) -> int:
    """What was asked for."""
    return round(options.latency_ms * 1e6)


@attrs.frozen
class Timetable:
    """When the display refreshes: integer nanoseconds on the trace's clock, evenly spaced.

    first_ns: of the first shown refresh; `count` are shown. age: how many refreshes after it was drawn a frame is shown.
    """

    first_ns: int
    rate_hz: float
    count: int
    age: int

    @property
    def age_ns(self) -> int:
        """From drawing to showing, within 1 ns."""
        return round(self.age * 1e9 / self.rate_hz)

    def link_latency_ns(self, options: RunOptions) -> int:
        """What the link delays by: no more than lies between any two refreshes `age` apart, which are rounded to whole ns."""
        return min(latency_ns(options), max(0, self.age_ns - 2)) if options.network.is_plain else latency_ns(options)

    def instants(self) -> Iterator[tuple[int, bool]]:
        """(time_ns, shown): the refreshes before the first shown one only draw, so that a frame has arrived by then."""
        for k in range(-self.age, self.count):
            yield self.first_ns + round(k * 1e9 / self.rate_hz), k >= 0


def timetable(track: PoseTrack, options: RunOptions, rate_hz: float) -> Timetable:
    """The refreshes of a run: from the start asked for, or from when the first frame can have arrived where that is later, for
    as many whole refreshes as fit into the seconds asked for and into the trace, but one at least.

    Errors: InputError if nothing of the trace would be shown.
    """
    length_s = track.duration_ns * 1e-9
    if length_s == 0:
        raise InputError(f"the trace '{track.name}' has a single sample: wanted head motion over time")
    if options.start_s >= length_s:
        raise InputError(f"start {options.start_s:g} s: the trace '{track.name}' is {length_s:.3f} s long; start before its end")
    options.network.check(latency_ns(options))
    age = refreshes_of(options.network.longest_ns(latency_ns(options)) / 1e6, rate_hz)
    if age / rate_hz > length_s:
        raise InputError(
            f"latency {options.latency_ms:g} ms is longer than the trace '{track.name}' ({length_s:.3f} s): no frame would arrive; "
            "use a shorter latency or a longer trace"
        )
    start_s = max(options.start_s, age / rate_hz)
    seconds = length_s - start_s if options.seconds is None else min(options.seconds, length_s - start_s)
    # 1e-6 of a refresh: 1 s at 90 Hz is 90 refreshes, whatever its last bits say.
    return Timetable(track.start_ns + round(start_s * 1e9), rate_hz, max(1, math.floor(seconds * rate_hz + 1e-6)), age)


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
    geometry: ClientScene
    channel: Channel
    history: History
    loop: Loop
    auto: AdaptiveCompensator | None
    notes: list[str]
    _cleanup: ExitStack

    @property
    def pixels_per_degree(self) -> float:
        """Of the shown view, as the metrics need it."""
        return self.headset.left_fov.pixels_per_degree(self.size)

    def compensator(self, plan: Plan) -> Compensator:
        """A compensator for another plan on the same frames, freed with the rig."""
        made = _compensator(self.gpu, plan, self.headset, self.size, self.options.guard, self.geometry)
        self._cleanup.callback(made.close)
        return made

    def __enter__(self) -> Rig:
        return self

    def __exit__(self, *_: object) -> None:
        self._cleanup.close()


def _compensator(gpu: Gpu, plan: Plan, headset: Headset, size: tuple[int, int], guard: float, geometry: ClientScene) -> Compensator:
    late_size = guarded_size(guard, headset, size)
    return Compensator(gpu, plan, headset, late_size, size, geometry)


def build_rig(options: RunOptions, also: Needs | None = None, rungs: tuple[Rung, ...] = ()) -> Rig:
    """Load, check, then start the GPU. also: what frames must carry for other plans than that of the options. rungs: what warp "auto"
    chooses from.

    Errors: InputError and its kin for what was asked, MachineError for what is missing.
    """
    if options.predict not in PREDICTORS:
        raise unknown_name("predictor", options.predict, sorted(PREDICTORS))
    check_codec(options.coding.codec)
    headset = load_headset(options.headset)
    plans_for(options, headset, None, rungs)
    trace = load_trace(options.trace, options.trace_options)
    times = timetable(trace.track, options, options.rate_hz or headset.refresh_hz)
    size = options.size or headset.eye_size_px
    guarded_size(options.guard, headset, size)
    scene = load_scene(options.scene)
    plans = plans_for(options, headset, scene, rungs)
    needs = needs_of(plans) | _needs_of_against(options) | (also or Needs())
    track, notes = placed(trace.track, scene)
    with ExitStack() as stack:
        gpu = stack.enter_context(Gpu())
        check_room(gpu, options, headset, needs)
        server = Server(gpu, scene, options.mirrors)
        stack.callback(server.close)
        geometry = ClientScene(server)
        stack.callback(geometry.close)
        history = History(needs.past, needs.past_spacing_ns, server.recycle)
        stack.callback(history.close)
        channel = _channel(options, headset, times, plans, history, server)
        stack.callback(channel.close)
        compensators = []
        for plan in plans:
            compensators.append(_compensator(gpu, plan, headset, size, options.guard, geometry))
            stack.callback(compensators[-1].close)
        auto = _adaptive(options, rungs, compensators) if rungs else None
        compensator = auto or compensators[0]
        source = RecordedSource(track)
        source.start()
        stack.callback(source.close)
        predicted = predictor(track, options.predict, _expected_age_ns(options, times), options.horizon_ms)
        requested = Requested(source, predicted, size, options.guard, needs, round(options.scanout_ms * 1e6))
        loop = Loop(requested, server, channel, history, compensator, headset)
        notes = [*(f"{d}" for d in trace.defects), *scene.notes, *notes]
        told = (options, trace, track, scene, headset, size, compensator.plan, times)
        return Rig(*told, gpu, server, geometry, channel, history, loop, auto, notes, stack.pop_all())


def _expected_age_ns(options: RunOptions, times: Timetable) -> int:
    """How old a frame will be when it is seen, as far as one can know."""
    return times.age_ns if options.network.is_plain else options.network.typical_ns(latency_ns(options))


def _channel(options: RunOptions, headset: Headset, times: Timetable, plans: Sequence[Plan], history: History, server: Server) -> Channel:
    reads = {name for plan in plans for name in plan.layers}
    sizes = eye_sizes(options, headset)
    weight = 2 * sum(eye_bytes(needs_of(plans), sizes, reads).values())
    coder = None
    if not CODECS.get(options.coding.codec).is_none:
        coder = Coder(options.coding, sizes.late, times.rate_hz, sends_depth="late.inverse_depth" in reads)
    return Channel(options.network, times.link_latency_ns(options), coder, weight, history.offer, server.recycle)


def _adaptive(options: RunOptions, rungs: tuple[Rung, ...], compensators: list[Compensator]) -> AdaptiveCompensator:
    return AdaptiveCompensator(Governor(rungs, options.budget_ms), dict(zip(rungs, compensators, strict=True)))


def _needs_of_against(options: RunOptions) -> Needs:
    return plan_against(options).needs if options.against else Needs()


def plan_against(options: RunOptions) -> Plan:
    """Of the warp that is compared with: nothing but the warp, without fill, effects and lens."""
    return build_plan(SceneEffect.NONE, options.against, "none", "none", client_geometry=True)


def guarded_size(guard: float, headset: Headset, size: tuple[int, int]) -> tuple[int, int]:
    """(w, h) of what the server draws for one eye. Errors: InputError for a guard that leaves the half-space in front of the eye."""
    try:
        return headset.fov(0).guarded(guard, size)[1]
    except InputError as error:
        raise InputError(f"guard {guard:g} on headset '{headset.name}': {error}; use a smaller guard") from error


def eye_sizes(options: RunOptions, headset: Headset) -> EyeSizes:
    """What one eye's pictures measure in a run. Errors: as guarded_size."""
    size = options.size or headset.eye_size_px
    fov = headset.fov(0)
    return EyeSizes(guarded_size(options.guard, headset, size), size, cube_size(fov, size), wide_size(fov, size))


def check_room(gpu: Gpu, options: RunOptions, headset: Headset, needs: Needs) -> None:
    """Errors: InputError beyond the GL limit; MachineError where the frames under way alone would fill the machine's memory."""
    check_size(gpu.gl, options.size or headset.eye_size_px)
    sizes = eye_sizes(options, headset)
    late_size = sizes.late
    if max(late_size) > gpu.max_texture_size:
        found = f"guard {options.guard:g} makes frames of {late_size[0]}x{late_size[1]} pixels"
        raise InputError(f"{found}: wanted at most {gpu.max_texture_size} on each side (this GPU's limit)")
    frames = frames_held(options, options.rate_hz or headset.refresh_hz, needs)
    needed = frames * 2 * sum(eye_bytes(needs, sizes).values())
    if gpu.is_software and needed > memory_bytes():
        raise MachineError(
            f"latency {options.latency_ms:g} ms keeps {frames} frames of 2x{late_size[0]}x{late_size[1]} pixels, {needed / 1e9:.1f} GB, "
            f"and this machine has {memory_bytes() / 1e9:.1f} GB: use a smaller size, a shorter latency or a lower rate"
        )


def memory_bytes() -> float:
    """Of the whole machine; infinite where it does not say."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, ValueError, OSError):
        return math.inf


def plans_for(options: RunOptions, headset: Headset, scene: Scene | None, rungs: tuple[Rung, ...]) -> list[Plan]:
    """The plan of a run in a list; of a run that chooses by itself, that of each rung. Errors: as build_plan_for."""
    chosen = [options.with_pair(rung.warp, rung.fill) for rung in rungs] if options.warp == AUTO else [options]
    return [build_plan_for(one, headset, scene) for one in chosen]


def build_plan_for(options: RunOptions, headset: Headset, scene: Scene | None) -> Plan:
    """The plan of a run. Without a scene yet, only the names are checked. Errors: as build_plan; a lens the headset has not."""
    if options.lens != "none" and headset.lens is None:
        raise InputError(f"headset '{headset.name}' has no lens, so --lens {options.lens} cannot be applied: use --lens none")
    calls_for = scene.effects if scene is not None else SceneEffect.NONE
    effects = asked_effects(options.effects, calls_for)
    if options.against:
        plan_against(options)
    told = {"forced": effect_names(effects & ~calls_for), "forbidden": effect_names(calls_for & ~effects)}
    fused, scanout = options.fused, options.scanout_ms > 0 and options.follow_scanout
    return build_plan(effects, options.warp, options.fill, options.lens, client_geometry=True, fused=fused, scanout=scanout, **told)
