"""The way of a run's last frames from the server to the eye, part by part."""

from __future__ import annotations

from collections import deque
from typing import Any

import attrs

from ..link import TransitStats
from ..pipeline.loop import Refresh

MOST_FRAMES = 12


@attrs.define(eq=False)
class _Shown:
    transit: TransitStats
    first_ns: int
    last_ns: int


class Timeline:
    """Keep how the last MOST_FRAMES frames that were shown came there, and when they were seen."""

    def __init__(self) -> None:
        self._kept: deque[_Shown] = deque(maxlen=MOST_FRAMES)

    def add(self, refresh: Refresh) -> None:
        """Add a refresh; it may show the frame of the one before."""
        if self._kept and self._kept[-1].transit is refresh.transit:
            self._kept[-1].last_ns = refresh.shown_ns
        else:
            self._kept.append(_Shown(refresh.transit, refresh.shown_ns, refresh.shown_ns))

    def as_list(self) -> list[dict[str, Any]]:
        """Return the `timeline` of summary.json, in ms since the first of its frames was drawn.

        parts: each part of the way, in order; shown, until: the first and the last refresh.
        """
        if not self._kept:
            return []
        start_ns = self._kept[0].transit.sent_ns
        return [
            {
                "frame": shown.transit.number,
                "drawn": (shown.transit.sent_ns - start_ns) * 1e-6,
                "parts": {name: part_ns * 1e-6 for name, part_ns in shown.transit.parts_ns().items()},
                "shown": (shown.first_ns - start_ns) * 1e-6,
                "until": (shown.last_ns - start_ns) * 1e-6,
            }
            for shown in self._kept
        ]
