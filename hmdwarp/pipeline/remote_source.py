"""A server elsewhere as a source: its frames come by the feed, and so does the truth."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from typing import Any

import attrs

from ..client.plan import Plan
from ..errors import HmdwarpError, InputError, counted
from ..frames import EyeImage, Frame, Needs
from ..frames.layers import PICTURE
from ..frames.layers.pictures import FoveatedPicture
from ..geometry import Eyes, Pose, View, guarded_eyes, looking
from ..gpu.context import Gpu
from ..gpu.textures import COLOUR, SCALAR
from ..link import CHANGES, TransitStats
from ..poses import PoseSample
from ..poses.track import Moment
from ..scenes import InputEvent, Scene
from ..sources.feed.caller import Viewer
from ..sources.feed.message import RAW, FrameMessage
from ..sources.feed.options import FULL, FeedOptions, public_key, secret_in
from ..sources.server import Renderer, Target
from .channel import Channel, ChannelSetup
from .feed_coding import arrays_of, codes_video, depth_error, left_out, made, wish_of
from .options import REMOTE, SERVER_SCENE, PipelineOptions
from .remote import Remote, Request, ViewsApart
from .source import FrameSource, MomentOf, Options, PoseRequest, Source, nothing
from .source import Target as Shown


class NoTruth(HmdwarpError):
    """The server elsewhere has not drawn what an eye should see."""


class RemoteSource(Source):
    """Frames that a server elsewhere draws.

    The scene is here as well if the options name it, for passes and for the truth, which the server
    draws otherwise. draws_truth: False for a run that has none.
    """

    kind = REMOTE

    def __init__(self, options: PipelineOptions, feed: FeedOptions, *, draws_truth: bool) -> None:
        self._is_here = options.scene != SERVER_SCENE
        elsewhere = nothing(SERVER_SCENE, f"drawn by {feed.connect}")
        super().__init__(options, None if self._is_here else elsewhere)
        if feed.raw != FULL and options.coding.codec != "none":
            raise InputError(
                f"--raw {feed.raw} beside --codec {options.coding.codec}: coded frames are not raw; leave one out"
            )
        self.feed, self._draws_truth = feed, draws_truth
        self._added_ns = round(feed.added_latency_ms * 1e6)
        try:
            options.network.delay.check(self._added_ns)
        except InputError as error:
            raise InputError(f"--added-latency {feed.added_latency_ms:g} ms: {error}") from error

    def fitted(self, options: Options) -> Options:
        """Return the options with the server in place of a scene, where there is none here."""
        return options if self._draws_truth or self._is_here else attrs.evolve(options, scene=self.feed.connect)

    def check(self, plans: Sequence[Plan], needs: Needs, eyes: int = 2) -> None:
        """Check that plans get by with what frames of another process have. Errors: InputError."""
        super().check(plans, needs, eyes)
        steps = [step for plan in plans for step in plan.steps]
        if not self._is_here and any(
            name.startswith("client.") for step in steps for name in (*step.reads, *step.writes)
        ):
            raise InputError(
                "--connect: the client draws some of the scene for this warp or fill, and the scene is at the server: "
                "use another one, or name that scene by --scene, too"
            )

    def measured(self, options: Options, **first: Any) -> Options:
        """Connect, send what people do, and return the options with the measured latency.

        first: head and views of one instant, rate_hz, needs and pictures as of PoseRequest; holds,
        keeps and say as of Remote.
        """
        assert options.size is not None
        remote = self.remote = Remote(self.feed, **{name: first[name] for name in ("holds", "keeps", "say")})
        remote.pictures, head, views, rate_hz = first["pictures"], first["head"], first["views"], first["rate_hz"]
        wanted = (RAW[self.feed.raw], options.coding, rate_hz, views, options.size)
        remote.wish = wish_of(*wanted, options.latency_ms * 1e-3)
        longest_ns = remote.measure(head, views, options.guard_band, options.size, first["needs"]) + self._added_ns
        remote.wish = wish_of(*wanted, longest_ns * 1e-9 + 1 / rate_hz)
        if self.scene.inputs is not None:
            remote.act(self.scene.inputs)
        return attrs.evolve(options, latency_ms=longest_ns / 1e6)

    def act(self, event: InputEvent) -> InputEvent | None:
        """Send what somebody does, and return it: what it means is known where the scene is.

        Errors: as Source.act, and as Remote.act.
        """
        done = super().act(event) if self._is_here else event
        if done is not None and self.remote is not None:
            self.remote.act([done])
        return done

    def frames(
        self,
        options: PipelineOptions,
        server: Renderer,
        target: Shown,
        requested: PoseRequest,
        stack: ExitStack,
    ) -> RemoteFrames:
        """Return the frames that the server elsewhere draws."""
        remote = self.remote
        assert remote is not None, "measured() connects"
        remote.pictures = requested.pictures
        remote.only_changes = options.network.send == CHANGES
        return RemoteFrames(remote, server, requested, target.eyes, self._added_ns)

    def renderer(self, gpu: Gpu, options: PipelineOptions, moment_of: MomentOf = Moment) -> Renderer:
        """Return what draws the truth, and has textures for the frames."""
        if self._is_here:
            return super().renderer(gpu, options, moment_of)
        return RemoteRenderer(gpu, self.scene, self.feed) if self._draws_truth else Renderer(gpu, self.scene)

    def close(self) -> None:
        """Hang up."""
        if self.remote is not None:
            self.remote.close()
            self.remote = None


class RemoteRenderer(Renderer):
    """A renderer whose pictures are drawn elsewhere, each on request.

    It is another client than the one for the frames, so that neither replaces the other's requests.
    Errors: as Viewer.
    """

    def __init__(self, gpu: Gpu, scene: Scene, feed: FeedOptions) -> None:
        super().__init__(gpu, scene)
        self._viewer = Viewer(feed.connect, secret_in(feed.token_file), public_key(feed.server_key))
        self._apart = ViewsApart()

    def draw(self, view: View, size: tuple[int, int], into: Target | None = None, time_ns: int = 0) -> EyeImage:
        """Return what the server draws for the view. Errors: NoTruth where it draws nothing."""
        found = self._viewer.fetch(view, size, time_ns)
        if found is None:
            raise NoTruth("the server has not drawn the truth")
        self._apart.take(view, found.views[0])
        target = into if into is not None else self.acquire(size)
        self.take_in(arrays_of(found, 0, size), target)
        return EyeImage(view, target.colour, target.inverse_depth, drawn_ns=time_ns)

    def truth_facts(
        self, shown: Sequence[tuple[int, Pose]], missing: int, pixels_per_degree: float, *, own_head: bool
    ) -> tuple[dict[str, Any], str]:
        """Return nothing for summary.json, and a sentence or two on what the truth is."""
        text = "The truth is what the server drew for the shown views."
        if self._apart:
            text += f" Its views were {self._apart}: the figures count that as error."
        if missing:
            text += f" It drew none for {counted(missing, 'picture')}, which were not measured."
        return {}, text

    def close(self) -> None:
        """Free what was uploaded, and hang up."""
        self._viewer.close()
        super().close()


@attrs.frozen(eq=False)
class RemoteFrames(FrameSource):
    """Frames that another machine draws: asking returns none, they arrive at the channel.

    server: this side's, of whose textures the frames are made.
    """

    remote: Remote
    server: Renderer
    requested: PoseRequest
    eyes: Eyes
    # Emulated latency behind the real network's.
    added_ns: int = 0

    def draw(self, head: PoseSample, now_ns: int, scale: float) -> None:
        """Ask for a frame for that head."""
        asked = self.requested
        self.remote.age_ns = asked.age_ns
        views = looking(self.eyes.views(head.pose), head.gaze)
        self.remote.ask(head, views, asked.guard, asked.size, now_ns, asked.needs)

    def made(self, request: Request, found: FrameMessage) -> Frame:
        """Return the frame that arrived, decoded."""
        eyes, ask, asked, server = [], request.ask, self.requested, self.server
        for eye, (view, wanted) in enumerate(zip(found.views, ask.views, strict=True)):
            # As large as in the request where no picture was sent.
            size = found.size if asked.pictures else guarded_eyes([view], asked.guard, asked.size)[1]
            target, sent = server.acquire(ask.size if ask.fovea else size), left_out(found, eye)
            missing = sent | frozenset(PICTURE).difference(asked.pictures)
            whole = frozenset(PICTURE) if ask.fovea else missing
            server.take_in(arrays_of(found, eye, target.size, whole), target)
            hidden = wanted.hidden if view.fov == wanted.fov else view.hidden
            image = EyeImage(
                attrs.evolve(view, hidden=hidden, gaze=wanted.gaze),
                target.colour,
                target.inverse_depth,
                drawn_ns=request.drawn_ns,
                depth_error=depth_error(found, self.remote.wish),
                left_out=missing,
            )
            if ask.fovea:  # foveated pictures came in place of whole ones
                colour, depth = (server.acquire(found.size, kind, depth=False).colour for kind in (COLOUR, SCALAR))
                server.take_in(arrays_of(found, eye, found.size, sent), Target(colour, depth))
                pictures = [FoveatedPicture(texture, found.grids[eye]) for texture in (colour, depth)]
                image = image.having(foveated=pictures[0], foveated_depth=pictures[1])
            eyes.append(image)
        if found.layers:  # a server may choose the size of some
            eyes = made(server, eyes, found.layers, ask.wanted)
            server.trim()
        took_ms = {"render": found.render_ns / 1e6}
        return Frame(tuple(eyes), request.drawn_ns, request.head, None, found.began, took_ms, found.time_ns)

    def recycle(self, frame: Frame | None) -> None:
        """Return the frame's textures to the pools; None for one that was never made."""
        if frame is not None:
            self.server.recycle(frame)

    def channel(self, setup: ChannelSetup) -> Channel:
        """Return the channel of what arrives by the feed."""
        return RemoteChannel(setup, self)


class RemoteChannel(Channel):
    """The channel of frames that arrive by the feed: what was measured of it, then the link.

    The link emulates what its options say, behind the real network: frames are decoded as they
    arrive over both, and those that it loses never are. The server hears of a frame's fate with the
    next request.
    """

    def __init__(self, setup: ChannelSetup, frames: RemoteFrames) -> None:
        self._remote, self._frames_of, self._tell = frames.remote, frames, setup.settled
        super().__init__(
            attrs.evolve(setup, coder=None),  # the server codes them
            frames.recycle,
            receive=self._receive,
            decoding=lambda request: 0,
            settled=self._settled,
            in_order=codes_video(frames.remote.wish.colour),
        )
        self._shown: Request | None = None
        self._sent_ns = self._measured_ns = 0
        self._unanswered = self._remote.unanswered
        self._remote.forget()
        self._remote.needs_key = self.link.needs_key
        self.link.delay_by(self._delays(setup.network.delays(frames.added_ns)))

    def _delays(self, added: Iterator[int]) -> Iterator[int]:
        for added_ns in added:
            delay_ns = self._measured_ns + added_ns
            if self._remote.keeps:
                self._remote.delays_ns.append((self._sent_ns, delay_ns))
            yield delay_ns

    def _receive(self, request: Request) -> bool:
        decoded = self._remote.decoded(request)
        if decoded is not None:
            request.frame = self._frames_of.made(request, decoded)
        return decoded is not None

    def _settled(self, request: Request, arrived: bool, heard_ns: int) -> None:
        if arrived and request.frame is not None:
            self._tell(request.frame, arrived, heard_ns)
        self._remote.tell(request, arrived=arrived, heard_ns=heard_ns)

    def due(self, now_ns: int) -> list[int]:
        """Return the instants at which a frame is requested, up to now."""
        self._remote.pace(now_ns)
        return super().due(now_ns)

    def newest(self, now_ns: int) -> Frame | None:
        """Return the newest frame that has arrived by now, or None before the first."""
        for request in self._remote.arrived(now_ns):
            self._frames, self._eyes = self._frames + 1, len(request.ask.views)
            self._bytes.update(request.layer_bytes)
            self._measured_ns, self._sent_ns = request.took_ns, request.drawn_ns
            self.link.send(request, request.drawn_ns, request.layer_bytes.total(), request.is_key)
        self._shown = self.link.newest(now_ns)
        return self._shown.frame if self._shown is not None else None

    @property
    def transit(self) -> TransitStats | None:
        """Transit statistics of the shown frame; the server's work is told from its delay."""
        found = self.link.transit
        if found is None or self._shown is None or self._shown.message is None:
            return None
        render_ns = min(self._shown.message.render_ns, self._shown.took_ns)
        return attrs.evolve(found, render_ns=render_ns, delay_ns=found.delay_ns - render_ns)

    def fates(self) -> dict[str, int]:
        """Return what became of every frame; skipped: requests that the server passed over."""
        unanswered = self._remote.unanswered - self._unanswered
        return {**super().fates(), "skipped": unanswered, "unchanged": self._remote.unchanged}

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """Return the `link` of summary.json, with the connection."""
        return {**super().summary(rate_hz), "codec": self._remote.codec, "feed": self._remote.summary()}
