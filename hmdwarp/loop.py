"""The stereo loop: head pose, server, link, newest pose, client. Every driver drives this one."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

if TYPE_CHECKING:
    from .client.compensator import Compensator, EyeResult
    from .frame import Frame
    from .headsets import Headset
    from .link import ConstantLink
    from .poses import PoseSample
    from .rig import Requested
    from .server import Server


@attrs.frozen(eq=False)
class Refresh:
    """One picture pair: when and for which head it was made, from which frame, and what came out (overwritten at the next)."""

    shown_ns: int
    head: PoseSample
    frame: Frame
    eyes: tuple[EyeResult, ...]
    stage_ms: tuple[tuple[tuple[str, float], ...], ...]

    @property
    def age_ns(self) -> int:
        """How long before it is seen the frame was drawn."""
        return self.shown_ns - self.frame.drawn_ns


class Loop:
    """One refresh after the other: `draw` what the server sends now, `show` what has arrived by the display instant."""

    def __init__(self, requested: Requested, server: Server, link: ConstantLink, compensator: Compensator, headset: Headset) -> None:
        self._requested, self._server, self._link = requested, server, link
        self._compensator, self._headset = compensator, headset

    def draw(self, now_ns: int) -> None:
        """The server draws both eyes for the pose it is asked for now, and the frame goes on its way."""
        head = self._requested.for_server(now_ns)
        size, guard = self._requested.size, self._requested.guard
        frame = self._server.draw_frame(self._headset.views(head.pose), now_ns, size, guard)
        self._link.send(attrs.evolve(frame, head=head), now_ns)

    def show(self, shown_ns: int) -> Refresh | None:
        """Warp the newest frame that has arrived to the head at `shown_ns`; None before the first frame has arrived."""
        frame = self._link.newest(shown_ns)
        if frame is None:
            return None
        head = self._requested.for_display(shown_ns)
        eyes, times = [], []
        for eye, view in enumerate(self._headset.views(head.pose)):
            eyes.append(self._compensator.run(frame.eyes[eye], view, eye))
            times.append(tuple(self._compensator.gpu.timer.collect()))
        return Refresh(shown_ns, head, frame, tuple(eyes), tuple(times))
