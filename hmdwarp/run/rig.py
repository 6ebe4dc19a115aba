"""Puts together what a run needs: trace, scene, headset, GPU, server, link, compensator, in the order in which they can fail."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from typing import TYPE_CHECKING

import attrs
import numpy as np

from ..auto.levels import QualityLevel
from ..client.plan import Plan, needs_of
from ..errors import InputError
from ..frames import Needs
from ..gpu.context import Gpu
from ..headsets import Headset, load_headset
from ..link.codec import check_codec
from ..pipeline.build import Pipeline, Timing, build_pipeline, expected_age_ns, latency_ns, refreshes_of
from ..pipeline.loop import Loop, PoseRequest
from ..pipeline.options import RunOptions
from ..pipeline.planning import plan_against, plans_for
from ..pipeline.sizes import guarded_size
from ..poses import LoadedTrace, PoseSample, PoseTrack, RecordedSource, load_trace
from ..poses.prediction import predict
from ..poses.predictors import predictors
from ..scenes import Scene, load_scene

if TYPE_CHECKING:
    from ..auto.adaptive import AdaptiveCompensator
    from ..client.compensator import Compensator
    from ..pipeline.channel import Channel
    from ..server import Server


def predictor(track: PoseTrack, method: str, age_ns: int, horizon_ms: float) -> Callable[[int], PoseSample] | None:
    """The head when a frame drawn now will be seen, `age_ns` later, from what is known now; None for no prediction."""
    if method == "none":
        return None
    return lambda now_ns: predict(track, now_ns, now_ns + age_ns, method, round(horizon_ms * 1e6))


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
        raise InputError(
            f"start {options.start_s:g} s: the trace '{track.name}' is {length_s:.3f} s long; start before its end"
        )
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
    notes = [
        f"The trace leaves the part of scene '{scene.name}' one can walk in, so it was moved by ({told}) m to its viewpoint."
    ]
    if beyond > 0:
        notes.append(f"Even so the head leaves that part by up to {beyond:.2f} m and may pass through things.")
    return moved, notes


@attrs.frozen(eq=False)
class Rig:
    """Everything of one replay that is ready to go. Use as a context manager: it frees the GPU at the end."""

    options: RunOptions
    trace: LoadedTrace
    track: PoseTrack
    scene: Scene
    headset: Headset
    size: tuple[int, int]
    timetable: Timetable
    gpu: Gpu
    pipeline: Pipeline
    notes: list[str]
    _cleanup: ExitStack

    @property
    def plan(self) -> Plan:
        """What runs, at first."""
        return self.pipeline.plan

    @property
    def server(self) -> Server:
        """Draws the scene."""
        return self.pipeline.server

    @property
    def channel(self) -> Channel:
        """The frames' way."""
        return self.pipeline.channel

    @property
    def loop(self) -> Loop:
        """One refresh after the other."""
        return self.pipeline.loop

    @property
    def auto(self) -> AdaptiveCompensator | None:
        """What chooses the warp, where something does."""
        return self.pipeline.auto

    @property
    def pixels_per_degree(self) -> float:
        """Of the shown view, as the metrics need it."""
        return self.headset.left_fov.pixels_per_degree(self.size)

    def compensator(self, plan: Plan) -> Compensator:
        """A compensator for another plan on the same frames, freed with the rig."""
        return self.pipeline.compensator(plan)

    def __enter__(self) -> Rig:
        return self

    def __exit__(self, *_: object) -> None:
        self._cleanup.close()


def _on_its_own_clock(trace: LoadedTrace) -> LoadedTrace:
    track = trace.track
    return attrs.evolve(
        trace, track=track.evolve(time_ns=track.time_ns + track.epoch_ns, epoch_ns=0, max_gap_ns=track.max_gap_ns)
    )


def build_rig(options: RunOptions, also: Needs | None = None, levels: tuple[QualityLevel, ...] = ()) -> Rig:
    """Load, check, then start the GPU. also: what frames must carry for other plans than that of the options. rungs: what warp "auto"
    chooses from.

    Errors: InputError and its kin for what was asked, MachineError for what is missing.
    """
    predictors.get(options.predict)
    check_codec(options.coding.codec)
    headset = load_headset(options.headset)
    plans_for(options, headset, None, levels)
    trace = load_trace(options.trace, options.trace_options)
    if options.as_recorded:
        trace = _on_its_own_clock(trace)
    rate_hz = options.rate_hz or headset.refresh_hz
    times = timetable(trace.track, options, rate_hz)
    size = options.size or headset.eye_size_px
    guarded_size(options.guard, headset, size)
    scene = load_scene(options.scene)
    plans = plans_for(options, headset, scene, levels)
    needs = needs_of(plans) | _needs_of_against(options) | (also or Needs())
    track, notes = (trace.track, []) if options.as_recorded else placed(trace.track, scene)
    predicted = predictor(track, options.predict, expected_age_ns(options, times.age_ns), options.horizon_ms)
    with ExitStack() as stack:
        gpu = stack.enter_context(Gpu())
        source = RecordedSource(track)
        source.start()
        stack.callback(source.close)
        requested = PoseRequest(source, predicted, size, options.guard, needs, round(options.scanout_ms * 1e6))
        timing = Timing(rate_hz, times.link_latency_ns(options))
        pipeline = stack.enter_context(
            build_pipeline(gpu, options, scene, headset, plans, requested, timing, headset, levels)
        )
        notes = [*(f"{d}" for d in trace.defects), *scene.notes, *notes]
        return Rig(options, trace, track, scene, headset, size, times, gpu, pipeline, notes, stack.pop_all())


def _needs_of_against(options: RunOptions) -> Needs:
    return plan_against(options.against).needs if options.against else Needs()
