"""The stereo loop: head pose, frame, link, newest pose, client. Every driver drives this one."""

from __future__ import annotations

from collections.abc import Sequence

import attrs

from ..client import Compensator, EyeResult, History, PassInputs, Plan
from ..frames import EyeImage, Frame, Needs
from ..geometry import Eyes, View
from ..gpu import Lap, Stages
from ..link import ResponseTime, TransitStats
from ..poses import PoseSample
from .channel import SEEN_PX, Changes, Channel
from .governor import AdaptiveCompensator
from .source import FrameSource, PoseRequest

Several = tuple[EyeImage, ...]


@attrs.frozen(eq=False)
class Refresh:
    """Everything about one shown refresh: inputs, results and timings.

    The result textures are overwritten by the next refresh.

    Reading `stage_ms` or `response` waits for the GPU. To avoid a stall, read them one refresh
    later.
    """

    shown_ns: int
    head: PoseSample
    frame: Frame
    plan: Plan
    inputs: tuple[PassInputs, ...]
    eyes: tuple[EyeResult, ...]
    transit: TransitStats
    laps: tuple[Lap, ...]

    @property
    def age_ns(self) -> int:
        """Time from drawing the frame to showing it."""
        return self.shown_ns - self.frame.drawn_ns

    @property
    def stage_ms(self) -> tuple[Stages, ...]:
        """Milliseconds of each stage, one entry for each eye."""
        return tuple([lap.read() for lap in self.laps])

    @property
    def response(self) -> ResponseTime:
        """The response time, split into its parts."""
        took = {f"{name}_ms": milliseconds for name, milliseconds in self.frame.timings_ms.items()}
        took["render_ms"] = self.frame.render_ms
        warp_ms = sum(milliseconds for stages in self.stage_ms for _, milliseconds in stages)
        return ResponseTime.of(self.transit, warp_ms=warp_ms, **took)


class Loop:
    """The loop over refreshes: `draw` sends what is due, `show` warps the newest that has arrived.

    source: the server, or what stands between it and the link. eyes: the views that belong to a
    head pose. changes: leaves out frames in which nothing has moved; None to draw every one.
    """

    def __init__(
        self,
        requested: PoseRequest,
        source: FrameSource,
        channel: Channel,
        history: History,
        compensator: Compensator | AdaptiveCompensator,
        eyes: Eyes,
        changes: Changes | None = None,
    ) -> None:
        self._requested, self.source, self._channel, self.history = requested, source, channel, history
        self.compensator: Compensator | AdaptiveCompensator = compensator
        self._eyes, self._changes = eyes, changes
        self._last: Refresh | None = None

    def exchange(self, compensator: Compensator) -> None:
        """Continue with another compensator on the same frames."""
        self.compensator, self._last = compensator, None

    def draw(self, now_ns: int) -> None:
        """Let the source draw and send what is due by now; call it once a refresh."""
        for instant_ns in self._channel.due(now_ns):
            if not self._channel.is_busy(instant_ns):
                head = self._requested.for_server(instant_ns)
                if (
                    self._changes is None
                    or self._channel.link.needs_key(instant_ns)  # one is missing
                    or self.source.has_more(instant_ns)
                    or self._changes.moved_px(self._eyes.views(head.pose), instant_ns) > SEEN_PX
                ):
                    self._draw(head, instant_ns)
                else:
                    self._channel.unchanged += 1

    def draw_at(self, now_ns: int) -> None:
        """Draw all eyes for the head pose at `now_ns`, and send the frame."""
        self._draw(self._requested.for_server(now_ns), now_ns)

    def _draw(self, head: PoseSample, now_ns: int) -> None:
        frame = self.source.draw(head, now_ns)
        if frame is not None and self._changes is not None:
            self._changes.sent(frame)
        if frame is not None:
            self._channel.send(frame, now_ns)

    def show(self, shown_ns: int) -> Refresh | None:
        """Warp the newest frame that has arrived to the head pose at `shown_ns`.

        Return None before the first frame arrives.

        The head is read last, right before the first pass is dispatched, so that it is as recent as
        possible.
        Errors: MachineError once the GPU's context is lost.
        """
        self.compensator.gpu.check_not_lost()
        last, self._last = self._last, None
        if last is not None:
            self.compensator.record_timings(last.stage_ms)
        frame = self._channel.newest(shown_ns)
        if frame is None:
            return None
        head = self._requested.source.head_at(shown_ns)
        views, needs = self._eyes.views(head.pose), self.compensator.plan.needs
        last_views: tuple[View | None, ...] = (None,) * len(views)
        if scanout_ns := self._requested.scanout_ns:
            last_views = self._eyes.views(self._requested.source.head_at(shown_ns + scanout_ns).pose)
        inputs, eyes, laps = [], [], []
        for eye, (view, end) in enumerate(zip(views, last_views, strict=True)):
            rendered, others, recent = self._pictures(frame, eye, needs)
            inputs.append(PassInputs(rendered, view, eye, others, recent, end, shown_ns=shown_ns))
        for eye_inputs in inputs:
            eyes.append(self.compensator.run(eye_inputs))
            laps.append(self.compensator.gpu.timer.lap())
        plan, transit = self.compensator.plan, self._channel.transit
        assert transit is not None  # a frame has arrived
        self._last = Refresh(shown_ns, head, frame, plan, tuple(inputs), tuple(eyes), transit, tuple(laps))
        return self._last

    def inputs(self, refresh: Refresh, needs: Needs) -> tuple[PassInputs, ...]:
        """Return the inputs of another plan with these needs for the refresh just shown.

        Frames must carry what it needs, see PoseRequest.needs; layers beyond that are left out.
        """
        found = []
        for before in refresh.inputs:
            rendered, others, recent = self._pictures(refresh.frame, before.eye, needs)
            found.append(attrs.evolve(before, rendered=rendered, others=others, recent=recent))
        return tuple(found)

    def _pictures(self, frame: Frame, eye: int, needs: Needs) -> tuple[EyeImage, Several, Several]:
        """Return the eye's picture, the other and the recent ones of a plan, with its layers.

        Frames may carry more layers, for plans that run on the same refresh.
        """
        rendered, asked, kept = frame.eyes[eye].only(needs), needs.others, self.history
        beside = [frame.eyes[1 - eye]] if asked.other_eye else []
        beside += rendered.carried.get("views", ())
        others = _alike(beside, kept.frames[: asked.past], eye, rendered, needs)
        return rendered, others, _alike([], kept.recent[: asked.recent], eye, rendered, needs)


def _alike(images: list[EyeImage], frames: Sequence[Frame], eye: int, like: EyeImage, needs: Needs) -> Several:
    """Return images, and an eye's of frames, that passes for `like` fit, with the needed layers."""
    for before in frames:
        images.append(before.eyes[eye])
    found = []
    for one in images:
        if one.colour.size == like.colour.size:
            found.append(one.only(needs) if one.carried else one)
    return tuple(found)
