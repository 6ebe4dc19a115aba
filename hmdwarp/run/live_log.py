"""Log of a live run: frames.csv and summary.json as of a replay, and the numbers for the panel."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..display import Display, Status, Tick
from ..pipeline.governor import AdaptiveCompensator
from ..pipeline.loop import Refresh
from ..report import OutputFolder, live_lines, render_live_report
from ..scenes import InputEvent
from .frame_rows import HEADER, NOT_KNOWN, STAGE_COLUMNS, Moment, rows_text, speeds_between, stage_columns
from .host import PipelineHost, values
from .live_figures import HoleCounter, LiveFacts, LiveFigures, Pictures, live_facts_of, live_summary_of
from .misses import DepthSamples, SeenOffset
from .options import LiveOptions
from .recorder import Lines
from .run_summary import OWNED

_STAGES = tuple(name.removesuffix("_ms") for name in STAGE_COLUMNS[:-1])
_NO_EYE = (math.nan,) * (len(STAGE_COLUMNS) + 1)  # columns of an absent eye


@attrs.frozen(eq=False)
class LiveResult:
    """The results of a live run."""

    # Output folder; None if nothing was written.
    folder: Path | None
    # As summary.json, including `live`.
    summary: dict[str, Any]

    def __repr__(self) -> str:
        return f"<LiveResult {self.summary['warp']} + {self.summary['fill']}; {self.folder}>"

    def describe(self) -> list[str]:
        """Return the lines to print at the end."""
        return live_lines(self.summary, self.folder)


@attrs.define(eq=False)
class _Files:
    """Files that grow during the run."""

    out: OutputFolder
    rows: Lines
    pictures: Pictures

    @classmethod
    def of(cls, options: LiveOptions) -> _Files | None:
        if options.out is None:
            return None
        out = OutputFolder(options.out, owned=OWNED, force=options.force)
        return cls(out, Lines(out.path("frames.csv")), Pictures(out, options.images_every))


@attrs.define(eq=False)
class _Running:
    """The part of a log that exists once the display is open."""

    facts: LiveFacts
    host: PipelineHost
    holes: HoleCounter
    # The current value of each control.
    values: dict[str, object]
    # Where things are seen in a picture that is shown again.
    depths: DepthSamples
    offset: SeenOffset
    # What chose warps last, and how many of its switches are logged.
    auto: AdaptiveCompensator | None = None
    auto_changes: int = 0


@attrs.define(eq=False)
class _Last:
    """The previous picture."""

    # Of the first picture.
    first_ns: int = 0
    refresh: Refresh | None = None
    # When it was submitted; None after a refresh without a picture.
    submitted_ns: int | None = None
    # Its entry still to be logged: its times are known at the next refresh.
    pending: tuple[Moment, Refresh, float] | None = None

    @property
    def time_s(self) -> float:
        """Time since the first picture."""
        return (self.refresh.shown_ns - self.first_ns) * 1e-9 if self.refresh is not None else 0.0


class LiveLog:
    """Log of a live run. Use as a context manager: it writes the results on exit.

    The times of a refresh are read at the next one, so nothing here waits for the GPU. A refresh
    costs some 50 us, half of that only with an output folder. Memory is bounded for runs of any
    length; frames.csv grows on the disk.
    Errors: InputError for a folder that cannot be written; from add, MachineError for a full disk.
    """

    def __init__(self, options: LiveOptions) -> None:
        # Refreshes with a picture.
        self.count = 0
        # Recent numbers for the display.
        self.status = Status(recording=options.record is not None)
        self._options = options
        self._files = _Files.of(options)
        self._figures = LiveFigures()
        self._running: _Running | None = None
        self._last = _Last()
        self._summary: dict[str, Any] = {}
        self._written = False
        self._finishing, self._finished = threading.Lock(), False

    def begin(self, display: Display, host: PipelineHost) -> None:
        """Start logging on this display."""
        facts = live_facts_of(attrs.evolve(self._options, latency_ms=host.options.latency_ms), display, host)
        now = values(host.options, host.run.sizes.shown)
        seen = DepthSamples(display.gpu), SeenOffset(turned=facts.turns)
        self._running = _Running(facts, host, HoleCounter(display.gpu), now, *seen)
        self.status.budget_ms = facts.budget_ms
        if self._files is not None:
            self._files.rows.add(HEADER)

    def changed(self, host: PipelineHost) -> None:
        """Log a change of options."""
        if self._running is None:
            return
        now = values(host.options, host.run.sizes.shown)
        self._figures.events.changed(self.count - 1, self._last.time_s, self._running.values, now, "")
        self._running.values = now

    def acted(self, event: InputEvent) -> None:
        """Log what somebody did in the scene."""
        self._figures.answers.add(event)

    def on_display_lost(self, why: str) -> None:
        """Log the loss of the display."""
        self._figures.events.on_display_lost(self.count - 1, self._last.time_s, why)
        self._last.submitted_ns = None

    def came_back(self) -> None:
        """Log the return of the display."""
        self._figures.events.came_back()

    def add(self, tick: Tick, refresh: Refresh | None, submitted_ns: int, notice: str) -> None:
        """Log a submitted refresh."""
        if self._finished or self._running is None:  # the watchdog has closed the log, and the hung call has returned
            return
        counts, running, shown = self._figures.counts, self._running, self._last.refresh
        self._settle(refresh)
        if self.count:
            # A runtime turns the last picture to the newest head. In a window it stands; the head
            # is taken to move as fast as from that picture to this one.
            counts.missed += tick.missed
            off_deg = [0.0] * tick.missed
            if tick.missed and refresh and shown:
                periods = max(1, round((refresh.shown_ns - shown.shown_ns) * 1e-6 / running.facts.budget_ms))
                depths = running.depths.before(len(shown.inputs))
                off_deg = running.offset.between_deg(shown, depths, refresh, tick.missed, periods)
            for off in off_deg:
                self._figures.misses.add(True, off)
        self.status.missed, self.status.notice = counts.missed, notice
        if notice:
            self._figures.events.noticed(notice)
        if refresh is None:
            counts.waiting += tick.render
            counts.unseen += not tick.render
            self._last.submitted_ns = None
            return
        self._figures.misses.add(False, 0.0)
        status, last = self.status, self._last
        if not self.count:
            last.first_ns = refresh.shown_ns
            # Not sooner: GarbageControl starts with a large collection.
            self._figures.pauses.start()
        self._figures.answers.see(refresh.shown_ns, refresh.frame.shows_ns)
        speeds = speeds_between(last.refresh, refresh)
        moment = Moment.of(self.count, refresh, last.first_ns, speeds, submitted_ns)
        period_ms = (submitted_ns - last.submitted_ns) * 1e-6 if last.submitted_ns is not None else math.nan
        status.age_ms.append(moment.age_ms)
        if moment.pose_age_ms is not None:
            status.pose_age_ms.append(moment.pose_age_ms)
        if last.submitted_ns is not None:
            status.period_ms.append(period_ms)
        if self._files is not None and self._files.pictures.wants(self.count):
            self._files.pictures.keep(self.count, refresh)
        last.refresh, last.submitted_ns, last.pending = refresh, submitted_ns, (moment, refresh, period_ms)
        self._figures.fates.follow(running.host.run.channel)
        auto = running.host.run.auto
        if auto is not running.auto:  # the pipeline was built anew
            running.auto, running.auto_changes = auto, 0
        for change in auto.changes[running.auto_changes :] if auto is not None else ():
            before, after = ({"warp": passes.warp, "fill": passes.fill} for passes in (change.before, change.after))
            self._figures.events.changed(self.count - 1, last.time_s, before, after, change.reason)
            running.auto_changes += 1
        self.count += 1

    def _settle(self, now: Refresh | None) -> None:
        """Log the previous refresh: its times are known by now, and its holes soon."""
        if self._running is None:
            return
        warped = [eye.warped for eye in now.eyes if eye.warped is not None] if now is not None else []
        if now is not None:
            self._running.depths.take(now.inputs)
        if self._last.pending is not None or warped:
            self._running.holes.count(warped)
        if self._last.pending is None:
            return
        (moment, refresh, period_ms), self._last.pending = self._last.pending, None
        stages = [tuple(stage_columns(of_eye).values()) for of_eye in refresh.stage_ms]
        holes = self._running.holes.shares() or (None,) * moment.eyes
        render_ms = sum(ms for _, ms in refresh.frame.drawing.read()) if refresh.frame.drawing is not None else 0.0
        passes_ms = sum(stage[-1] for stage in stages)
        status, known = self.status, [share for share in holes if share is not None]
        status.stage_ms = {name: sum(stage[at] for stage in stages) for at, name in enumerate(_STAGES)}
        status.total_ms.append(passes_ms)
        status.holes.append(sum(known) / len(known) if len(known) == len(holes) else math.nan)
        figures = self._figures
        figures.counts.timed += 1
        figures.counts.over += render_ms + passes_ms > self.status.budget_ms
        figures.times.add(_numbers(moment, (period_ms, render_ms, render_ms + passes_ms), stages, holes))
        figures.fates.add(refresh)
        if self._files is not None:
            self._files.rows.add(rows_text(moment, stages, holes))

    def leave(self) -> None:
        """Read the times of the last refresh, before the GPU goes away. Failures are ignored."""
        self._figures.pauses.stop()
        with suppress(Exception):
            self._settle(None)
        if self._running is not None:
            with suppress(Exception):
                self._running.holes.close()
                self._running.depths.close()

    def finish(self) -> None:
        """Write the results.

        Safe to call twice, and from another thread: it does not touch the GPU. Errors: InputError
        or MachineError for a folder that cannot be written any more; complete files stay there.
        """
        with self._finishing:
            if self._finished:
                return
            self._finished = True
        self._figures.pauses.stop()
        self._finish()

    def _finish(self) -> None:
        files = self._files
        if self._running is None or not self.count:
            if files is not None:
                with suppress(Exception):
                    files.rows.close()
                files.out.discard()
        elif files is None:
            self._summary = self._sum_up(self._running)
        else:
            try:
                self._write(files, self._running)
            finally:
                files.out.commit()
                self._written = True

    def _write(self, files: _Files, running: _Running) -> None:
        if self._last.pending is not None:  # the GPU went away before its times could be read
            moment = self._last.pending[0]
            files.rows.add(rows_text(moment, [NOT_KNOWN] * moment.eyes, (None,) * moment.eyes))
        try:
            files.rows.close()
        finally:
            files.pictures.close()
        self._summary = self._sum_up(running)
        page = render_live_report(self._summary, self._figures.times.column, command=self._options.command)
        files.out.write_text("report.html", page)
        files.out.write_json("summary.json", self._summary)

    def _sum_up(self, running: _Running) -> dict[str, Any]:
        pictures = self._files.pictures if self._files is not None else None
        return live_summary_of(running.facts, self.count, self._figures, pictures)

    def column(self, name: str) -> NDArray[np.float64]:
        """Return one of live_figures.COLUMNS for each refresh; in a long run, for every n-th.

        NaN where it was not measured.
        """
        return self._figures.times.column(name)

    def result(self) -> LiveResult:
        """Return the results of the run."""
        return LiveResult(self._options.out if self._written else None, self._summary)

    def __enter__(self) -> LiveLog:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.finish()
            return
        with suppress(Exception):  # the exception that ended the run matters more
            self.finish()


def _numbers(
    moment: Moment,
    times_ms: tuple[float, float, float],
    stages: Sequence[Sequence[float]],
    holes: Sequence[float | None],
) -> list[float]:
    """Return a row as live_figures.COLUMNS; times_ms: from picture to picture, drawing, total."""
    period_ms, render_ms, busy_ms = times_ms
    shared = (moment.time_s, moment.age_ms, moment.pose_age_ms, period_ms, *moment.speeds, render_ms, busy_ms)
    row = [math.nan if value is None else value for value in shared]
    for one, share in zip(stages, holes, strict=True):
        row += one
        row.append(math.nan if share is None else share)
    if len(stages) == 1:
        row += _NO_EYE
    return row
