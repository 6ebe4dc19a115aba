"""A picture's whole way on one GPU: server, channel, history, client and the loop that drives them. Every driver builds this one."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack

import attrs

from ..auto.adaptive import AdaptiveCompensator
from ..auto.governor import Governor
from ..auto.levels import QualityLevel
from ..client.compensator import Compensator
from ..client.history import History
from ..client.plan import Plan, needs_of
from ..frames import EyeSizes, Needs, frame_bytes
from ..geometry import Eyes
from ..gpu.context import Gpu
from ..headsets import Headset
from ..link.codec import codecs
from ..scenes import Scene
from ..server import Server
from .channel import Channel, Coder
from .client_scene import ClientScene
from .loop import Loop, PoseRequest
from .options import PipelineOptions
from .sizes import check_room, eye_sizes

# A latency this near to a whole number of refreshes means that number: 16.67 ms is one refresh at 60 Hz, not a little more.
_SAME_REFRESH = 1e-3


def latency_ns(options: PipelineOptions) -> int:
    """What was asked for."""
    return round(options.latency_ms * 1e6)


def refreshes_of(latency_ms: float, rate_hz: float) -> int:
    """How many refreshes after it was drawn a frame is shown: it waits for the next one after it has arrived."""
    return math.ceil(latency_ms * 1e-3 * rate_hz - _SAME_REFRESH)


def frames_held(options: PipelineOptions, rate_hz: float, needs: Needs) -> int:
    """The most frames there are at a time: under way, shown, being drawn, and older ones kept."""
    if options.network.is_plain:
        return refreshes_of(options.latency_ms, rate_hz) + 2 + needs.others.past
    return options.network.most_under_way(latency_ns(options), rate_hz) + 2 + needs.others.past


def expected_age_ns(options: PipelineOptions, plain_ns: int) -> int:
    """How old a frame will be when it is seen, as far as one can know. plain_ns: over a link that does nothing but delay."""
    return plain_ns if options.network.is_plain else options.network.typical_ns(latency_ns(options))


def check_held(gpu: Gpu, options: PipelineOptions, needs: Needs, sizes: EyeSizes, rate_hz: float) -> None:
    """Errors: as check_room, for the most frames there are at a time."""
    check_room(gpu, needs, sizes, options.guard, frames_held(options, rate_hz, needs), options.latency_ms)


@attrs.frozen
class Timing:
    """When things happen. rate_hz: of the display's refreshes; link_latency_ns: what the link delays by."""

    rate_hz: float
    link_latency_ns: int


@attrs.define(eq=False)
class Pipeline:
    """Everything on the GPU that one run needs, ready to go. Use as a context manager; the GPU itself belongs to the caller.

    plan: what runs at first; auto: what chooses among several, where something does.
    """

    plan: Plan
    requested: PoseRequest
    sizes: EyeSizes
    gpu: Gpu
    server: Server
    geometry: ClientScene
    channel: Channel
    loop: Loop
    auto: AdaptiveCompensator | None
    lens_of: Headset | None
    _made: list[Compensator | AdaptiveCompensator]
    _cleanup: ExitStack

    def compensator(self, plan: Plan) -> Compensator:
        """A compensator for another plan on the same frames, freed with the pipeline."""
        self._made.append(_compensator(self.gpu, plan, self.lens_of, self.sizes, self.geometry))
        return self._made[-1]

    def exchange(self, plan: Plan) -> None:
        """Run this plan from now on; frames must carry what it reads. What it replaces is freed."""
        made, before = self.compensator(plan), self.loop.compensator
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
    gpu: Gpu,
    options: PipelineOptions,
    scene: Scene,
    eyes: Eyes,
    plans: Sequence[Plan],
    requested: PoseRequest,
    timing: Timing,
    lens_of: Headset | None = None,
    levels: tuple[QualityLevel, ...] = (),
) -> Pipeline:
    """Compile and allocate all of it. plans: one, or that of each rung. lens_of: whose lens the plans correct, if they do.

    Errors: InputError for sizes the GPU cannot do, MachineError where there is no room.
    """
    needs = requested.needs
    sizes = eye_sizes(requested.guard, eyes, requested.size)
    check_held(gpu, options, needs, sizes, timing.rate_hz)
    with ExitStack() as stack:
        server = Server(gpu, scene, options.mirrors)
        stack.callback(server.close)
        geometry = ClientScene(server)
        stack.callback(geometry.close)
        history = History(needs.others.past, needs.others.spacing_ns, server.recycle)
        stack.callback(history.close)
        channel = _channel(options, sizes, timing, plans, history, server)
        stack.callback(channel.close)
        with ExitStack() as unfinished:
            compensators = []
            for plan in plans:
                compensators.append(_compensator(gpu, plan, lens_of, sizes, geometry))
                unfinished.callback(compensators[-1].close)
            unfinished.pop_all()
        auto = (
            AdaptiveCompensator(Governor(levels, options.budget_ms), dict(zip(levels, compensators, strict=True)))
            if levels
            else None
        )
        compensator = auto or compensators[0]
        loop = Loop(requested, server, channel, history, compensator, eyes)
        parts = (gpu, server, geometry, channel, loop, auto, lens_of)
        return Pipeline(compensator.plan, requested, sizes, *parts, [compensator], stack.pop_all())


def _channel(
    options: PipelineOptions, sizes: EyeSizes, timing: Timing, plans: Sequence[Plan], history: History, server: Server
) -> Channel:
    reads = {name for plan in plans for name in plan.layers}
    weight = sum(frame_bytes(needs_of(plans), sizes, reads).values())
    coder = None
    if not codecs.get(options.coding.codec).is_none:
        coder = Coder(options.coding, sizes.rendered, timing.rate_hz, sends_depth="rendered.inverse_depth" in reads)
    return Channel(options.network, timing.link_latency_ns, coder, weight, history.offer, server.recycle)


def _compensator(gpu: Gpu, plan: Plan, headset: Headset | None, sizes: EyeSizes, geometry: ClientScene) -> Compensator:
    return Compensator(gpu, plan, headset, sizes.rendered, sizes.shown, geometry)
