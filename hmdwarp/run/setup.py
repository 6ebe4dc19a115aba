"""The set-up of every run: its refresh times, and from its options to a pipeline, failing early."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections.abc import Callable, Iterator, Sequence
from typing import ClassVar, Generic, TypeVar

import attrs
import numpy as np

from ..client.plan import Plan, needs_of
from ..display import Display
from ..errors import InputError
from ..frames import Needs
from ..frames.layers import PICTURE
from ..geometry import Eyes, Pose
from ..gpu.context import Gpu
from ..headsets import Headset
from ..link import CHANGES
from ..pipeline.build import Pipeline, build_pipeline
from ..pipeline.frame_coder import Reads
from ..pipeline.options import PREDICTED_GAZE, PipelineOptions
from ..pipeline.planning import plans_for
from ..pipeline.recorded_renderer import MomentOf
from ..pipeline.sizes import expected_age_ns, guarded_size, latency_ns, refreshes_of
from ..pipeline.source import FirstRequest, PoseRequest, Source, Target
from ..poses import LoadedTrace, PoseSample, PoseSource, PoseTrack, foreseen_gaze, gaze_of, jumps_between
from ..poses.prediction import predict
from ..poses.track import Gaze, Moment
from .options import RunOptions

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

    Errors: InputError if the run would show nothing.
    """
    if source.instants_ns and not options.trace and options.rate_hz is None:
        return _at_instants(source.instants_ns, source.headset.refresh_hz, str(trace.path), options)
    return schedule_of(trace.track, options, rate_hz)


def _at_instants(times: Sequence[int], rate_hz: float, place: str, options: RunOptions) -> Schedule:
    """Return refreshes at the instants of the frames, where the truth is what was recorded.

    The first is at the requested start, or when the first frame can have arrived.
    """
    if len(times) < 2:
        raise InputError(f"{place}: one frame; expected two or more: one that is late, and what is seen then")
    age, _ = _refreshes_before(options, rate_hz)
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
    return Schedule(times[first], rate_hz, max(1, end - first), age, instants_ns=instants)


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


KEPT_NS = 1_000_000_000


def pose_request(
    options: PipelineOptions,
    source: PoseSource,
    known: Callable[[int], PoseTrack],
    age_ns: int,
    size: tuple[int, int],
    needs: Needs,
    *,
    pictures: frozenset[str] = frozenset(PICTURE),
) -> PoseRequest:
    """Return the poses and picture format for the server.

    known(now_ns): head motion up to that instant, and maybe later. age_ns: from drawing a frame to
    showing it. size: (w, h) of one eye. pictures: as of PoseRequest.
    """

    def predicted(now_ns: int, ahead_ns: int) -> PoseSample:
        return predict(known(now_ns), now_ns, now_ns + ahead_ns, options.predict, options.horizon_ns)

    def gaze(now_ns: int, ahead_ns: int, head: Pose) -> Gaze | None:
        return foreseen_gaze(known(now_ns), now_ns, ahead_ns if options.gaze == PREDICTED_GAZE else 0, head)

    predicts = predicted if options.predict != "none" else None
    # What has moved since a frame was sent is known from its picture.
    pictures |= frozenset(PICTURE if options.network.send == CHANGES else ())
    scanout_ns = round(options.scanout_ms * 1e6)
    looks = gaze if options.fovea is not None else None
    return PoseRequest(source, predicts, size, options.guard_band, needs, scanout_ns, age_ns, pictures, looks)


class RecentPoses:
    """A pose source that keeps the last second of its answers.

    A recentre, a snap turn or a teleport is a jump of the track, as in a recording.
    """

    def __init__(self, source: PoseSource) -> None:
        self._source = source
        self._kept: list[PoseSample] = []

    def start(self) -> None:
        """Start the source."""
        self._source.start()

    def head_at(self, time_ns: int) -> PoseSample:
        """Return the source's pose, and keep it."""
        sample = self._source.head_at(time_ns)
        kept = self._kept
        # What was foretold before a jump, for the display, is of where the head is no more.
        while kept and kept[-1].time_ns >= sample.time_ns and jumps_between([sample, kept[-1]]):
            kept.pop()
        at = bisect_left(kept, sample.time_ns, key=lambda pose: pose.time_ns)
        # Within known motion nothing is added; between the sides of a jump it says which is now.
        if at == len(kept) or (at and kept[at].time_ns > sample.time_ns and jumps_between([kept[at - 1], kept[at]])):
            kept.insert(at, sample)
            del kept[: bisect_left(kept, sample.time_ns - KEPT_NS, key=lambda pose: pose.time_ns)]
        return sample

    def track_until(self, now_ns: int) -> PoseTrack:
        """Return the last second of motion, including the current pose."""
        self.head_at(now_ns)
        kept = self._kept
        return PoseTrack(
            time_ns=np.array([pose.time_ns for pose in kept]),
            position_m=np.array([pose.pose.position_m for pose in kept]),
            orientation_xyzw=np.array([pose.pose.orientation_xyzw for pose in kept]),
            jumps=jumps_between(kept),
            gaze=gaze_of(kept),
        )

    def close(self) -> None:
        """Close the source."""
        self._source.close()


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
        """(w, h) of one eye."""
        return self.headset.eye_size_px

    @property
    def rate_hz(self) -> float:
        """Refreshes per second."""
        return self.headset.refresh_hz


@attrs.frozen(eq=False)
class RunSetup(Generic[Options]):
    """A run that is checked, on a display: what it shows, by which plans."""

    # Its size is that of the display, where none is set.
    options: Options
    source: Source
    screen: Display | EmulatedScreen
    # One, or one for each quality level.
    plans: list[Plan]
    # Of all plans on its frames.
    needs: Needs

    @classmethod
    def of(
        cls, options: Options, source: Source, screen: Display | EmulatedScreen, also: Needs | None = None
    ) -> RunSetup[Options]:
        """Return a run that is checked.

        screen: gives size and rate to options that set none. also: needs of further plans.
        Errors: InputError.
        """
        options = attrs.evolve(options, size=options.size or screen.size)
        beyond = {name: getattr(screen, name) for name in ("distorts", "takes_depth", "takes_panels")}
        plans = plans_for(options, screen.headset, source.scene, **beyond)
        run = cls(options, source, screen, plans, needs_of(plans) | (also or Needs()))
        source.check(plans, run.needs)
        source.check_eyes(run.needs, len(screen.eyes.views(Pose())))
        guarded_size(options.guard_band, screen.eyes, run.size)
        return run

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) of one eye."""
        assert self.options.size is not None
        return self.options.size

    @property
    def rate_hz(self) -> float:
        """Refreshes per second."""
        return self.options.rate_hz or self.screen.rate_hz

    def measured(
        self,
        head: PoseSample,
        *,
        holds: bool,
        keeps: bool = False,
        all_pictures: bool = False,
        say: Callable[[str], None],
    ) -> RunSetup[Options]:
        """Return the run with its real latency, where its frames come from elsewhere.

        all_pictures: as of build.
        Errors: as Source.measured.
        """
        views = self.screen.eyes.views(head.pose)
        first = FirstRequest(
            head=head,
            views=views,
            rate_hz=self.rate_hz,
            needs=self.needs,
            pictures=self._pictures(everything=all_pictures),
            holds=holds,
            keeps=keeps,
            say=say,
        )
        return attrs.evolve(self, options=self.source.measured(self.options, first))

    def _pictures(self, *, everything: bool) -> frozenset[str]:
        return Reads.of(self.plans).pictures | frozenset(PICTURE if everything else ())

    def build(
        self,
        gpu: Gpu,
        poses: PoseSource,
        known: Callable[[int], PoseTrack],
        plain_age_ns: int,
        link_latency_ns: int,
        *,
        all_pictures: bool = False,
        moment_of: MomentOf = Moment,
    ) -> Pipeline:
        """Return the pipeline.

        known: motion of the head up to an instant. plain_age_ns: as of expected_age_ns.
        all_pictures: draw pictures even if no plan reads them.
        Errors: as build_pipeline.
        """
        age_ns = expected_age_ns(self.options, plain_age_ns, self.rate_hz)
        pictures = self._pictures(everything=all_pictures)
        request = pose_request(self.options, poses, known, age_ns, self.size, self.needs, pictures=pictures)
        target = Target(gpu, self.screen.eyes, self.rate_hz, link_latency_ns, self.screen.headset)
        return build_pipeline(self.options, self.source, target, self.plans, request, moment_of)
