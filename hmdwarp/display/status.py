"""Figures of the last refreshes for the title line and the control panel; free while hidden."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from statistics import fmean

import attrs

KEPT = 240  # refreshes in the plots


def _plot() -> deque[float]:
    return deque(maxlen=KEPT)


@attrs.define(eq=False)
class Status:
    """What the title line and the control panel show.

    Deques hold the last refreshes, oldest first.
    """

    # the current value of each control, by its name
    values: dict[str, object] = attrs.field(factory=dict)
    # values of controls of kind "choice", including the current one
    choices: Mapping[str, tuple[object, ...]] = attrs.field(factory=dict)
    budget_ms: float = 0.0  # a refresh of the display
    stage_ms: dict[str, float] = attrs.field(factory=dict)  # of the last refresh, both eyes
    total_ms: deque[float] = attrs.field(factory=_plot)  # all passes of both eyes
    age_ms: deque[float] = attrs.field(factory=_plot)  # from drawing the shown frame to showing it
    # from reading the head to handing the picture over
    pose_age_ms: deque[float] = attrs.field(factory=_plot)
    # share of pixels without coverage after the warp; NaN where not counted
    holes: deque[float] = attrs.field(factory=_plot)
    period_ms: deque[float] = attrs.field(factory=_plot)  # between two pictures
    missed: int = 0  # refreshes without a new picture, since the start
    notice: str = ""  # as Tick.notice
    recording: bool = False
    # title instead of settings and numbers, which would reveal the condition; "" for those
    heading: str = ""

    @property
    def rate_hz(self) -> float:
        """Pictures a second, over the last second or so; 0 before there were two."""
        last = list(self.period_ms)[-60:]
        return 1e3 / fmean(last) if last and fmean(last) > 0 else 0.0

    def title(self) -> str:
        """Return one line for the window's title."""
        notice = f" - {self.notice}" if self.notice else ""
        if self.heading:
            return f"hmdwarp - {self.heading}{notice}"
        v = self.values
        chosen = f"{v.get('scene', '')} - {v.get('warp', '')} + {v.get('fill', '')} - {v.get('latency', 0):g} ms"
        holes = f", holes {self.holes[-1]:.1%}" if self.holes and self.holes[-1] == self.holes[-1] else ""
        age = f", age {self.age_ms[-1]:.0f} ms" if self.age_ms else ""
        return f"hmdwarp - {chosen} - {self.rate_hz:.0f} fps{age}{holes}, {self.missed} missed{notice}"
