"""What gives the frames of a run: chosen once from the options, and handed to the pipeline."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import cached_property
from typing import Any, TypeVar

import attrs
import numpy as np

from ..client.plan import Plan
from ..errors import InputError
from ..frames import Needs
from ..geometry import View
from ..gpu.context import Gpu
from ..headsets import Headset, load_headset
from ..link.codec import Coding, codecs
from ..poses import LoadedTrace, PoseSample
from ..poses.assumptions import Assumption
from ..poses.track import Moment
from ..scenes import Scene, load_scene
from ..sources.server import Renderer, Server
from .frame_coder import Coder
from .frame_source import FrameSource, ServerFrames, Target
from .options import NEAREST, PipelineOptions
from .recorded_renderer import MomentOf
from .requested import PoseRequest
from .source_kinds import SCENE, SourceKind

Options = TypeVar("Options", bound=PipelineOptions)


@attrs.frozen(eq=False, kw_only=True)
class FirstRequest:
    """The first request to a server elsewhere, to measure the way to it."""

    # Of one instant.
    head: PoseSample
    views: Sequence[View]
    rate_hz: float
    needs: Needs
    # As of PoseRequest.
    pictures: frozenset[str]
    # See Remote.
    holds: bool
    keeps: bool
    say: Callable[[str], None]


class Source:
    """A scene that is drawn here; the other sources say where they differ.

    Scene and headset are loaded at first use, once. scene: in place of the one that the options
    name.
    Errors, at first use: as load_scene and load_headset.
    """

    kind: SourceKind = SCENE
    # Instants of its frames, where it has frames at some alone.
    instants_ns: tuple[int, ...] = ()

    def __init__(self, options: PipelineOptions, scene: Scene | None = None) -> None:
        self._options, self._scene = options, scene

    @cached_property
    def scene(self) -> Scene:
        """What there is to draw; without anything in it where it is not here."""
        options = self._options
        return self._scene if self._scene is not None else load_scene(options.scene, options.scene_options)

    @cached_property
    def headset(self) -> Headset:
        """The headset of the options, or the display that belongs to the frames."""
        return load_headset(self._options.headset)

    @property
    def display(self) -> Headset | None:
        """The display that belongs to the frames; None for any."""
        return None

    @property
    def title(self) -> str:
        """Its kind and name, for messages."""
        return f"scene '{self.scene.name}'"

    @property
    def notes(self) -> list[str]:
        """What a reader of the results must know of it before anything else."""
        return []

    @property
    def assumptions(self) -> tuple[Assumption, ...]:
        """Facts by which its frames are read, with who says so."""
        return ()

    @property
    def entry(self) -> dict[str, Any] | None:
        """The `recorded` of summary.json; None where nothing is recorded."""
        return None

    def fitted(self, options: Options) -> Options:
        """Return the options with what the frames set."""
        return options

    def head(self, trace: LoadedTrace | None) -> LoadedTrace | None:
        """Return a head's motion as it goes with the frames. trace: None for their own."""
        return trace

    def check_eyes(self, needs: Needs, eyes: int) -> None:
        """Check that an eye whose picture the passes need is there.

        eyes: of the display. Errors: InputError.
        """
        if needs.others.other_eye and eyes < 2:
            self._refuse_one_eye("the flat view has one eye", "use the view of both eyes")

    @staticmethod
    def _refuse_one_eye(why: str, remedy: str) -> None:
        raise InputError(f"{why}, and this warp or fill looks into the other eye's picture: {remedy}")

    def check(self, plans: Sequence[Plan], needs: Needs) -> None:
        """Check that plans get by with what frames bring. Errors: InputError.

        needs: of all of them, and of others on the same frames.
        """

    def check_change(self, before: PipelineOptions, after: PipelineOptions) -> None:
        """Check that a run can go on with these options. Errors: InputError."""

    def measured(self, options: Options, first: FirstRequest) -> Options:
        """Connect where frames come from elsewhere, and return the options with the way's latency.

        Errors: as Remote.measure.
        """
        return options

    @property
    def is_timed(self) -> bool:
        """Whether its latency is only known once it is measured."""
        return False

    @property
    def notice(self) -> str:
        """What is to be shown over the picture about where it comes from, "" for nothing."""
        return ""

    @property
    def delays_ns(self) -> list[int]:
        """The measured delay of each frame, in the order of drawing, where it is measured."""
        return []

    def frames(
        self,
        options: PipelineOptions,
        server: Renderer,
        target: Target,
        requested: PoseRequest,
        stack: ExitStack,
    ) -> FrameSource:
        """Return where the frames of a loop come from; what it needs is freed with the stack."""
        return ServerFrames(server, requested, target.eyes)

    def coder(self, coding: Coding, rate_hz: float, age_ns: int) -> Coder | None:
        """Return what codes frames on their way; None for frames that arrive as they are."""
        return None if codecs.get(coding.codec).is_none else Coder(coding, rate_hz, age_ns * 1e-9)

    def close(self) -> None:
        """Hang up, where frames come from elsewhere."""

    def renderer(self, gpu: Gpu, options: PipelineOptions, moment_of: MomentOf = Moment) -> Renderer:
        """Return what draws the frames and the truth; the caller closes it.

        moment_of: where recorded frames are at an instant.
        """
        nearest = options.sample_depth == NEAREST
        return Server(gpu, self.scene, options.mirrors, samples=options.samples, nearest=nearest)


def nothing(name: str, summary: str, **more: Any) -> Scene:
    """Return a scene without anything in it, in which a head may be anywhere."""
    return Scene(name, summary, (), walk_bounds_m=np.array([[-np.inf] * 3, [np.inf] * 3]), **more)
