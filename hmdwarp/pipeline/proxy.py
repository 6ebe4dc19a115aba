"""A proxy between server and client: it warps for a client that only shows pictures."""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Mapping
from contextlib import ExitStack
from typing import Any

import attrs
import moderngl
import numpy as np

from ..base import AUTO, InputError, unknown_name
from ..client import ClientScene, Compensator, Plan, parse_fills, parse_indirect, parse_warp
from ..client.effects import effects
from ..client.lens import lenses
from ..frames import EyeImage, Frame
from ..geometry import Eyes, Guard, Pose, View, guarded_eyes
from ..gpu.textures import SCALAR, Canvas, allocate, release_all, upload
from ..gpu.timers import Laps
from ..link.codec import codecs
from ..metrics import middle_and_tail
from ..poses import PoseSample
from ..sources import sequences
from ..sources.repairs import parse_repairs
from ..sources.server import Renderer
from ..sources.server.draw import MIRRORS
from . import sizes
from .channel import Channel, Coder, Way
from .loop import Loop, Refresh
from .options import PROXY, PipelineOptions
from .recorded_source import RecordingSource
from .remote import RemoteSource
from .source import FrameSource, PoseRequest, ServerFrames, Source, Target, client_scene, joined

# At most so many times are kept of each stage: three minutes of two eyes at 90 Hz.
_KEPT = 1 << 15


@attrs.define(eq=False)
class KnownHead:
    """A poses.PoseSource of one head: the one of the proxy's last request."""

    head: PoseSample | None = None

    def start(self) -> None:
        """Do nothing, as closing does."""

    close = start

    def head_at(self, time_ns: int) -> PoseSample:
        """Return that head."""
        assert self.head is not None, "a proxy is asked for a head before it shows one"
        return self.head


@attrs.frozen(eq=False)
class GuardedEyes:
    """Eyes with the client's guard band, which the pictures that the proxy makes hold."""

    eyes: Eyes
    guard: Guard
    size: tuple[int, int]

    def views(self, world_from_head: Pose) -> tuple[View, ...]:
        """Return the view of each eye, the left one first."""
        views = self.eyes.views(world_from_head)
        fovs, _ = guarded_eyes(views, self.guard, self.size)
        return tuple(View(view.pose, fov, view.head_from_eye) for view, fov in zip(views, fovs, strict=True))


class Proxy(FrameSource):
    """Warp the server's newest frame to each requested head.

    It runs the loop that a client would, which ends in the link to the client instead of a display.
    Its frames are finished pictures without depth. There are none until the server's first frame
    has arrived.

    requested: of the pictures that it makes; its source is a KnownHead. eyes: with the client's
    guard band. rendered: (w, h) of the frames, which come by that way. about: what summary.json
    says of it beside what it measures. All of it is freed with the stack.
    """

    def __init__(
        self,
        frames: FrameSource,
        geometry: ClientScene,
        requested: PoseRequest,
        plan: Plan,
        eyes: Eyes,
        rendered: tuple[int, int],
        way: Way,
        about: Mapping[str, Any],
        stack: ExitStack,
    ) -> None:
        self._gpu, self._size, self._about = geometry.gpu, requested.size, about
        assert isinstance(requested.source, KnownHead)
        self._known = requested.source
        compensator = Compensator(self._gpu, plan, None, rendered, requested.size, geometry)
        stack.callback(compensator.close)
        self._channel, history = joined(frames, geometry, requested, [plan], way, stack)
        self._loop = Loop(requested, frames, self._channel, history, compensator, eyes)
        self._no_depth = allocate(self._gpu.gl, requested.size, SCALAR)
        upload(self._no_depth, np.full(requested.size[::-1], -1, np.float32))
        self._free: list[Canvas] = []
        self._out: dict[moderngl.Texture, Canvas] = {}
        stack.callback(self.close)
        # What it showed for the last head, until its times are noted.
        self.shown: Refresh | None = None
        self._stage_ms: defaultdict[str, deque[float]] = defaultdict(lambda: deque(maxlen=_KEPT))
        self._age_ms: deque[float] = deque(maxlen=_KEPT)

    def draw(self, head: PoseSample, now_ns: int) -> Frame | None:
        """Let the server draw what is due, and warp its newest frame that has arrived."""
        self._record_last()
        self._known.head = head
        self._loop.draw(now_ns)
        self.shown = refresh = self._loop.show(now_ns)
        if refresh is None:
            return None
        eyes, timer = [], self._gpu.timer
        with timer.stage("copy"):  # the loop overwrites its pictures at its next refresh
            for eye in refresh.eyes:
                canvas = self._free.pop() if self._free else Canvas(self._gpu.gl, self._size)
                canvas.copy_from(eye.panel)
                self._out[canvas.texture] = canvas
                eyes.append(EyeImage(eye.view, canvas.texture, self._no_depth, drawn_ns=now_ns))
        return Frame(tuple(eyes), now_ns, head, Laps(*refresh.laps, timer.lap()), older_ns=refresh.frame.shows_ns)

    def channel(self, *setup: Any) -> Channel:
        """Return the channel to the client."""
        found = super().channel(*setup)
        found.before = self.summary
        return found

    def recycle(self, frame: Frame) -> None:
        """Take a frame's pictures back; later ones will overwrite them."""
        for eye in frame.eyes:
            self._free.append(self._out.pop(eye.colour))

    def _record_last(self) -> None:
        """Note the times of the last refresh, which the GPU has finished by now."""
        last, self.shown = self.shown, None
        if last is None:
            return
        self._age_ms.append(last.age_ns * 1e-6)
        for stages in last.stage_ms:
            for name in (*dict(stages), "total"):
                self._stage_ms[name].append(sum(took_ms for stage, took_ms in stages if name in (stage, "total")))

    def summary(self, rate_hz: float) -> dict[str, Any]:
        """Return the `proxy` of the link in summary.json: the first link, and the work for one eye.

        rate_hz: refreshes per second. age_ms: from drawing a frame to warping it.
        """
        self._record_last()
        return {
            **self._about,
            "time_ms": {name: middle_and_tail(values) for name, values in self._stage_ms.items()},
            "age_ms": middle_and_tail(self._age_ms),
            **self._channel.summary(rate_hz),
        }

    def close(self) -> None:
        """Free the pictures; the figures stay readable."""
        self._record_last()
        release_all(*self._free, *self._out.values(), self._no_depth)
        self._free.clear()
        self._out.clear()


class _ProxySource(Source):
    """A scene that is drawn here for a proxy, whose pictures are the frames."""

    kind = PROXY

    def frames(
        self, options: PipelineOptions, server: Renderer, target: Target, requested: PoseRequest, stack: ExitStack
    ) -> Proxy:
        """Return the proxy: a loop like the client's, over frames that the server draws for it.

        Errors: InputError for sizes beyond the GPU's limits, MachineError for too little memory.
        """
        first, rate_hz = options.to_proxy(), target.rate_hz
        plan = sizes.proxy_plan_for(options, server.scene)
        eyes = GuardedEyes(target.eyes, requested.guard, requested.size)
        if plan.needs.others.other_eye and len(eyes.views(Pose())) < 2:
            raise InputError(f"--proxy-warp {first.warp} looks into the other eye's picture, and there is one eye")
        made = sizes.eye_sizes(first.guard_band, eyes, sizes.guarded_size(requested.guard, target.eyes, requested.size))
        sizes.check_held(target.gpu, first, plan.needs, made, rate_hz)
        refresh_ns = sizes.refreshes_of(options.proxy.longest_ms(options.network), rate_hz) * 1e9 / rate_hz
        link_ns = sizes.latency_ns(first)
        if first.network.is_plain:
            # At most the time between two refreshes so far apart, which are rounded to whole ns.
            link_ns = min(link_ns, max(0, round(refresh_ns) - 2))
        age_ns = sizes.expected_age_ns(first, round(refresh_ns), rate_hz)
        geometry = client_scene(options, server.scene, server, stack)
        # What it shows is for the requested head; what the server draws is seen later.
        guard = options.proxy.guard
        request = PoseRequest(KnownHead(), requested.for_server, made.shown, guard, plan.needs, age_ns=age_ns)
        way = first.network, link_ns, rate_hz, Coder.of(first.coding, rate_hz, age_ns)
        about = {
            "latency_ms": first.latency_ms,
            "total_latency_ms": options.total_latency_ms,
            "warp": first.warp,
            "fill": first.fill,
            "effects": list(plan.effects),
            "rendered": sizes.rendered_entry(guard, made, plan.needs),
        }
        frames = ServerFrames(server, request, eyes)
        return Proxy(frames, geometry, request, plan, eyes, made.rendered, way, about, stack)


def source_of(options: PipelineOptions) -> Source:
    """Return what gives the frames, once all names in the options are known.

    Errors: as check_names; as sequences.open, for recorded frames.
    """
    check_names(options)
    if options.frames is not None:
        sequence = sequences.open(options.frames, options.sequence_options).repaired(parse_repairs(options.repair))
        return RecordingSource(sequence, options.guard_factors, options.eye_distance_mm)
    if options.source_kind.is_timed:
        return RemoteSource(options)
    return _ProxySource(options) if options.source_kind is PROXY else Source(options)


def check_names(options: PipelineOptions) -> None:
    """Check warp, fills, lens, effects, codec, mirrors, indirect light and network.

    It loads nothing, so that a misspelt name is reported before a scene is built.

    Errors: UnknownNameError; InputError for an impossible network; MachineError for a codec that
    cannot run here.
    """
    if options.warp != AUTO:
        parse_warp(options.warp)
    parse_fills(options.fill)
    parse_indirect(options.indirect)
    if options.lens != AUTO:
        lenses.get(options.lens)
    effects.forced(options.effects)
    for name in (options.coding.codec, options.proxy.codec):
        codecs.get(name).check()
    options.client_link.delay.check(round(options.latency_ms * 1e6))
    if options.mirrors not in MIRRORS:
        raise unknown_name("kind of mirrors", options.mirrors, list(MIRRORS))
