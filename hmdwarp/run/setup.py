"""The set-up of every run: from its options to a pipeline, in an order that fails early."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Generic, TypeVar

import attrs

from ..client.plan import Plan, needs_of
from ..display import Display
from ..frames import Needs
from ..frames.layers import PICTURE
from ..geometry import Eyes, Pose
from ..gpu.context import Gpu
from ..headsets import Headset
from ..pipeline.build import Pipeline, build_pipeline
from ..pipeline.frame_source import Target
from ..pipeline.layers_read import Reads
from ..pipeline.link_times import expected_age_ns
from ..pipeline.options import PipelineOptions
from ..pipeline.planning import plans_for
from ..pipeline.recorded_renderer import MomentOf
from ..pipeline.sizes import guarded_size
from ..pipeline.source import FirstRequest, Source
from ..poses import PoseSample, PoseSource, PoseTrack
from ..poses.track import Moment
from .pose_request import pose_request

Options = TypeVar("Options", bound=PipelineOptions)


@attrs.frozen(eq=False)
class EmulatedScreen:
    """What a run without a display is shown on: a headset, whose lens the plans correct."""

    headset: Headset
    eyes: Eyes
    # As of build_plan.
    distorts: ClassVar[str] = ""
    takes_depth: ClassVar[str] = ""

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
        beyond = {"distorts": screen.distorts, "takes_depth": screen.takes_depth}
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
