"""Assembly of a pipeline on one GPU: server, channel, history, client, and the loop around them."""

from __future__ import annotations

from collections.abc import Callable
from collections.abc import Sequence as Several
from contextlib import ExitStack

import attrs

from ..client import ClientScene
from ..client.classes import load_client
from ..client.compensator import Compensator, EyeResult
from ..client.inputs import History, PassInputs
from ..client.plan import Plan, needs_of
from ..errors import InputError
from ..frames import EyeSizes, frame_bytes, video_pixels
from ..geometry import Pose
from ..gpu.context import Gpu
from ..headsets import Headset
from ..link import CHANGES, RESOLUTION
from ..link.codec import codecs
from ..poses.track import Moment
from ..sources.server import Renderer
from .channel import Changes, Channel, ChannelSetup
from .frame_coder import Reads
from .governor import AdaptiveCompensator, Governor
from .loop import Loop
from .options import PipelineOptions
from .proxy_options import REMOTE
from .recorded_renderer import MomentOf
from .sizes import check_held, expected_age_ns, eye_sizes
from .source import PoseRequest, Source, Target, client_scene, settling

Size = tuple[int, int]


class SizedCompensator(Compensator):
    """Compensate frames of any size: passes for another than `rendered` are made when one comes.

    What a pass remembers of earlier refreshes is of one size.
    """

    def __init__(
        self,
        gpu: Gpu,
        plan: Plan,
        headset: Headset | None,
        rendered: Size,
        shown: Size,
        geometry: ClientScene,
        *,
        hides: bool = False,
    ) -> None:
        super().__init__(gpu, plan, headset, rendered, shown, geometry, hides=hides)
        self._full_size = rendered
        self._others: dict[Size, Compensator] = {}
        self._make: Callable[[Size], Compensator] = lambda size: Compensator(
            gpu, plan, headset, size, shown, geometry, hides=hides
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


@attrs.define(eq=False)
class Pipeline:
    """Everything on the GPU that one run needs, ready to go.

    Use as a context manager; the GPU itself belongs to the caller.
    """

    # The plan that runs first.
    plan: Plan
    requested: PoseRequest
    sizes: EyeSizes
    options: PipelineOptions
    source: Source
    target: Target
    server: Renderer
    geometry: ClientScene
    channel: Channel
    loop: Loop
    # Chooses the warp; None where the options name one.
    auto: AdaptiveCompensator | None
    _made: list[Compensator | AdaptiveCompensator]
    _cleanup: ExitStack

    @property
    def gpu(self) -> Gpu:
        """The GPU that it is on."""
        return self.target.gpu

    def compensator(self, plan: Plan) -> Compensator:
        """Return a compensator for another plan on the same frames, freed with the pipeline."""
        self.channel.read_beside(Reads.of([plan]))
        return self._compensator(plan)

    def _compensator(self, plan: Plan) -> Compensator:
        made = _compensator(self.options, self.target, plan, self.sizes, self.geometry)
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
    source: Source,
    target: Target,
    plans: Several[Plan],
    requested: PoseRequest,
    moment_of: MomentOf = Moment,
) -> Pipeline:
    """Compile and allocate the whole pipeline.

    plans: as plans_for returns them. moment_of: where recorded frames are at an instant.
    Errors: InputError for sizes beyond the GPU's limits, MachineError for too little memory.
    """
    needs, gpu = requested.needs, target.gpu
    sizes = eye_sizes(requested.guard, target.eyes, requested.size)
    check_held(gpu, options, needs, sizes, target.rate_hz)
    _check_decoder(options, plans, sizes, target.rate_hz)
    with ExitStack() as stack:
        server = source.renderer(gpu, options, moment_of)
        stack.callback(server.close)
        geometry = client_scene(options, source.scene, server, stack)
        frames = source.frames(options, server, target, requested, stack)
        history = History(needs.others.past, needs.others.spacing_ns, frames.recycle)
        stack.callback(history.close)
        # It waits for the next refresh at most.
        age_ns = expected_age_ns(options, target.link_latency_ns + round(1e9 / target.rate_hz), target.rate_hz)
        coder = source.coder(options.coding, target.rate_hz, age_ns)
        ends = (coder, Reads.of(plans), history.offer, settling(frames, geometry))
        channel = frames.channel(ChannelSetup(options.client_link, target.link_latency_ns, target.rate_hz, *ends))
        stack.callback(channel.close)
        with ExitStack() as unfinished:
            compensators = []
            for plan in plans:
                compensators.append(_compensator(options, target, plan, sizes, geometry))
                unfinished.callback(compensators[-1].close)
            unfinished.pop_all()
        auto = None
        if options.levels and options.budget_ms is not None:
            governor = Governor(options.levels, options.budget_ms)
            auto = AdaptiveCompensator(governor, dict(zip(options.levels, compensators, strict=True)))
        compensator: Compensator | AdaptiveCompensator = auto or compensators[0]
        changes = (
            Changes(source.scene, server.content)
            if options.network.send == CHANGES and options.source_kind is not REMOTE
            else None
        )
        loop = Loop(requested, frames, channel, history, compensator, target.eyes, changes)
        parts = (requested, sizes, options, source, target, server, geometry, channel, loop, auto)
        return Pipeline(compensator.plan, *parts, [compensator], stack.pop_all())


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
    options: PipelineOptions, target: Target, plan: Plan, sizes: EyeSizes, geometry: ClientScene
) -> Compensator:
    kind = SizedCompensator if options.network.overload == RESOLUTION else Compensator
    hides = any(view.hidden is not None for view in target.eyes.views(Pose()))
    return kind(target.gpu, plan, target.lens_of, sizes.rendered, sizes.shown, geometry, hides=hides)
