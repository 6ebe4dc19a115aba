"""The stereo loop: head pose, server, link, newest pose, client. Every driver drives this one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

from .client.given import Given
from .link import ResponseTime

if TYPE_CHECKING:
    from .channel import Channel
    from .client.compensator import Compensator, EyeResult
    from .client.history import History
    from .client.plan import Plan
    from .frame import Frame, Needs
    from .headsets import Headset
    from .poses import PoseSample
    from .rig import Requested
    from .server import Server


@attrs.frozen(eq=False)
class Refresh:
    """One picture pair: when and for which head it was made, from which frame, by which plan, what its passes were given, what
    came out (overwritten at the next), and the response time by its parts."""

    shown_ns: int
    head: PoseSample
    frame: Frame
    plan: Plan
    given: tuple[Given, ...]
    eyes: tuple[EyeResult, ...]
    stage_ms: tuple[tuple[tuple[str, float], ...], ...]
    response: ResponseTime

    @property
    def age_ns(self) -> int:
        """How long before it is seen the frame was drawn."""
        return self.shown_ns - self.frame.drawn_ns


class Loop:
    """One refresh after the other: `draw` what the server sends now, `show` what has arrived by the display instant."""

    def __init__(
        self, requested: Requested, server: Server, channel: Channel, history: History, compensator: Compensator, headset: Headset
    ) -> None:
        self._requested, self._server, self._channel, self._history = requested, server, channel, history
        self._compensator, self._headset = compensator, headset

    def draw(self, now_ns: int) -> None:
        """The server draws both eyes for the pose it is asked for now, and the frame goes on its way."""
        asked = self._requested
        head = asked.for_server(now_ns)
        timer = self._server.gpu.timer
        with timer.stage("render"):
            frame = self._server.draw_frame(self._headset.views(head.pose), now_ns, asked.size, asked.guard, asked.needs)
        frame.took_ms["render"] = sum(milliseconds for _, milliseconds in timer.collect())
        self._channel.send(attrs.evolve(frame, head=head), now_ns)

    def show(self, shown_ns: int) -> Refresh | None:
        """Warp the newest frame that has arrived to the head at `shown_ns`; None before the first frame has arrived."""
        frame = self._channel.newest(shown_ns)
        if frame is None:
            return None
        head = self._requested.for_display(shown_ns)
        given = self._given(frame, head, shown_ns)
        eyes, times = [], []
        for one in given:
            eyes.append(self._compensator.run(one))
            times.append(tuple(self._compensator.gpu.timer.collect()))
        plan = self._compensator.plan
        self._compensator.took(times)
        return Refresh(shown_ns, head, frame, plan, given, tuple(eyes), tuple(times), self._response(frame, times))

    def _response(self, frame: Frame, times: list[tuple[tuple[str, float], ...]]) -> ResponseTime:
        took = {f"{name}_ms": milliseconds for name, milliseconds in frame.took_ms.items()}
        warp_ms = sum(milliseconds for stages in times for _, milliseconds in stages)
        return ResponseTime.of(self._channel.passage, warp_ms=warp_ms, **took)

    def given(self, refresh: Refresh, needs: Needs) -> tuple[Given, ...]:
        """What another plan with these needs is given at the refresh just shown; frames must carry as much, see Requested.needs."""
        return tuple(attrs.evolve(one, others=self._others(refresh.frame, one.eye, needs)) for one in refresh.given)

    def _given(self, frame: Frame, head: PoseSample, shown_ns: int) -> tuple[Given, ...]:
        asked, first, needs = self._requested, self._headset.views(head.pose), self._compensator.plan.needs
        last: tuple = (None, None)
        if asked.scanout_ns:
            last = self._headset.views(asked.for_display(shown_ns + asked.scanout_ns).pose)
        return tuple(
            Given(frame.eyes[eye], first[eye], eye, self._others(frame, eye, needs), last[eye], shown_ns=shown_ns)
            for eye in range(len(first))
        )

    def _others(self, frame: Frame, eye: int, needs: Needs) -> tuple:
        beside = (frame.eyes[1 - eye],) if needs.other_eye else ()
        return (*beside, *(past.eyes[eye] for past in self._history.frames[: needs.past]))
