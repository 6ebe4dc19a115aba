"""What a live run remembers: frames.csv and summary.json as of a replay, and the numbers for the panel."""

from __future__ import annotations

import math
import threading
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...display import Display, Tick
from ...display.status import Status
from ...report import OutputFolder, live_lines, render_live_report
from ..log import stage_columns
from ..outcome import OWNED
from .changes import values
from .events import Events
from .facts import Facts, facts_of
from .holes import HoleCounter
from .lines import Lines
from .options import LiveOptions
from .outcome import COLUMNS, Counts, Fates, summary_of
from .pauses import Pauses
from .pictures import Pictures
from .rows import HEADER, NOT_KNOWN, STAGE_COLUMNS, Moment, rows_text
from .speeds import speeds_between
from .thinned import Thinned

if TYPE_CHECKING:
    from ...pipeline.loop import Refresh
    from .host import Stage

_STAGES = tuple(name.removesuffix("_ms") for name in STAGE_COLUMNS[:-1])
_NOT_HERE = (math.nan,) * (len(STAGE_COLUMNS) + 1)  # of an eye that the view has not


@attrs.frozen(eq=False)
class LiveResult:
    """folder: where it was written, None if nowhere. summary: as summary.json, with `live` beside."""

    folder: Path | None
    summary: dict[str, Any]

    def told(self) -> list[str]:
        """What to tell at the end, line by line."""
        return live_lines(self.summary, self.folder)


class LiveLog:
    """count: refreshes with a picture. status: the numbers of the last ones.

    What a refresh took is read at the next one: nothing here waits for the GPU. A refresh costs some 50 us, half of them only where there
    is a folder to write to. Memory is bounded, however long a run is; frames.csv grows on the disk.
    Errors: InputError for a folder that cannot be written; from add, MachineError for a disk that is full.
    """

    def __init__(self, options: LiveOptions) -> None:
        self.count = 0
        self.status = Status(recording=options.record is not None)
        self._options = options
        self._out = OutputFolder(options.out, owned=OWNED) if options.out is not None else None
        self._rows = Lines(self._out.path("frames.csv")) if self._out is not None else None
        self._pictures = Pictures(self._out, options.images_every if self._out is not None else 0)
        self._figures, self._events, self._pauses, self._counts = Thinned(COLUMNS), Events(), Pauses(), Counts()
        self._fates = Fates()
        self._facts: Facts | None = None
        self._holes: HoleCounter | None = None
        self._stage: Stage | None = None
        self._values: dict[str, object] = {}
        self._auto_changes = 0
        self._first_ns = 0
        self._before: Refresh | None = None
        self._submitted_ns: int | None = None
        self._pending: tuple[Moment, Refresh, float] | None = None
        self._summary: dict[str, Any] = {}
        self._written = False
        self._finishing, self._finished = threading.Lock(), False

    def begin(self, display: Display, stage: Stage) -> None:
        """The display is there."""
        self._facts, self._stage, self._values = facts_of(self._options, display, stage), stage, values(stage.options)
        self._holes = HoleCounter(display.gpu)
        self.status.budget_ms = self._facts.budget_ms
        if self._rows is not None:
            self._rows.add(HEADER)

    def changed(self, stage: Stage) -> None:
        """The options were changed."""
        now = values(stage.options)
        self._events.changed(self.count - 1, self._time_s, self._values, now, "")
        self._values, self._auto_changes = now, 0

    def on_display_lost(self, why: str) -> None:
        """The display went away."""
        self._events.on_display_lost(self.count - 1, self._time_s, why)
        self._submitted_ns = None

    def came_back(self) -> None:
        """It is there again."""
        self._events.came_back()

    def add(self, tick: Tick, refresh: Refresh | None, submitted_ns: int, notice: str) -> None:
        """One refresh was handed over."""
        if self._finished:  # by the watchdog, and what hung has come back
            return
        self._settle(refresh)
        self._counts.missed += tick.missed
        self.status.missed, self.status.notice = self._counts.missed, notice
        if notice:
            self._events.noticed(notice)
        if refresh is None:
            self._counts.without(tick)
            self._submitted_ns = None
            return
        self._look_at(refresh, submitted_ns)

    def _look_at(self, refresh: Refresh, submitted_ns: int) -> None:
        if not self.count:
            self._first_ns = refresh.shown_ns
            self._pauses.start()  # not sooner: Tidying begins with a large collection
        moment = self._moment(refresh, submitted_ns)
        period_ms = (submitted_ns - self._submitted_ns) * 1e-6 if self._submitted_ns is not None else math.nan
        status = self.status
        status.age_ms.append(moment.age_ms)
        if moment.pose_age_ms is not None:
            status.pose_age_ms.append(moment.pose_age_ms)
        if self._submitted_ns is not None:
            status.period_ms.append(period_ms)
        if self._pictures.wants(self.count):
            self._pictures.keep(self.count, refresh)
        self._before, self._submitted_ns, self._pending = refresh, submitted_ns, (moment, refresh, period_ms)
        self._fates.follow(self._stage.pipeline.channel)
        self._notice_auto()
        self.count += 1

    def _moment(self, refresh: Refresh, submitted_ns: int) -> Moment:
        head, frame, plan = refresh.head, refresh.frame, refresh.plan
        turning, moving = speeds_between(self._before, refresh)
        return Moment(
            self.count,
            (refresh.shown_ns - self._first_ns) * 1e-9,
            refresh.shown_ns,
            frame.drawn_ns,
            refresh.age_ns * 1e-6,
            None if head.read_ns is None else (submitted_ns - head.read_ns) * 1e-6,
            turning,
            moving,
            head,
            frame.head,
            str(plan.choice),
            plan.fill,
            len(refresh.eyes),
        )

    def _settle(self, now: Refresh | None) -> None:
        """What the refresh before took is known by now, and its holes once those of the present one are being counted."""
        warped = [eye.warped for eye in now.eyes if eye.warped is not None] if now is not None else []
        if self._pending is not None or warped:
            self._holes.count(warped)
        if self._pending is None:
            return
        (moment, refresh, period_ms), self._pending = self._pending, None
        stages = [tuple(stage_columns(one).values()) for one in refresh.stage_ms]
        holes = self._holes.shares() or (None,) * moment.eyes
        render_ms = sum(ms for _, ms in refresh.frame.drawing.read()) if refresh.frame.drawing is not None else 0.0
        passes_ms = sum(one[-1] for one in stages)
        status = self.status
        status.stage_ms = {name: sum(one[at] for one in stages) for at, name in enumerate(_STAGES)}
        status.total_ms.append(passes_ms)
        status.holes.append(sum(holes) / len(holes) if None not in holes else math.nan)
        self._counts.busy(render_ms + passes_ms > status.budget_ms)
        self._figures.add(self._numbers(moment, period_ms, render_ms, render_ms + passes_ms, stages, holes))
        self._fates.look(refresh)
        if self._rows is not None:
            self._rows.add(rows_text(moment, stages, holes))

    def _numbers(
        self, moment: Moment, period_ms: float, render_ms: float, busy_ms: float, stages: list, holes: tuple
    ) -> list[float]:
        """In the order of outcome.COLUMNS."""
        shared = (
            moment.time_s,
            moment.age_ms,
            moment.pose_age_ms,
            period_ms,
            moment.angular_speed_deg_s,
            moment.linear_speed_m_s,
        )
        row = [math.nan if value is None else value for value in shared]
        row += (render_ms, busy_ms)
        for one, share in zip(stages, holes, strict=True):
            row += one
            row.append(math.nan if share is None else share)
        if len(stages) == 1:
            row += _NOT_HERE
        return row

    def _notice_auto(self) -> None:
        auto = self._stage.pipeline.auto
        if auto is not None and len(auto.changes) > self._auto_changes:
            for change in auto.changes[self._auto_changes :]:
                before, after = ({"warp": one.warp, "fill": one.fill} for one in (change.before, change.after))
                self._events.changed(self.count - 1, self._time_s, before, after, change.reason)
            self._auto_changes = len(auto.changes)

    @property
    def _time_s(self) -> float:
        """Of the last picture."""
        return (self._before.shown_ns - self._first_ns) * 1e-9 if self._before is not None else 0.0

    def leave(self) -> None:
        """The GPU is about to go: read what the last refresh took. Whatever ended the run, this does not stand in its way."""
        self._pauses.stop()
        with suppress(Exception):
            self._settle(None)
        if self._holes is not None:
            with suppress(Exception):
                self._holes.close()

    def finish(self) -> None:
        """Write what there is. May be called twice, and from another thread: it touches no GPU.

        Errors: InputError or MachineError for a folder that cannot be written any more; what is whole stays there.
        """
        with self._finishing:
            if self._finished:
                return
            self._finished = True
        self._pauses.stop()
        if self._facts is None or not self.count:
            if self._out is not None:
                with suppress(Exception):
                    self._rows.close()
                self._out.discard()
            return
        if self._out is None:
            self._summary = self._sum_up()
            return
        try:
            self._write(self._out)
        finally:
            self._out.commit()
            self._written = True

    def _write(self, out: OutputFolder) -> None:
        if self._pending is not None:  # nobody could ask the GPU any more
            moment = self._pending[0]
            self._rows.add(rows_text(moment, [NOT_KNOWN] * moment.eyes, (None,) * moment.eyes))
        try:
            self._rows.close()
        finally:
            self._pictures.close()
        self._summary = self._sum_up()
        page = render_live_report(self._summary, self._figures.column, command=self._options.command)
        out.write_text("report.html", page)
        out.write_json("summary.json", self._summary)

    def _sum_up(self) -> dict[str, Any]:
        return summary_of(
            self._facts,
            self.count,
            self._counts,
            self._figures,
            self._fates,
            self._events,
            self._pauses,
            self._pictures,
        )

    def column(self, name: str) -> NDArray[np.float64]:
        """One number of outcome.COLUMNS for each refresh, as far as known; NaN where it was not measured. Of a long run every n-th."""
        return self._figures.column(name)

    def result(self) -> LiveResult:
        """What came out."""
        return LiveResult(self._options.out if self._written else None, self._summary)

    def __enter__(self) -> LiveLog:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.finish()
            return
        with suppress(Exception):  # what ended the run is what the user must hear
            self.finish()
