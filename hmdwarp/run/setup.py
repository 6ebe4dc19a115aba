"""The set-up of every run: from its options to a pipeline, in an order that fails early."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import attrs

from ..client.plan import Plan, needs_of
from ..frames import Needs
from ..geometry import Eyes, Pose
from ..gpu.context import Gpu
from ..headsets import Headset
from ..pipeline.auto.levels import QualityLevel
from ..pipeline.build import Pipeline, build_pipeline
from ..pipeline.frame_source import Target
from ..pipeline.layers_read import Reads
from ..pipeline.link_times import expected_age_ns
from ..pipeline.options import PipelineOptions
from ..pipeline.recorded_renderer import MomentOf
from ..pipeline.sizes import guarded_size
from ..pipeline.source import Source
from ..poses import PoseSample, PoseSource, PoseTrack
from ..poses.pose_source import Moment
from .pose_request import pose_request

Options = TypeVar("Options", bound=PipelineOptions)


@attrs.frozen(eq=False)
class RunSetup(Generic[Options]):
    """A run that is checked, on a display: what it shows, by which plans."""

    # Its size is that of the display, where none is set.
    options: Options
    source: Source
    eyes: Eyes
    rate_hz: float
    # One, or one for each quality level.
    plans: Sequence[Plan]
    levels: tuple[QualityLevel, ...]
    # Of all plans on its frames.
    needs: Needs

    @classmethod
    def of(
        cls,
        options: Options,
        source: Source,
        eyes: Eyes,
        size: tuple[int, int],
        rate_hz: float,
        plans: Sequence[Plan],
        levels: tuple[QualityLevel, ...] = (),
        also: Needs | None = None,
    ) -> RunSetup[Options]:
        """Return a run that is checked.

        size, rate_hz: the display's, for options that set none. also: needs of further plans.
        Errors: InputError.
        """
        options = attrs.evolve(options, size=options.size or size)
        needs = needs_of(plans) | (also or Needs())
        source.check(plans, needs)
        source.check_eyes(needs, len(eyes.views(Pose())))
        guarded_size(options.guard_band, eyes, options.size or size)
        return cls(options, source, eyes, options.rate_hz or rate_hz, plans, levels, needs)

    @property
    def size(self) -> tuple[int, int]:
        """(w, h) of one eye."""
        assert self.options.size is not None
        return self.options.size

    def measured(
        self, head: PoseSample, *, holds: bool, keeps: bool = False, say: Callable[[str], None]
    ) -> RunSetup[Options]:
        """Return the run with its real latency, where its frames come from elsewhere.

        Errors: as Source.measured.
        """
        views = self.eyes.views(head.pose)
        options = self.source.measured(
            self.options, head, views, self.rate_hz, self.needs, holds=holds, keeps=keeps, say=say
        )
        return attrs.evolve(self, options=options)

    def build(
        self,
        gpu: Gpu,
        lens_of: Headset | None,
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
        pictures = all_pictures or Reads.of(self.plans).pictures
        request = pose_request(self.options, poses, known, age_ns, self.size, self.needs, pictures=pictures)
        target = Target(gpu, self.eyes, self.rate_hz, link_latency_ns, lens_of)
        return build_pipeline(self.options, self.source, target, self.plans, request, self.levels, moment_of)
