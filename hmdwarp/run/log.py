"""Log of a replay: one row per eye and refresh, as in frames.csv, in compact form."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..link import ResponseTime
from ..metrics import QUALITY
from ..pipeline.loop import Refresh
from ..poses import PoseTrack
from .frame_rows import NOT_KNOWN, STAGE_COLUMNS, Moment, Row, Stages, stage_columns
from .speeds import speeds_at
from .timeline import Timeline

_NOT_MEASURED = dict.fromkeys(QUALITY)
_NO_PASSES = dict(zip(STAGE_COLUMNS, NOT_KNOWN, strict=True))


class ReplayLog:
    """Rows and response times of a replay.

    Poses are kept as objects and turned into columns only when written: ten minutes at 60 Hz are
    72,000 rows.
    """

    def __init__(self, track: PoseTrack) -> None:
        self._track = track
        # Two for each refresh; figures are made from them.
        self.rows: list[Row] = []
        # One for each refresh with a new picture.
        self.responses: list[ResponseTime] = []
        self.timeline = Timeline()
        # One for each refresh.
        self.moments: list[Moment] = []

    def add(self, refresh: Refresh, *, stale: bool = False) -> None:
        """Add the next refresh. stale: it shows a picture again, and no passes ran."""
        speeds = speeds_at(self._track, refresh.shown_ns)
        moment = Moment.of(len(self.moments), refresh, self._track.start_ns, speeds)
        self.moments.append(moment)
        if not stale:
            self.responses.append(refresh.response)
        self.timeline.add(refresh)
        figures = moment.figures()
        for eye, stages in enumerate(refresh.stage_ms):
            self.rows.append({**figures, "eye": eye, **(_NO_PASSES if stale else stage_columns(stages))})

    def measured(self, figures: Mapping[tuple[int, int], Row]) -> None:
        """Add the figures of the measured refreshes, by (frame, eye)."""
        for row in self.rows:
            row.update(figures.get((row["frame"], row["eye"]), _NOT_MEASURED))

    def compared(self, times: Mapping[tuple[int, int], Stages], figures: Mapping[tuple[int, int], Row]) -> list[Row]:
        """Return rows of the comparison warp, which ran along with this one on some refreshes.

        They have its own times and figures, and the same head poses.
        """
        return [
            {**row, **stage_columns(times[key]), **figures.get(key, _NOT_MEASURED)}
            for row in self.rows
            if (key := (row["frame"], row["eye"])) in times
        ]

    def frames_csv(self) -> Iterator[Row]:
        """Yield the rows with the columns of report.FRAME_COLUMNS.

        Both eyes share the poses.
        """
        for row in self.rows:
            yield {**row, **self.moments[row["frame"]].poses()}
