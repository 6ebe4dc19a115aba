"""What gives the frames of a run, chosen once from the options; and what stands before a loop.

Frames of a loop come from the server, or from what stands between it and the loop. A request says
whose head they are for, and in which format.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from functools import cached_property
from typing import Any, TypeVar

import attrs
import numpy as np

from .. import scenes
from ..base import InputError
from ..client import ClientScene, History, Plan
from ..frames import Frame, Needs
from ..frames.layers import PICTURE
from ..geometry import Eyes, Guard, Pose, looking
from ..gpu import Gpu
from ..headsets import Headset, load_headset
from ..poses import LoadedTrace, PoseSample, PoseSource
from ..poses.assumptions import Assumption
from ..poses.track import Gaze, Moment
from ..scenes import InputEvent, InputLog, Scene
from ..sources.server import Renderer, Server
from .channel import Channel, Reads, Way
from .options import SCENE, PipelineOptions, SourceKind

# Where recorded frames are at an instant.
MomentOf = Callable[[int], Moment]


@attrs.define(eq=False)
class PoseRequest:
    """Head poses for the server and the display, and the format of the pictures to draw."""

    source: PoseSource
    # Predicts the head at an instant for so long after it; None for no prediction.
    predicted: Callable[[int, int], PoseSample] | None
    size: tuple[int, int]  # (w, h) of one eye
    guard: Guard  # what is rendered beyond the shown view
    needs: Needs  # layers that frames carry
    scanout_ns: int = 0  # time from the first row of the display to its last
    # From drawing a frame to showing it, as far as that is known beforehand; set anew where the
    # latency changes during a run.
    age_ns: int = 0
    # What is read of the eyes' pictures, by readable name; none are drawn where it is empty.
    pictures: frozenset[str] = frozenset(PICTURE)
    # Where the eyes look as the server knows it at an instant, in a head's axes; None where frames
    # are as sharp everywhere.
    gaze: Callable[[int, Pose], Gaze | None] | None = None

    def for_server(self, now_ns: int, later_ns: int = 0) -> PoseSample:
        """Return the pose for a frame drawn now: the current or the predicted one.

        later_ns: how much later than a frame of this request it is seen.
        """
        ahead_ns = self.age_ns + later_ns
        head = self.source.head_at(now_ns) if self.predicted is None else self.predicted(now_ns, ahead_ns)
        return head if self.gaze is None else attrs.evolve(head, gaze=self.gaze(now_ns, head.pose))


@attrs.frozen(eq=False)
class Target:
    """Where the pictures of a run go."""

    gpu: Gpu  # belongs to the caller
    eyes: Eyes
    rate_hz: float  # refresh rate of the display
    link_latency_ns: int  # delay of the link alone, without the wait for the next refresh
    lens_of: Headset | None = None  # headset whose lens the plans correct, or None


class FrameSource(ABC):
    """Frames for the heads that a loop asks for."""

    @abstractmethod
    def draw(self, head: PoseSample, now_ns: int) -> Frame | None:
        """Return a frame made now for that head, None while there is nothing to make one from."""

    @abstractmethod
    def recycle(self, frame: Frame) -> None:
        """Take back a frame that is no longer needed."""

    def has_more(self, now_ns: int) -> bool:
        """Return whether there is something to send even if nothing has moved."""
        return False

    def heard(self, frame: Frame, arrived: bool, heard_ns: int) -> None:  # noqa: B027 (most do not care)
        """Take note of whether a frame arrived, which the sender hears at that instant."""

    def channel(self, *setup: Any) -> Channel:
        """Return the channel that the frames come through. setup: of a Channel, without recycle."""
        return Channel(self.recycle, *setup)


@attrs.frozen(eq=False)
class ServerFrames(FrameSource):
    """Frames as the server draws them.

    requested: their format. eyes: the views that belong to a head pose. unseen_from_ns: frames made
    from then on are sent, but never seen: their pictures are not drawn.
    """

    server: Renderer
    requested: PoseRequest
    eyes: Eyes
    unseen_from_ns: float = math.inf

    def draw(self, head: PoseSample, now_ns: int) -> Frame:
        """Draw all eyes for that head."""
        asked, timer = self.requested, self.server.gpu.timer
        is_seen = now_ns < self.unseen_from_ns
        with timer.stage("render"):
            views = self.eyes.views(head.pose) if head.gaze is None else looking(self.eyes.views(head.pose), head.gaze)
            pictures, size = bool(asked.pictures) if is_seen else None, asked.size
            frame = self.server.draw_frame(views, now_ns, size, asked.guard, asked.needs, size, asked.age_ns, pictures)
        if not is_seen:  # weighs what it would
            left_out = frozenset() if asked.pictures else frozenset(PICTURE)
            frame = attrs.evolve(frame, eyes=tuple(attrs.evolve(eye, left_out=left_out) for eye in frame.eyes))
        return attrs.evolve(frame, head=frame.head or head, drawing=timer.lap())

    def has_more(self, now_ns: int) -> bool:
        return self.server.has_more(now_ns)

    def heard(self, frame: Frame, arrived: bool, heard_ns: int) -> None:
        self.server.heard(frame, arrived, heard_ns)

    def recycle(self, frame: Frame) -> None:
        self.server.recycle(frame)


def joined(
    frames: FrameSource,
    geometry: ClientScene,
    requested: PoseRequest,
    plans: Sequence[Plan],
    way: Way,
    stack: ExitStack,
) -> tuple[Channel, History]:
    """Return the channel of the frames, and the older ones that these plans keep.

    Both are freed with the stack.
    """

    def settled(frame: Frame, arrived: bool, heard_ns: int) -> None:  # both ends take note of it
        if arrived:
            geometry.receive(frame)
        frames.heard(frame, arrived, heard_ns)

    history = History(requested.needs.others, frames.recycle)
    stack.callback(history.close)
    channel = frames.channel(way, Reads.of(plans), history.offer, settled)
    stack.callback(channel.close)
    return channel, history


def client_scene(options: PipelineOptions, scene: Scene, server: Renderer, stack: ExitStack) -> ClientScene:
    """Return the scene as the client has it, freed with the stack.

    It is drawn by the server's own renderer, unless its motion has to arrive.
    """
    arrived = None
    if options.client_motion != scenes.FORESEEN and scenes.moves(scene):
        arrived = scenes.ArrivedState(options.client_motion == scenes.EXTRAPOLATED)
        server = Server(server.gpu, scenes.as_arrived(scene, arrived), options.mirrors, samples=options.samples)
        stack.callback(server.close)
    geometry = ClientScene(server, arrived=arrived)
    stack.callback(geometry.close)
    return geometry


def motion_notes(options: PipelineOptions, scene: Scene, plan: Plan) -> list[str]:
    """Say how a client that draws knows of what moves; nothing where neither is so."""
    if not (plan.draws_scene and scenes.moves(scene)):
        return []
    known = f"What moves in scene '{scene.name}' {scenes.KNOWS[options.client_motion]} (--client-motion)"
    if scene.inputs is not None and options.client_motion == scenes.FORESEEN:
        known += ": it knows what people will do, as no client can"
    return [f"{known}."]


Options = TypeVar("Options", bound=PipelineOptions)


class Source:
    """A scene that is drawn here; the other sources say where they differ.

    scene: in place of the one that the options name. Errors, where it or the headset is first used:
    as load_scene and load_headset.
    """

    kind: SourceKind = SCENE
    # Instants of its frames, where it has frames at some alone.
    instants_ns: tuple[int, ...] = ()
    # Facts by which its frames are read, with who says so.
    assumptions: tuple[Assumption, ...] = ()
    # The `recorded` of summary.json; None where nothing is recorded.
    entry: dict[str, Any] | None = None
    # The session with a server elsewhere, a remote.Remote, once `measured` has connected.
    remote: Any = None

    def __init__(self, options: PipelineOptions, scene: Scene | None = None) -> None:
        self._options, self._scene = options, scene

    @cached_property
    def scene(self) -> Scene:
        """What there is to draw; without anything in it where it is not here."""
        options = self._options
        return self._scene if self._scene is not None else scenes.load_scene(options.scene, options.scene_options)

    @cached_property
    def headset(self) -> Headset:
        """The headset of the options, or the display that belongs to the frames."""
        return load_headset(self._options.headset)

    @property
    def title(self) -> str:
        """Its kind and name, for messages."""
        return f"{'scene' if self.entry is None else 'recorded frames'} '{self.scene.name}'"

    @property
    def notes(self) -> list[str]:
        """What a reader of the results must know of it before anything else."""
        return list(self.headset.notes)

    def fitted(self, options: Options) -> Options:
        """Return the options with what the frames set."""
        return options

    def head(self, trace: LoadedTrace | None) -> LoadedTrace | None:
        """Return a head's motion as it goes with the frames. trace: None for their own."""
        return trace

    def check(self, plans: Sequence[Plan], needs: Needs, eyes: int = 2) -> None:
        """Check that plans get by with what frames bring. Errors: InputError.

        needs: of all of them, and of others on the same frames. eyes: of the display.
        """
        for count, who, remedy in (
            (self.kind.eyes, "recorded frames have", "multi:eye=own looks into older frames alone"),
            (eyes, "the flat view has", "use the view of both eyes"),
        ):
            if needs.others.other_eye and count < 2:
                raise InputError(f"{who} one eye, and this warp or fill looks into the other eye's picture: {remedy}")

    def measured(self, options: Options, **first: Any) -> Options:
        """Connect where frames come from elsewhere, and return the options with the way's latency.

        first: the first request, see RemoteSource. Errors: as Remote.measure.
        """
        return options

    @property
    def inputs(self) -> InputLog:
        """What people do in the scene. Errors: InputError for one that does not react."""
        if self.scene.inputs is None:
            able = ", ".join(name for name in scenes.scenes.names() if scenes.scenes.get(name).reacts is not None)
            raise InputError(f"{self.title} does not react to what people do: expected {able}")
        return self.scene.inputs

    def act(self, event: InputEvent) -> InputEvent | None:
        """Do what somebody does, and return it with its target; None where it meant nothing.

        Errors: as inputs, and as InputLog.add.
        """
        return self.inputs.add(event)

    def frames(
        self, options: PipelineOptions, server: Renderer, target: Target, requested: PoseRequest, stack: ExitStack
    ) -> FrameSource:
        """Return where the frames of a loop come from; what it needs is freed with the stack."""
        return ServerFrames(server, requested, target.eyes)

    def close(self) -> None:
        """Hang up, where frames come from elsewhere."""

    def renderer(self, gpu: Gpu, options: PipelineOptions, moment_of: MomentOf = Moment) -> Renderer:
        """Return what draws the frames and the truth; the caller closes it.

        moment_of: where recorded frames are at an instant.
        """
        return Server(gpu, self.scene, options.mirrors, samples=options.samples)


def nothing(name: str, summary: str, **more: Any) -> Scene:
    """Return a scene without anything in it, in which a head may be anywhere."""
    return Scene(name, summary, (), walk_bounds_m=np.array([[-np.inf] * 3, [np.inf] * 3]), **more)
