"""What a live run remembers: frames.csv and summary.json as of a replay, and the numbers for the panel."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs

from ..display import Display, Tick
from ..display.status import Status
from .options import LiveOptions

if TYPE_CHECKING:
    from ..loop import Refresh
    from .stage import Stage


@attrs.frozen(eq=False)
class LiveResult:
    """folder: where it was written, None if nowhere. summary: as summary.json, with `live` beside."""

    folder: Path | None
    summary: dict[str, Any]

    def told(self) -> list[str]:
        """What to tell at the end, line by line."""
        return []


class LiveLog:
    """count: refreshes with a picture. status: the numbers of the last ones."""

    def __init__(self, options: LiveOptions) -> None:
        self.count = 0
        self.status = Status()

    def begin(self, display: Display, stage: Stage) -> None:
        """The display is there."""
        self.status.budget_ms = 1e3 / display.rate_hz

    def changed(self, stage: Stage) -> None:
        """The options were changed."""

    def add(self, tick: Tick, refresh: Refresh | None, submitted_ns: int, notice: str) -> None:
        """One refresh was handed over."""
        self.count += refresh is not None
        self.status.notice = notice

    def finish(self) -> None:
        """Write what there is. May be called twice, and from another thread."""

    def result(self) -> LiveResult:
        """What came out."""
        return LiveResult(None, {})

    def __enter__(self) -> LiveLog:
        return self

    def __exit__(self, *_: object) -> None:
        self.finish()
