"""What is going on, for the title line and the panel: numbers of the last refreshes, nothing that costs anything when nobody looks."""

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
    """values: what each control is set to, by its name; choices: what those of kind "choice" may be set to, the present one included.

    budget_ms: a refresh of the display. The deques hold the last refreshes, oldest first: total_ms: all passes of both eyes;
    age_ms: from drawing the shown frame to showing it; pose_age_ms: from reading the head to handing the picture over; holes: share of
    pixels without coverage after the warp (NaN where it was not counted); period_ms: between two pictures. stage_ms: of the last refresh,
    both eyes. missed: refreshes without a new picture, since the start. notice: as Tick.notice. heading: stands in the title in place of
    settings and numbers, which tell whoever looks what is on; "" for those.
    """

    values: dict[str, object] = attrs.field(factory=dict)
    choices: Mapping[str, tuple[object, ...]] = attrs.field(factory=dict)
    budget_ms: float = 0.0
    stage_ms: dict[str, float] = attrs.field(factory=dict)
    total_ms: deque[float] = attrs.field(factory=_plot)
    age_ms: deque[float] = attrs.field(factory=_plot)
    pose_age_ms: deque[float] = attrs.field(factory=_plot)
    holes: deque[float] = attrs.field(factory=_plot)
    period_ms: deque[float] = attrs.field(factory=_plot)
    missed: int = 0
    notice: str = ""
    recording: bool = False
    heading: str = ""

    @property
    def rate_hz(self) -> float:
        """Pictures a second, over the last second or so; 0 before there were two."""
        last = list(self.period_ms)[-60:]
        return 1e3 / fmean(last) if last and fmean(last) > 0 else 0.0

    def title(self) -> str:
        """One line for the window's title."""
        notice = f" - {self.notice}" if self.notice else ""
        if self.heading:
            return f"hmdwarp - {self.heading}{notice}"
        v = self.values
        chosen = f"{v.get('scene', '')} - {v.get('warp', '')} + {v.get('fill', '')} - {v.get('latency', 0):g} ms"
        holes = f", holes {self.holes[-1]:.1%}" if self.holes and self.holes[-1] == self.holes[-1] else ""
        age = f", age {self.age_ms[-1]:.0f} ms" if self.age_ms else ""
        return f"hmdwarp - {chosen} - {self.rate_hz:.0f} fps{age}{holes}, {self.missed} missed{notice}"
