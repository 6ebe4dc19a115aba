"""Assembly of a pipeline on one GPU: server, channel, history, client, and the loop around them."""

from __future__ import annotations

import math
from collections.abc import Callable
from collections.abc import Sequence as Several
from contextlib import ExitStack

import attrs

from ..client import ClientScene
from ..client.classes import load_client
from ..client.compensator import Compensator
from ..client.inputs import History
from ..client.plan import Plan, needs_of
from ..errors import InputError
from ..frames import EyeSizes, Frame, Needs, frame_bytes, video_pixels
from ..geometry import Eyes, GuardBand, Pose
from ..gpu.context import Gpu
from ..headsets import Headset
from ..link import CHANGES, RESOLUTION, LinkOptions
from ..link.codec import Coding, codecs
from ..poses.pose_source import Moment
from ..scenes import Scene
from ..sources.server import Server
from .auto.adaptive import AdaptiveCompensator
from .auto.governor import Governor
from .auto.levels import QualityLevel
from .changes import Changes
from .channel import Channel
from .frame_coder import Coder
from .frame_source import FrameSource, ServerFrames
from .layers_read import Reads
from .loop import Loop
from .options import PipelineOptions
from .planning import proxy_plan_for
from .proxy import GuardedEyes, KnownHead, Proxy
from .recorded_scene import RecordedScene
from .recorded_server import MomentOf, RecordedServer
from .remote import Remote, RemoteChannel, RemoteFrames
from .remote_server import SERVER_SCENE, RemoteServer
from .requested import PoseRequest
from .sized import SizedCompensator
from .sizes import check_room, eye_sizes, rendered_entry

# A latency within this of a whole number of refreshes counts as that number: 16.67 ms is one
# refresh at 60 Hz, not a little more.
_SAME_REFRESH = 1e-3


def latency_ns(options: PipelineOptions) -> int:
    """Return the motion-to-photon latency that the options set."""
    return round(options.latency_ms * 1e6)


def refreshes_of(latency_ms: float, rate_hz: float) -> int:
    """Return how many refreshes after drawing a frame is shown: the first one after it arrives."""
    return math.ceil(latency_ms * 1e-3 * rate_hz - _SAME_REFRESH)


def frames_held(options: PipelineOptions, rate_hz: float, needs: Needs) -> int:
    """Return the largest number of frames alive at once.

    Counts frames in transit, the one shown, the one being drawn, and the older ones that warps
    read.
    """
    return _held(options.client_link, options.latency_ms, rate_hz, needs)


def _held(link: LinkOptions, latency_ms: float, rate_hz: float, needs: Needs) -> int:
    sends_hz = link.sends_hz(rate_hz)
    if link.is_plain:
        # Those sent since the refresh before, less the latency.
        return refreshes_of(latency_ms + 1e3 / rate_hz, sends_hz) + 1 + needs.others.past
    return link.most_under_way(round(latency_ms * 1e6), sends_hz) + 2 + needs.others.past


def expected_age_ns(options: PipelineOptions, plain_ns: int, rate_hz: float) -> int:
    """Return the mean age of a frame when it is seen.

    plain_ns: the age over a link that only delays, of a frame drawn at a refresh.
    """
    return _expected(options.client_link, options.latency_ms, plain_ns, rate_hz)


def _expected(link: LinkOptions, latency_ms: float, plain_ns: int, rate_hz: float) -> int:
    stays_ns = max(0.0, 1e9 / link.sends_hz(rate_hz) - 1e9 / rate_hz)
    newest_ns = plain_ns if link.is_plain else link.typical_ns(round(latency_ms * 1e6))
    return newest_ns + round(stays_ns / 2)


def refreshes_to_proxy(options: PipelineOptions, rate_hz: float) -> int:
    """Return how many refreshes after drawing a frame the proxy has it, 0 without a proxy."""
    if not options.proxy.on:
        return 0
    first, _ = options.proxy.links(options.network)
    return refreshes_of(first.longest_ns(round(options.proxy.latency_ms * 1e6)) / 1e6, rate_hz)


def check_held(gpu: Gpu, options: PipelineOptions, needs: Needs, sizes: EyeSizes, rate_hz: float) -> None:
    """Check that the largest number of frames alive at once fits. Errors: as check_room."""
    check_room(gpu, needs, sizes, options.guard_band, frames_held(options, rate_hz, needs), options.latency_ms)


@attrs.frozen(eq=False)
class Target:
    """Where the pictures of a run go."""

    # Belongs to the caller.
    gpu: Gpu
    eyes: Eyes
    # Refresh rate of the display.
    rate_hz: float
    # Delay of the link alone, without the wait for the next refresh.
    link_latency_ns: int
    # Headset whose lens the plans correct, or None.
    lens_of: Headset | None = None


@attrs.define(eq=False)
class Pipeline:
    """Everything on the GPU that one run needs, ready to go.

    Use as a context manager; the GPU itself belongs to the caller.
    """

    # The plan that runs first.
    plan: Plan
    requested: PoseRequest
    sizes: EyeSizes
    gpu: Gpu
    server: Server
    geometry: ClientScene
    # Between the server and the channel; None without one.
    proxy: Proxy | None
    channel: Channel
    loop: Loop
    # Chooses the warp; None where the options name one.
    auto: AdaptiveCompensator | None
    lens_of: Headset | None
    _options: PipelineOptions
    _made: list[Compensator | AdaptiveCompensator]
    _cleanup: ExitStack

    def compensator(self, plan: Plan) -> Compensator:
        """Return a compensator for another plan on the same frames, freed with the pipeline."""
        self.channel.read_beside(Reads.of([plan]))
        made = _compensator(self._options, self.gpu, plan, self.lens_of, self.sizes, self.geometry)
        self._made.append(made)
        return made

    def compensator_of_shown(self, plan: Plan) -> Compensator:
        """Return a compensator for finished pictures, before the lens; freed with the pipeline."""
        sizes = attrs.evolve(self.sizes, rendered=self.sizes.shown)
        made = _compensator(self._options, self.gpu, plan, self.lens_of, sizes, self.geometry)
        self._made.append(made)
        return made

    def exchange(self, plan: Plan) -> None:
        """Run this plan from now on, and free the one that it replaces.

        Frames must carry its layers.
        """
        made = _compensator(self._options, self.gpu, plan, self.lens_of, self.sizes, self.geometry)
        before = self.loop.compensator
        self._made.append(made)
        self.channel.read(Reads.of([plan]))
        self.loop.exchange(made)
        self._made.remove(before)
        before.close()
        self.plan, self.auto = plan, None

    def close(self) -> None:
        """Free everything on the GPU."""
        for made in self._made:
            made.close()
        self._made.clear()
        self._cleanup.close()

    def __enter__(self) -> Pipeline:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def build_pipeline(
    options: PipelineOptions,
    scene: Scene,
    target: Target,
    plans: Several[Plan],
    requested: PoseRequest,
    levels: tuple[QualityLevel, ...] = (),
    remote: Remote | None = None,
    moment_of: MomentOf = Moment,
) -> Pipeline:
    """Compile and allocate the whole pipeline.

    plans: one, or one for each quality level. remote: draws the frames elsewhere; it belongs to the
    caller. moment_of: where recorded frames are at an instant.
    Errors: InputError for sizes beyond the GPU's limits, MachineError for too little memory.
    """
    needs, gpu, lens_of = requested.needs, target.gpu, target.lens_of
    sizes = eye_sizes(requested.guard, target.eyes, requested.size)
    check_held(gpu, options, needs, sizes, target.rate_hz)
    _check_decoder(options, plans, sizes, target.rate_hz)
    with ExitStack() as stack:
        server = _server(options, gpu, scene, remote, moment_of)
        stack.callback(server.close)
        geometry = ClientScene(server)
        stack.callback(geometry.close)
        proxy = _proxy(options, server, target, requested, sizes, stack) if options.proxy.on else None
        source: FrameSource = proxy or ServerFrames(server, requested, target.eyes)
        if remote is not None:
            source = RemoteFrames(remote, server, requested, target.eyes)
        history = History(needs.others.past, needs.others.spacing_ns, source.recycle)
        stack.callback(history.close)
        channel = _channel(options, target, plans, history, source, geometry)
        stack.callback(channel.close)
        channel.before = proxy.summary if proxy is not None else None
        with ExitStack() as unfinished:
            compensators = []
            for plan in plans:
                compensators.append(_compensator(options, gpu, plan, lens_of, sizes, geometry))
                unfinished.callback(compensators[-1].close)
            unfinished.pop_all()
        auto = None
        if levels and options.budget_ms is not None:
            governor = Governor(levels, options.budget_ms)
            auto = AdaptiveCompensator(governor, dict(zip(levels, compensators, strict=True)))
        compensator: Compensator | AdaptiveCompensator = auto or compensators[0]
        changes = Changes(scene) if options.network.send == CHANGES else None
        loop = Loop(requested, source, channel, history, compensator, target.eyes, changes)
        parts = (gpu, server, geometry, proxy, channel, loop, auto, lens_of, options)
        return Pipeline(compensator.plan, requested, sizes, *parts, [compensator], stack.pop_all())


def _server(options: PipelineOptions, gpu: Gpu, scene: Scene, remote: Remote | None, moment_of: MomentOf) -> Server:
    if isinstance(scene, RecordedScene):
        return RecordedServer(gpu, scene, moment_of)
    if remote is not None and options.scene == SERVER_SCENE:
        return RemoteServer(gpu, remote.feed)
    return Server(gpu, scene, options.mirrors)


def _channel(
    options: PipelineOptions,
    target: Target,
    plans: Several[Plan],
    history: History,
    source: FrameSource,
    geometry: ClientScene,
) -> Channel:
    link, latency, rate_hz = options.client_link, target.link_latency_ns, target.rate_hz
    if isinstance(source, RemoteFrames):
        settled = _settled(source, geometry)
        return RemoteChannel(source, latency, Reads.of(plans), history.offer, rate_hz, settled, link)
    # It waits for the next refresh at most.
    age_ns = expected_age_ns(options, latency + round(1e9 / rate_hz), rate_hz)
    coder, settled = _coder(options.coding, rate_hz, age_ns), _settled(source, geometry)
    return Channel(link, latency, coder, Reads.of(plans), history.offer, source.recycle, rate_hz, settled)


def _settled(source: FrameSource, geometry: ClientScene) -> Callable[[Frame, bool, int], None]:
    """Return what is done with a frame whose fate is known: both ends take note of it."""

    def settled(frame: Frame, arrived: bool, heard_ns: int) -> None:
        if arrived:
            geometry.receive(frame)
        source.heard(frame, arrived, heard_ns)

    return settled


def _coder(coding: Coding, rate_hz: float, age_ns: int) -> Coder | None:
    return None if codecs.get(coding.codec).is_none else Coder(coding, rate_hz, age_ns * 1e-9)


def _proxy(
    options: PipelineOptions, server: Server, target: Target, requested: PoseRequest, sizes: EyeSizes, stack: ExitStack
) -> Proxy:
    """Return the proxy: a loop like the client's, over frames that the server draws for it.

    What it needs is freed with the stack. Errors: as build_pipeline.
    """
    asked, gpu, rate_hz = options.proxy, target.gpu, target.rate_hz
    (first, _), plan = asked.links(options.network), proxy_plan_for(options, server.scene)
    eyes, known = GuardedEyes(target.eyes, requested.guard, requested.size), KnownHead()
    if plan.needs.others.other_eye and len(eyes.views(Pose())) < 2:
        raise InputError(f"--proxy-warp {asked.warp} looks into the other eye's picture, and there is one eye")
    made = eye_sizes(asked.guard, eyes, sizes.rendered)
    check_room(
        gpu,
        plan.needs,
        made,
        GuardBand.of(asked.guard),
        _held(first, asked.latency_ms, rate_hz, plan.needs),
        asked.latency_ms,
    )
    refresh_ns = refreshes_to_proxy(options, rate_hz) * 1e9 / rate_hz
    latency_ns = round(asked.latency_ms * 1e6)
    if first.is_plain:
        # At most the time between any two refreshes so far apart, which are rounded to whole ns.
        latency_ns = min(latency_ns, max(0, round(refresh_ns) - 2))
    age_ns = _expected(first, asked.latency_ms, round(refresh_ns), rate_hz)
    history = History(plan.needs.others.past, plan.needs.others.spacing_ns, server.recycle)
    stack.callback(history.close)
    geometry = ClientScene(server)
    stack.callback(geometry.close)
    compensator = Compensator(gpu, plan, None, made.rendered, made.shown, geometry)
    stack.callback(compensator.close)
    # What it shows is for the head that it was asked for; what the server draws is seen later.
    request = PoseRequest(
        known,
        requested.for_server,
        made.shown,
        asked.guard,
        plan.needs,
        age_ns=age_ns,
    )
    frames, coder = ServerFrames(server, request, eyes), _coder(asked.coding, rate_hz, age_ns)
    reads, settled = Reads.of([plan]), _settled(frames, geometry)
    channel = Channel(first, latency_ns, coder, reads, history.offer, frames.recycle, rate_hz, settled)
    stack.callback(channel.close)
    loop = Loop(request, frames, channel, history, compensator, eyes)
    about = {
        "latency_ms": asked.latency_ms,
        "total_latency_ms": options.total_latency_ms,
        "warp": asked.warp,
        "fill": asked.fill,
        "effects": list(plan.effects),
        "rendered": rendered_entry(asked.guard, made),
    }
    proxy = Proxy(loop, known, channel, made.shown, about)
    stack.callback(proxy.close)
    return proxy


def _check_decoder(options: PipelineOptions, plans: Several[Plan], sizes: EyeSizes, rate_hz: float) -> None:
    """Check that the client decodes as fast as frames come. Errors: InputError."""
    if not options.client_name or codecs.get(options.coding.codec).is_none:
        return
    weights = frame_bytes(needs_of(plans), sizes, {name for plan in plans for name in plan.layers})
    client, needed = load_client(options.client_name), video_pixels(weights) * rate_hz * 1e-6
    if needed > client.decoder_mpx_s:
        raise InputError(
            f"frames of {video_pixels(weights) * 1e-6:.1f} Mpx at {rate_hz:g} Hz are {needed:.0f} Mpx/s to decode: "
            f"client '{client.name}' decodes {client.decoder_mpx_s:g}; use a smaller --size or --guard, or another "
            "client"
        )


def _compensator(
    options: PipelineOptions, gpu: Gpu, plan: Plan, headset: Headset | None, sizes: EyeSizes, geometry: ClientScene
) -> Compensator:
    kind = SizedCompensator if options.network.overload == RESOLUTION else Compensator
    return kind(gpu, plan, headset, sizes.rendered, sizes.shown, geometry)
