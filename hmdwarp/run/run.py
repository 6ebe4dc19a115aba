"""One run: what it shows, on which display, by which plans; checked first, then made on a GPU."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import Any, ClassVar, Generic, Self, TypeVar

import attrs

from ..client import ClientScene
from ..client.classes import load_client
from ..client.compensator import Compensator, EyeResult
from ..client.inputs import PassInputs
from ..client.plan import Plan, needs_of
from ..display import Display
from ..errors import InputError
from ..frames import EyeSizes, Needs, frame_bytes, video_pixels
from ..frames.layers import PICTURE
from ..geometry import Eyes, Pose
from ..gpu.context import Gpu
from ..headsets import Headset
from ..link import CHANGES, RESOLUTION
from ..link.codec import codecs
from ..pipeline.channel import Changes, Channel, Coder, Reads
from ..pipeline.governor import AdaptiveCompensator, Governor
from ..pipeline.loop import Loop
from ..pipeline.options import PREDICTED_GAZE, REMOTE, PipelineOptions
from ..pipeline.sizes import check_held, expected_age_ns, eye_sizes, guarded_size, plans_for
from ..pipeline.source import MomentOf, PoseRequest, Source, Target, client_scene, joined
from ..poses import PoseSample, PoseSource, PoseTrack, foreseen_gaze
from ..poses.prediction import predict
from ..poses.track import Gaze, Moment
from ..sources.server import Renderer

Options = TypeVar("Options", bound=PipelineOptions)


class SizedCompensator(Compensator):
    """Compensate frames of any size: passes for another than `rendered` are made when one comes.

    What a pass remembers of earlier refreshes is of one size.
    """

    def __init__(
        self, gpu: Gpu, plan: Plan, headset: Headset | None, rendered: tuple[int, int], *more: Any, hides: bool = False
    ) -> None:
        super().__init__(gpu, plan, headset, rendered, *more, hides=hides)
        self._full_size = rendered
        self._others: dict[tuple[int, int], Compensator] = {}
        self._make: Callable[[tuple[int, int]], Compensator] = lambda size: Compensator(
            gpu, plan, headset, size, *more, hides=hides
        )

    def run(self, inputs: PassInputs) -> EyeResult:
        """Run the plan on a frame of its size; see Compensator.run."""
        size = inputs.rendered.size
        if size == self._full_size:
            return super().run(inputs)
        if size not in self._others:
            self._others[size] = self._make(size)
        return self._others[size].run(inputs)

    def close(self) -> None:
        """Free every texture and buffer of all sizes."""
        super().close()
        for other in self._others.values():
            other.close()


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


@attrs.define(eq=False)
class Run(Generic[Options]):
    """What a driver runs: `of` checks it, `start` makes it on a GPU, which belongs to the caller.

    Use as a context manager: it frees what it has made.
    """

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
        all_pictures: draw pictures even if no plan reads them.
        Errors: InputError.
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
        """Connect, and take the real latency, where frames come from elsewhere.

        Errors: as Source.measured.
        """
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

        def predicted(now_ns: int, ahead_ns: int) -> PoseSample:
            return predict(known(now_ns), now_ns, now_ns + ahead_ns, options.predict, options.horizon_ns)

        def gaze(now_ns: int, ahead_ns: int, head: Pose) -> Gaze | None:
            return foreseen_gaze(known(now_ns), now_ns, ahead_ns if options.gaze == PREDICTED_GAZE else 0, head)

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
        self._check_decoder()
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
            self.cleanup.callback(self._close_passes)
            each = [self._compensator(plan) for plan in self.plans]
            if options.levels and options.budget_ms is not None:
                governor = Governor(options.levels, options.budget_ms)
                self.auto = AdaptiveCompensator(governor, dict(zip(options.levels, each, strict=True)))
                self._made = [self.auto]
            draws_changes = options.network.send == CHANGES and options.source_kind is not REMOTE
            changes = Changes(source.scene, self.server.content) if draws_changes else None
            self.loop = Loop(requested, frames, self.channel, history, self.auto or each[0], target.eyes, changes)
            unfinished.pop_all()
        return self

    def _check_decoder(self) -> None:
        """Check that the client decodes as fast as frames come. Errors: InputError."""
        options, plans, rate_hz = self.options, self.plans, self.target.rate_hz
        if not options.client_name or codecs.get(options.coding.codec).is_none:
            return
        weights = frame_bytes(needs_of(plans), self.sizes, {name for plan in plans for name in plan.layers})
        client, needed = load_client(options.client_name), video_pixels(weights) * rate_hz * 1e-6
        if needed > client.decoder_mpx_s:
            raise InputError(
                f"frames of {video_pixels(weights) * 1e-6:.1f} Mpx at {rate_hz:g} Hz are {needed:.0f} Mpx/s to decode: "
                f"client '{client.name}' decodes {client.decoder_mpx_s:g}; use a smaller --size or --guard, or another "
                "client"
            )

    def compensator(self, plan: Plan) -> Compensator:
        """Return a compensator for another plan on the same frames, freed with the run."""
        self.channel.read_beside(Reads.of([plan]))
        return self._compensator(plan)

    def _compensator(self, plan: Plan) -> Compensator:
        kind = SizedCompensator if self.options.network.overload == RESOLUTION else Compensator
        target, sizes = self.target, self.sizes
        hides = any(view.hidden is not None for view in target.eyes.views(Pose()))
        made = kind(target.gpu, plan, target.lens_of, sizes.rendered, sizes.shown, self.geometry, hides=hides)
        self._made.append(made)
        return made

    def exchange(self, plan: Plan) -> None:
        """Run this plan from now on, and free the one that it replaces.

        Frames must carry its layers.
        """
        made, before = self._compensator(plan), self.loop.compensator
        self.channel.read(Reads.of([plan]))
        self.loop.exchange(made)
        self._made.remove(before)
        before.close()
        self.plans, self.auto = [plan], None

    def _close_passes(self) -> None:
        for made in self._made:
            made.close()
        self._made.clear()

    def close(self) -> None:
        """Free everything; safe to call twice."""
        self.cleanup.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
