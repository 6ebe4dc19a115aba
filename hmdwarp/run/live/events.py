"""What happened while a live run went on, in bounded bytes: changes by hand and by warp "auto", notices, times without the display."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Mapping
from typing import Any

MOST_TOLD = 1000  # changes, losses; a held key makes thirty a second
_MOST_NOTICES = 50  # different ones
_MORE = "others"


class Events:
    """changes: settings, [before, after] by name, with the instant of the last picture made before. lost: why and for how long."""

    def __init__(self) -> None:
        self.changes: list[dict[str, Any]] = []
        self.notices: Counter[str] = Counter()
        self.lost: list[dict[str, Any]] = []
        self.change_count = 0
        self._lost_at: float | None = None

    def changed(
        self, frame: int, time_s: float, before: Mapping[str, object], after: Mapping[str, object], reason: str
    ) -> None:
        """Some settings are others from now on. frame, time_s: of the last picture. reason: "" for by hand."""
        what = {name: [before.get(name), value] for name, value in after.items() if before.get(name) != value}
        if not what:
            return
        self.change_count += 1
        if len(self.changes) < MOST_TOLD:
            self.changes.append({"time_s": time_s, "frame": frame, "what": what, "reason": reason or "by hand"})

    def noticed(self, notice: str) -> None:
        """The one who looks was told this at a refresh."""
        self.notices[notice if notice in self.notices or len(self.notices) < _MOST_NOTICES else _MORE] += 1

    def on_display_lost(self, frame: int, time_s: float, why: str) -> None:
        """The display went away."""
        self._lost_at = time.monotonic()
        if len(self.lost) < MOST_TOLD:
            self.lost.append({"time_s": time_s, "frame": frame, "why": why, "away_s": None})

    def came_back(self) -> None:
        """It is there again."""
        if self._lost_at is not None and self.lost:
            self.lost[-1]["away_s"] = time.monotonic() - self._lost_at
        self._lost_at = None

    def as_dict(self) -> dict[str, Any]:
        """For summary.json."""
        return {
            "changes": self.changes,
            "change_count": self.change_count,
            "notices": dict(self.notices.most_common()),
            "lost": self.lost,
        }
