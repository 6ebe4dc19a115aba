"""Log of a live run of any length, in bounded memory: frames.csv, summary.json, and the panel."""

from __future__ import annotations

import math
import threading
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..base import AUTO
from ..display import Display, Status, Tick
from ..gpu import Canvas, Gpu
from ..link import ResponseTime, figures_of_parts
from ..metrics import aggregate_columns, middle_and_tail
from ..pipeline import Channel, Refresh
from ..pipeline.governor import AdaptiveCompensator
from ..report import FRAME_COLUMNS, OutputFolder, live_lines, render_live_report
from ..scenes import InputEvent
from .options import LiveOptions
from .recorder import Lines
from .run import Run
from .run_summary import (
    OWNED,
    STAGE_COLUMNS,
    Answers,
    Row,
    Timeline,
    csv_text,
    row_of,
    speeds_between,
    stage_columns,
    summary_of,
)

Array = NDArray[np.float64]
_MOST_EYES = 2


class HoleCounter:
    """Count holes on the GPU: count() starts, shares() returns those of the count before.

    The shader fills two buffers by turns: the one before is finished, so nothing stalls.
    """

    def __init__(self, gpu: Gpu) -> None:
        self._gl, self._program = gpu.gl, gpu.shaders.compute("live/holes.comp")
        self._now, self._before = (gpu.gl.buffer(reserve=4 * _MOST_EYES) for _ in range(2))
        # Cleared by a copy on the GPU: a write from the CPU could wait for a pending read.
        self._empty = gpu.gl.buffer(bytes(4 * _MOST_EYES))
        self._pixels: tuple[int, ...] | None = None
        self._pixels_before: tuple[int, ...] | None = None

    def count(self, canvases: Sequence[Canvas]) -> None:
        """Count the pixels with alpha 0 of each eye's picture; call once a refresh."""
        self._now, self._before = self._before, self._now
        self._pixels_before, self._pixels = self._pixels, tuple(canvas.size[0] * canvas.size[1] for canvas in canvases)
        self._gl.copy_buffer(self._now, self._empty)
        self._now.bind_to_storage_buffer(0)
        for slot, canvas in enumerate(canvases):
            canvas.texture.bind_to_image(0, read=True, write=False)
            self._program.uniforms.set(picture=0, size=canvas.size, slot=slot)
            self._program.run(*canvas.size)
        self._gl.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)

    def shares(self) -> tuple[float, ...] | None:
        """Return the share of holes in each eye's pixels, 0..1; None before the second count."""
        if self._pixels_before is None:
            return None
        counts = np.frombuffer(self._before.read(), np.uint32)
        return tuple(int(count) / pixels for count, pixels in zip(counts, self._pixels_before, strict=False))

    def close(self) -> None:
        for buffer in (self._now, self._before, self._empty):
            buffer.release()


MOST_ROWS = 1 << 15  # six minutes at 90 Hz are kept whole
MOST_EVENTS = 1000  # switches, losses; a held key makes thirty a second
_MOST_NOTICES = 50  # different ones
OF_EYE = (*STAGE_COLUMNS, "hole_share")
_STAGES = {name.removesuffix("_ms"): name for name in STAGE_COLUMNS[:-1]}
_RESPONSE = tuple(ResponseTime().parts())
# Of a refresh; those of each eye have its number behind.
COLUMNS = (
    *("time_s", "age_ms", "pose_age_ms", "period_ms", "angular_speed_deg_s", "linear_speed_m_s"),
    *("render_ms", "busy_ms", *(f"{name}/{eye}" for eye in range(_MOST_EYES) for name in OF_EYE)),
    *(f"response/{part}" for part in _RESPONSE),
)


class Thinned:
    """A table of numbers, one row for each refresh, of bounded size.

    When it is full every other row is dropped, and from then on only every other row is kept: rows
    stay evenly spaced, at least `most` / 2 of them. most: an even number.
    """

    def __init__(self, columns: Sequence[str], most: int = MOST_ROWS) -> None:
        self._at = {name: index for index, name in enumerate(columns)}
        self._table = np.empty((most, len(columns)))
        self._seen = self._kept = 0
        # One row of so many is kept.
        self.every = 1

    def add(self, row: Mapping[str, float | None]) -> None:
        """Add the next row: the columns that were measured."""
        if self._seen % self.every == 0:
            if self._kept == len(self._table):
                self._kept //= 2
                self._table[: self._kept] = self._table[::2].copy()
                self.every *= 2
            # None becomes NaN.
            self._table[self._kept] = [row.get(name) for name in self._at]
            self._kept += 1
        self._seen += 1

    def column(self, name: str) -> Array:
        """Return all rows of one column, NaN where it was not measured."""
        return self._table[: self._kept, self._at[name]].copy()

    def measured(self, *names: str) -> Array:
        """Return the measured values of these columns, concatenated."""
        values = np.concatenate([self.column(name) for name in names])
        kept: Array = values[~np.isnan(values)]
        return kept


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
        return live_lines(self.summary, self.folder)


class Host(Protocol):
    """What has the run that is shown, and its options as they are now."""

    run: Run[LiveOptions]
    options: LiveOptions

    def values(self) -> dict[str, object]: ...


class LiveLog:
    """Log of a live run. Use as a context manager: it writes the results on exit.

    The times of a refresh are read at the next one, so nothing here waits for the GPU. A refresh
    costs some 60 us, half of that only with an output folder. Memory is bounded.
    Errors: InputError for a folder that cannot be written; from add, MachineError for a full disk.
    """

    def __init__(self, options: LiveOptions) -> None:
        # Refreshes with a picture.
        self.count = 0
        # Recent numbers for the display.
        self.status = Status(recording=options.record is not None)
        self.options = options
        self._out: OutputFolder | None = None
        if options.out is not None:
            self._out = OutputFolder(options.out, owned=OWNED, force=options.force)
            self._rows = Lines(self._out.path("frames.csv"))
        # One row for each refresh, under COLUMNS.
        self._times = Thinned(COLUMNS)
        self._timeline, self._answers = Timeline(), Answers()
        # What became of frames: of the link that is in use, and of those before.
        self._channel: Channel | None = None
        self._fates = Counter[str]()
        # Changes by the user and by warp "auto": settings as [before, after] by name, with the time
        # of the last picture before; notices over pictures; losses of the display, and how long.
        self._changes: list[dict[str, Any]] = []
        self._change_count, self._notices, self._lost = 0, Counter[str](), list[dict[str, Any]]()
        self._lost_at: float | None = None
        # Refreshes: passed without a new picture, after the first one; before the first frame
        # arrived; while the display was not visible; whose passes and drawing together took longer
        # than a refresh, out of `timed`.
        self._counts = dict.fromkeys(("missed", "waiting", "unseen", "over", "timed"), 0)
        # Missed ones since the last picture, and the most in a row.
        self._stale = self._longest_stale = 0
        # None until the display is open, as are the attributes that `begin` adds.
        self._host: Host | None = None
        # What chose warps last, and how many of its switches are logged.
        self._auto: AdaptiveCompensator | None = None
        self._auto_changes = 0
        # The last picture, the instant of the first, and when the last refresh submitted one; None
        # after one without a picture.
        self._last: Refresh | None = None
        self._first_ns = 0
        self._submitted_ns: int | None = None
        # The entry still to be logged: its times are known at the next refresh.
        self._pending: tuple[Row, Refresh, float | None] | None = None
        self._summary: dict[str, Any] = {}
        self._written = False
        self._finishing, self._finished = threading.Lock(), False

    def begin(self, display: Display, host: Host) -> None:
        self.options = options = attrs.evolve(self.options, latency_ms=host.options.latency_ms)
        run = host.run
        headset = display.headset.name if display.headset is not None else display.about.get("headset") or display.name
        named = options.record or options.trace
        own = display.about.get("trace") if run.source.kind.has_head else ""
        trace, axes = Path(named).stem if named else own or display.name, display.about.get("trace_axes", "")
        passes = (options.warp, AUTO if options.warp == AUTO else options.fill, run.plans[0].lens.name)
        self._host, self._values = host, host.values()
        # The keys of summary.json that are settled.
        self._facts = summary_of(run, passes, trace, headset, display.rate_hz, axes)
        self._of_display = {"source": display.name, "about": dict(display.about)}
        self._scene_notes = (*run.source.notes, *run.source.scene.notes)
        self._holes = HoleCounter(display.gpu)
        self.status.budget_ms = 1e3 / display.rate_hz
        if self._out is not None:
            self._rows.add(",".join(FRAME_COLUMNS) + "\n")

    def _event(self) -> dict[str, Any]:
        """Return when something happened: at the last picture, since the first."""
        last_s = (self._last.shown_ns - self._first_ns) * 1e-9 if self._last is not None else 0.0
        return {"time_s": last_s, "frame": self.count - 1}

    def changed(self, host: Host) -> None:
        if self._host is not None:
            before, self._values = self._values, host.values()
            self._changed(before, self._values, "manual")

    def _changed(self, before: Mapping[str, object], after: Mapping[str, object], reason: str) -> None:
        what = {name: [before.get(name), value] for name, value in after.items() if before.get(name) != value}
        self._change_count += bool(what)
        if what and len(self._changes) < MOST_EVENTS:
            self._changes.append({**self._event(), "what": what, "reason": reason})

    def acted(self, event: InputEvent) -> None:
        self._answers.add(event)

    def on_display_lost(self, why: str) -> None:
        self._lost_at, self._submitted_ns = time.monotonic(), None
        if len(self._lost) < MOST_EVENTS:
            self._lost.append({**self._event(), "why": why, "away_s": None})

    def came_back(self) -> None:
        if self._lost_at is not None and self._lost:
            self._lost[-1]["away_s"] = time.monotonic() - self._lost_at
        self._lost_at = None

    def add(self, tick: Tick, refresh: Refresh | None, submitted_ns: int, notice: str) -> None:
        """Log a submitted refresh."""
        if self._finished or self._host is None:  # the watchdog has closed the log, and the hung call has returned
            return
        counts, status = self._counts, self.status
        self._settle(refresh)
        if self.count:
            counts["missed"] += tick.missed
            self._stale += tick.missed
            self._longest_stale = max(self._longest_stale, self._stale)
        status.missed, status.notice = counts["missed"], notice
        if notice and (notice in self._notices or len(self._notices) < _MOST_NOTICES):
            self._notices[notice] += 1
        before_ns, self._submitted_ns = self._submitted_ns, None if refresh is None else submitted_ns
        if refresh is None:
            counts["waiting" if tick.render else "unseen"] += 1
            return
        self._stale = 0
        if not self.count:
            self._first_ns = refresh.shown_ns
        self._answers.see(refresh.shown_ns, refresh.frame.shows_ns)
        speeds = speeds_between(self._last, refresh)
        row = row_of(self.count, refresh, self._first_ns, speeds, submitted_ns)
        period_ms = None if before_ns is None else (submitted_ns - before_ns) * 1e-6
        recent = (
            (status.age_ms, row["age_ms"]),
            (status.pose_age_ms, row["pose_age_ms"]),
            (status.period_ms, period_ms),
        )
        for plot, value in recent:
            if value is not None:
                plot.append(value)
        self._last, self._pending = refresh, (row, refresh, period_ms)
        run = self._host.run
        if run.channel is not self._channel:
            self._timeline = Timeline()
            if self._channel is not None:
                self._fates.update(self._channel.fates())
            self._channel = run.channel
        if run.auto is not self._auto:  # the pipeline was built anew
            self._auto, self._auto_changes = run.auto, 0
        for change in run.auto.changes[self._auto_changes :] if run.auto is not None else ():
            before, after = ({"warp": passes.warp, "fill": passes.fill} for passes in (change.before, change.after))
            self._changed(before, after, change.reason)
            self._auto_changes += 1
        self.count += 1

    def _settle(self, now: Refresh | None) -> None:
        """Log the previous refresh: its times are known by now, and its holes soon."""
        warped = [eye.warped for eye in now.eyes if eye.warped is not None] if now is not None else []
        if self._pending is not None or warped:
            self._holes.count(warped)
        if self._pending is None:
            return
        (row, refresh, period_ms), self._pending = self._pending, None
        shares: tuple[float | None, ...] = self._holes.shares() or (None,) * len(refresh.eyes)
        eyes = [
            {**stage_columns(stages), "hole_share": share}
            for stages, share in zip(refresh.stage_ms, shares, strict=True)
        ]
        render_ms = sum(ms for _, ms in refresh.frame.drawing.read()) if refresh.frame.drawing is not None else 0.0
        passes_ms = sum(eye["total_ms"] for eye in eyes)
        status, known = self.status, [share for share in shares if share is not None]
        status.stage_ms = {name: sum(eye[column] for eye in eyes) for name, column in _STAGES.items()}
        status.total_ms.append(passes_ms)
        status.holes.append(sum(known) / len(known) if len(known) == len(eyes) else math.nan)
        self._counts["timed"] += 1
        self._counts["over"] += render_ms + passes_ms > status.budget_ms
        of_eyes = {f"{name}/{number}": eye[name] for number, eye in enumerate(eyes) for name in OF_EYE}
        response = {f"response/{name}": part_ms for name, part_ms in refresh.response.parts().items()}
        own = {"period_ms": period_ms, "render_ms": render_ms, "busy_ms": render_ms + passes_ms}
        self._times.add({**row, **own, **of_eyes, **response})
        self._timeline.add(refresh)
        self._log(row, eyes)

    def _log(self, row: Row, eyes: Sequence[Row]) -> None:
        """Write the lines of frames.csv. eyes: what differs between them."""
        if self._out is not None:
            self._rows.add(csv_text([{**row, "eye": number, **eye} for number, eye in enumerate(eyes)]))

    def leave(self) -> None:
        """Read the times of the last refresh, before the GPU goes away. Failures are ignored."""
        if self._host is not None:
            with suppress(Exception):
                self._settle(None)
            with suppress(Exception):
                self._holes.close()

    def finish(self) -> None:
        """Write the results.

        Safe to call twice, and from another thread: it does not touch the GPU. Errors: InputError
        or MachineError for a folder that cannot be written any more; complete files stay there.
        """
        with self._finishing:
            if self._finished:
                return
            self._finished = True
        if self._host is None or not self.count:
            if self._out is not None:
                with suppress(Exception):
                    self._rows.close()
                self._out.discard()
        elif self._out is None:
            self._summary = self._sum_up()
        else:
            try:
                self._write(self._out)
            finally:
                self._out.commit()
                self._written = True

    def _write(self, out: OutputFolder) -> None:
        if self._pending is not None:  # the GPU went away before its times could be read
            row, refresh, _ = self._pending
            self._log(row, [{}] * len(refresh.eyes))
        self._rows.close()
        self._summary = self._sum_up()
        page = render_live_report(self._summary, self._times.column, command=self.options.command)
        out.write_text("report.html", page)
        out.write_json("summary.json", self._summary)

    def _sum_up(self) -> dict[str, Any]:
        """Return the summary. Settings are those at the start; later changes are in `live`."""
        options, times, budget_ms = self.options, self._times, self.status.budget_ms
        of_eyes = {name: times.measured(*(f"{name}/{eye}" for eye in range(_MOST_EYES))) for name in OF_EYE}
        seconds, render = times.column("time_s"), times.column("render_ms")
        # All eyes together: drawing, each stage, and the sum.
        refresh = {"render": render}
        for name, column in (*_STAGES.items(), ("total", "total_ms")):
            refresh[name] = np.nansum([times.column(f"{column}/{eye}") for eye in range(_MOST_EYES)], axis=0)
        refresh["total"] = render + refresh["total"]
        live: dict[str, Any] = {
            **self._of_display,
            "record": str(options.record) if options.record is not None else None,
            "seconds": float(seconds[-1]) if len(seconds) else 0.0,
            "refreshes": self.count,
            **self._counts,
            **{name: middle_and_tail(times.measured(name)) for name in ("age_ms", "pose_age_ms", "period_ms")},
            "budget_ms": budget_ms,
            "refresh_ms": {name: middle_and_tail(values) for name, values in refresh.items()},
            "changes": self._changes,
            "change_count": self._change_count,
            "notices": dict(self._notices.most_common()),
            "lost": self._lost,
            "sampled_every": times.every,
        }
        rate_hz = (self.count - 1) / live["seconds"] if live["seconds"] else self._facts["rate_hz"]
        assert self._channel is not None
        link = self._channel.summary(rate_hz)
        link["frames"] = {name: count + self._fates[name] for name, count in link["frames"].items()}
        link["response_ms"] = figures_of_parts(
            np.column_stack([times.column(f"response/{part}") for part in _RESPONSE])
        )
        link["timeline"] = self._timeline.as_list()
        missed, longest = self._counts["missed"], self._longest_stale
        more = {
            **aggregate_columns(of_eyes),
            "link": link,
            "miss": {"budget_ms": budget_ms, "stale_share": missed / (self.count + missed), "longest_stale": longest},
            "notes": [*self._scene_notes, *options.notes, *self._notes()],
            "live": live,
        }
        if (acted := self._answers.entry())["count"]:
            more |= {"input": acted, "notes": [*more["notes"], self._answers.note()]}
        return {**self._facts, "frames": self.count, **more}

    def _notes(self) -> list[str]:
        notes = []
        if self._change_count:
            times = "once" if self._change_count == 1 else f"{self._change_count} times"
            notes.append(
                f"Settings were changed {times} while it ran. Figures are over all of it; frames.csv has each one's "
                "warp and fill."
            )
        for lost in self._lost[:5]:
            away = "and did not come back" if lost["away_s"] is None else f"for {lost['away_s']:.1f} s"
            notes.append(f"The display went away at {lost['time_s']:.2f} s {away}: {lost['why']}")
        if self._times.every > 1:
            notes.append(
                f"Medians, percentiles and curves are of every {self._times.every}th refresh; frames.csv has all of "
                "them."
            )
        if not self._counts["timed"]:
            notes.append("The times of the passes are unknown: the run ended before they could be read.")
        return notes

    def column(self, name: str) -> Array:
        """Return one of COLUMNS for each refresh, NaN where it was not measured."""
        return self._times.column(name)

    def result(self) -> LiveResult:
        return LiveResult(self.options.out if self._written else None, self._summary)

    def __enter__(self) -> LiveLog:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        if kind is None:
            self.finish()
            return
        with suppress(Exception):  # the exception that ended the run matters more
            self.finish()
