"""Log of a live run of any length, in bounded memory: frames.csv, summary.json, and the panel."""

from __future__ import annotations

import gc
import math
import threading
import time
from collections import Counter, deque
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..client.inputs import PassInputs
from ..colour import picture_from_linear
from ..display import Display, Status, Tick
from ..errors import counted
from ..geometry import Pose
from ..gpu.context import Gpu
from ..gpu.textures import Canvas, download, flip_rows
from ..link import ResponseTime, figures_of_parts
from ..metrics import aggregate_columns, middle_and_tail
from ..options import AUTO
from ..pipeline.channel import Channel
from ..pipeline.governor import AdaptiveCompensator
from ..pipeline.loop import Refresh
from ..poses import quaternions
from ..report import OutputFolder, live_lines, render_live_report
from ..scenes import InputEvent
from . import frame_rows
from .options import OPENXR, LiveOptions
from .recorder import Lines
from .run import Run
from .run_summary import EYES, OWNED, summary_of

Array = NDArray[np.float64]
_MOST_EYES = 2
_POINTS = 17  # a row and a column of the late frame
_MOST_LOOKED_AT = 16  # of the refreshes in a row that show one picture; between them it is interpolated


class MissTally:
    """What the misses of a run cost: pictures that are seen again, and away from their place."""

    def __init__(self) -> None:
        self._refreshes = self._stale = self._longest = self._run = 0
        self._last_deg, self._squares = 0.0, 0.0

    def add(self, stale: bool, off_deg: float) -> None:
        """Add a refresh: whether it is a picture again, how far things are off their place."""
        if self._refreshes:
            self._squares += (off_deg - self._last_deg) ** 2
        self._last_deg = off_deg
        self._refreshes += 1
        self._stale += stale
        self._run = self._run + 1 if stale else 0
        self._longest = max(self._longest, self._run)

    def as_dict(self) -> dict[str, Any]:
        """Return its part of summary.json; judder_deg: RMS of the change of that angle."""
        judder = math.sqrt(self._squares / max(1, self._refreshes - 1))
        return {"stale_share": self._stale / self._refreshes, "longest_stale": self._longest, "judder_deg": judder}


def seen_off_deg(
    made: Refresh, depths: Iterable[Array], then: Refresh, missed: int, periods: int, *, turned: bool
) -> list[float]:
    """Return the angle between where things are seen and where they are, for each missed refresh.

    Over points of the late frame, as far away as its depth says, or infinitely far without any.
    depths: of the frame of `made`, which is shown again. then: the next picture, so many periods
    later; the head keeps its speed in between. turned: to the newest head, else it stands.
    """
    every = []
    for inputs, depth in zip(made.inputs, depths, strict=True):
        view, found = inputs.rendered.view, depth.reshape(-1, 1)
        inverse = np.where((found >= 0).any(), found, 0.0)
        ways = view.rays((_POINTS, _POINTS)).reshape(-1, 3) @ view.pose.rotation_matrix.T
        drawn = inverse[:, 0] >= 0
        every.append(((ways + view.pose.position_m * inverse)[drawn], inverse[drawn]))
    pairs = [(a.shown, b.shown) for a, b in zip(made.inputs, then.inputs, strict=False)]
    shares = np.arange(1, missed + 1) / periods
    looked_at = np.linspace(shares[0], shares[-1], min(missed, _MOST_LOOKED_AT))

    def off_deg(share: float) -> float:
        angles = []
        for points, (a, b) in zip(every, pairs, strict=False):
            turn = quaternions.slerp(a.pose.orientation_xyzw.tolist(), b.pose.orientation_xyzw.tolist(), share)
            now = Pose(a.pose.position_m + share * (b.pose.position_m - a.pose.position_m), turn)
            seen, right = (_ways(points, pose) for pose in (a.pose, now))
            if not turned:
                seen = seen @ a.pose.rotation_matrix @ now.rotation_matrix.T
            apart, together = (np.linalg.norm(ways, axis=1) for ways in (seen - right, seen + right))
            angles.append(2 * np.arctan2(apart, together))
        return float(np.degrees(np.sqrt(np.mean(np.concatenate(angles) ** 2))))

    angles = [off_deg(float(share)) for share in looked_at]
    return [float(off) for off in np.interp(shares, looked_at, angles)]


def _ways(points: tuple[Array, Array], eye: Pose) -> Array:
    """Return the unit vectors, (n, 3), from an eye to points: (n, 3) times inverse depth (n, 1)."""
    ways = points[0] - eye.position_m * points[1]
    return np.asarray(ways / np.linalg.norm(ways, axis=1, keepdims=True))


class _ReadLater:
    """Two buffers that a shader fills by turns: the one before is finished, so nothing stalls."""

    shader: str
    size: int

    def __init__(self, gpu: Gpu) -> None:
        self._gl = gpu.gl
        self._program = gpu.shaders.compute(self.shader)
        self._now, self._before = (gpu.gl.buffer(reserve=self.size) for _ in range(2))

    def _swap(self) -> None:
        self._now, self._before = self._before, self._now
        self._now.bind_to_storage_buffer(0)

    def close(self) -> None:
        for buffer in (self._now, self._before):
            buffer.release()


class DepthSamples(_ReadLater):
    """Inverse depth of late frames on a grid; take() starts, before() is of the take before."""

    shader = "live/depths.comp"
    size = 4 * _MOST_EYES * _POINTS**2

    def take(self, inputs: Sequence[PassInputs]) -> None:
        self._swap()
        for slot, eye in enumerate(inputs):
            depth = eye.rendered.inverse_depth
            depth.bind_to_image(0, read=True, write=False)
            self._program.uniforms.set(inverse_depth=0, size=depth.size, points=_POINTS, slot=slot)
            self._program.run(_POINTS, _POINTS)
        self._gl.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)

    def before(self, eyes: int) -> list[Array]:
        """Return (17, 17) for each eye, the top row first."""
        every = np.frombuffer(self._before.read(), np.float32).reshape(_MOST_EYES, _POINTS, _POINTS)
        return [flip_rows(one.astype(np.float64)) for one in every[:eyes]]


class HoleCounter(_ReadLater):
    """Count holes on the GPU: count() starts, shares() returns those of the count before."""

    shader = "live/holes.comp"
    size = 4 * _MOST_EYES

    def __init__(self, gpu: Gpu) -> None:
        super().__init__(gpu)
        # Cleared by a copy on the GPU: a write from the CPU could wait for a pending read.
        self._empty = gpu.gl.buffer(bytes(self.size))
        self._pixels: tuple[int, ...] | None = None
        self._pixels_before: tuple[int, ...] | None = None

    def count(self, canvases: Sequence[Canvas]) -> None:
        """Count the pixels with alpha 0 of each eye's picture; call once a refresh."""
        self._swap()
        self._pixels_before, self._pixels = self._pixels, tuple(canvas.size[0] * canvas.size[1] for canvas in canvases)
        self._gl.copy_buffer(self._now, self._empty)
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
        super().close()
        self._empty.release()


class Pauses:
    """Number and time of garbage collections between `start` and `stop`, by generation."""

    def __init__(self) -> None:
        self._runs, self._total_ns, self._longest_ns = [0, 0, 0], 0, 0
        self._began_ns: int | None = None

    def start(self) -> None:
        gc.callbacks.append(self._notice)

    def stop(self) -> None:
        """Stop counting; safe to call twice, or without start."""
        if self._notice in gc.callbacks:
            gc.callbacks.remove(self._notice)

    def _notice(self, phase: str, about: dict[str, int]) -> None:
        if phase == "start":
            self._began_ns = time.perf_counter_ns()
        elif self._began_ns is not None:
            took_ns, self._began_ns = time.perf_counter_ns() - self._began_ns, None
            self._runs[about["generation"]] += 1
            self._total_ns += took_ns
            self._longest_ns = max(self._longest_ns, took_ns)

    def as_dict(self) -> dict[str, Any]:
        """Return its part of summary.json, from the youngest generation to the oldest."""
        return {"collections": self._runs, "total_ms": self._total_ns * 1e-6, "longest_ms": self._longest_ns * 1e-6}


MOST_ROWS = 1 << 15  # six minutes at 90 Hz are kept whole
MOST_EVENTS = 1000  # switches, losses; a held key makes thirty a second
_MOST_NOTICES = 50  # different ones
_MORE = "others"
OF_EYE = (*frame_rows.STAGE_COLUMNS, "hole_share")
_NO_EYE = (math.nan,) * len(OF_EYE)  # columns of an absent eye
_STAGES = tuple(name.removesuffix("_ms") for name in frame_rows.STAGE_COLUMNS[:-1])
SHARED = (
    *("time_s", "age_ms", "pose_age_ms", "period_ms", "angular_speed_deg_s", "linear_speed_m_s"),
    *("render_ms", "busy_ms"),
)
COLUMNS = (*SHARED, *(f"{name}/{eye}" for eye in (0, 1) for name in OF_EYE))
_RESPONSE = tuple(ResponseTime().parts())
_RESPONSE_EVERY = 8  # adding up its parts takes 10 us


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

    def add(self, row: Sequence[float]) -> None:
        """Add the next row, in the order of the columns; NaN for values that were not measured."""
        if self._seen % self.every == 0:
            if self._kept == len(self._table):
                self._kept //= 2
                self._table[: self._kept] = self._table[::2].copy()
                self.every *= 2
            self._table[self._kept] = row
            self._kept += 1
        self._seen += 1

    def column(self, name: str) -> Array:
        """Return all rows of one column, NaN included."""
        return self._table[: self._kept, self._at[name]].copy()

    def measured(self, *names: str) -> Array:
        """Return the measured values of these columns, concatenated."""
        values = np.concatenate([self.column(name) for name in names])
        kept: Array = values[~np.isnan(values)]
        return kept


class FrameFates:
    """Fates of the frames, over all links of a run in succession."""

    def __init__(self) -> None:
        self._past: Counter[str] = Counter()
        self._channel: Channel | None = None
        self._responses = Thinned(_RESPONSE)
        self._timeline = frame_rows.Timeline()
        self._seen = 0

    def follow(self, channel: Channel) -> None:
        """Count on this channel from now on; the previous one is closed."""
        if channel is self._channel:
            return
        self._timeline = frame_rows.Timeline()
        if self._channel is not None:
            self._past.update(self._channel.fates())
        self._channel = channel

    def add(self, refresh: Refresh) -> None:
        """Add the response time of a refresh whose times are known."""
        self._timeline.add(refresh)
        if self._seen % _RESPONSE_EVERY == 0:
            self._responses.add(tuple(refresh.response.parts().values()))
        self._seen += 1

    def as_dict(self, rate_hz: float) -> dict[str, Any]:
        """Return the `link` of summary.json; rate_hz: measured rate of the pictures."""
        if self._channel is None:
            return {}
        last = self._channel.summary(rate_hz)
        frames = {name: count + self._past.get(name, 0) for name, count in last["frames"].items()}
        response = figures_of_parts(np.column_stack([self._responses.column(name) for name in _RESPONSE]))
        return {**last, "frames": frames, "response_ms": response, "timeline": self._timeline.as_list()}


MOST = 1000
_WAITING = 8  # full pictures in memory at a time; beyond that the loop waits for the disk


class Pictures:
    """Keep every n-th refresh as images/frame-NNNNNN-{left,right}.png, at most `MOST` of them.

    Reading a picture back waits for the GPU: such a refresh is late. every: 0 for none.
    """

    def __init__(self, out: OutputFolder, every: int, most: int = MOST) -> None:
        self._out, self._every, self._most = out, every, most
        self._writer = ThreadPoolExecutor(1, "pictures") if every else None
        self._under_way: deque[Future[None]] = deque()
        self.count = 0

    @property
    def is_full(self) -> bool:
        return self.count >= self._most

    def keep(self, number: int, refresh: Refresh) -> None:
        """Read a picture back if it is to be kept. Errors: as write_png, for an earlier picture."""
        if self._writer is None or number % self._every or self.is_full:
            return
        for eye, result in enumerate(refresh.eyes):
            while len(self._under_way) >= _WAITING:
                self._under_way.popleft().result()
            name = f"images/frame-{number:06d}-{EYES[eye]}.png"
            self._under_way.append(self._writer.submit(self._write, name, download(result.panel.texture)))
        self.count += 1

    def _write(self, name: str, linear: NDArray[np.floating]) -> None:
        self._out.write_png(name, picture_from_linear(linear))

    def close(self) -> None:
        if self._writer is not None:
            self._writer.shutdown()
        while self._under_way:
            self._under_way.popleft().result()


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


@attrs.define(eq=False)
class _Running:
    """The part of a log that exists once the display is open."""

    # The keys of summary.json that are settled.
    facts: dict[str, Any]
    host: Host
    # Name of the display, and its own description.
    source: str
    about: dict[str, str]
    scene_notes: tuple[str, ...]
    # The current value of each control.
    values: dict[str, object]
    holes: HoleCounter
    # Where things are seen in a picture that is shown again.
    depths: DepthSamples
    # What chose warps last, and how many of its switches are logged.
    auto: AdaptiveCompensator | None = None
    auto_changes: int = 0

    @property
    def turns(self) -> bool:
        """Whether the display turns a picture that it shows again to the newest head."""
        return self.source == OPENXR


class LiveLog:
    """Log of a live run. Use as a context manager: it writes the results on exit.

    The times of a refresh are read at the next one, so nothing here waits for the GPU. A refresh
    costs some 50 us, half of that only with an output folder. Memory is bounded.
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
            self._pictures = Pictures(self._out, options.images_every)
        # One row for each refresh, under COLUMNS.
        self._times = Thinned(COLUMNS)
        self._pauses, self._fates = Pauses(), FrameFates()
        # Changes by the user and by warp "auto": settings as [before, after] by name, with the time
        # of the last picture before; notices over pictures; losses of the display, and how long.
        self._changes: list[dict[str, Any]] = []
        self._change_count, self._notices, self._lost = 0, Counter[str](), list[dict[str, Any]]()
        self._lost_at: float | None = None
        self._misses, self._answers = MissTally(), frame_rows.Answers()
        # Refreshes: passed without a new picture, after the first one; before the first frame
        # arrived; while the display was not visible; whose passes and drawing together took longer
        # than a refresh, out of `timed`.
        self._counts = dict.fromkeys(("missed", "waiting", "unseen", "over", "timed"), 0)
        self._running: _Running | None = None
        # The last picture, the instant of the first, and when the last refresh submitted one; None
        # after one without a picture.
        self._last: Refresh | None = None
        self._first_ns = 0
        self._submitted_ns: int | None = None
        # The entry still to be logged: its times are known at the next refresh.
        self._pending: tuple[frame_rows.Moment, Refresh, float] | None = None
        self._summary: dict[str, Any] = {}
        self._written = False
        self._finishing, self._finished = threading.Lock(), False

    def begin(self, display: Display, host: Host) -> None:
        options, run = attrs.evolve(self.options, latency_ms=host.options.latency_ms), host.run
        self.options = options
        headset = display.headset.name if display.headset is not None else display.about.get("headset") or display.name
        named = options.record or options.trace
        own = display.about.get("trace") if run.source.kind.has_head else ""
        trace, axes = Path(named).stem if named else own or display.name, display.about.get("trace_axes", "")
        passes = (options.warp, AUTO if options.warp == AUTO else options.fill, run.plans[0].lens.name)
        self._running = _Running(
            summary_of(run, passes, trace, headset, display.rate_hz, axes),
            host,
            display.name,
            dict(display.about),
            (*run.source.notes, *run.source.scene.notes),
            host.values(),
            HoleCounter(display.gpu),
            DepthSamples(display.gpu),
        )
        self.status.budget_ms = 1e3 / display.rate_hz
        if self._out is not None:
            self._rows.add(frame_rows.HEADER)

    @property
    def _last_s(self) -> float:
        """Time of the last picture since the first."""
        return (self._last.shown_ns - self._first_ns) * 1e-9 if self._last is not None else 0.0

    def changed(self, host: Host) -> None:
        if self._running is None:
            return
        before, self._running.values = self._running.values, host.values()
        self._changed(before, self._running.values, "manual")

    def _changed(self, before: Mapping[str, object], after: Mapping[str, object], reason: str) -> None:
        what = {name: [before.get(name), value] for name, value in after.items() if before.get(name) != value}
        self._change_count += bool(what)
        if what and len(self._changes) < MOST_EVENTS:
            about = {"time_s": self._last_s, "frame": self.count - 1}
            self._changes.append({**about, "what": what, "reason": reason})

    def acted(self, event: InputEvent) -> None:
        self._answers.add(event)

    def on_display_lost(self, why: str) -> None:
        self._lost_at, self._submitted_ns = time.monotonic(), None
        if len(self._lost) < MOST_EVENTS:
            self._lost.append({"time_s": self._last_s, "frame": self.count - 1, "why": why, "away_s": None})

    def came_back(self) -> None:
        if self._lost_at is not None and self._lost:
            self._lost[-1]["away_s"] = time.monotonic() - self._lost_at
        self._lost_at = None

    def add(self, tick: Tick, refresh: Refresh | None, submitted_ns: int, notice: str) -> None:
        """Log a submitted refresh."""
        if self._finished or self._running is None:  # the watchdog has closed the log, and the hung call has returned
            return
        counts, running, shown, status = self._counts, self._running, self._last, self.status
        self._settle(refresh)
        if self.count:
            # A runtime turns the last picture to the newest head. In a window it stands; the head
            # is taken to move as fast as from that picture to this one.
            counts["missed"] += tick.missed
            off_deg = [0.0] * tick.missed
            if tick.missed and refresh and shown:
                periods = max(1, round((refresh.shown_ns - shown.shown_ns) * 1e-6 / status.budget_ms))
                depths = running.depths.before(len(shown.inputs))
                off_deg = seen_off_deg(shown, depths, refresh, tick.missed, periods, turned=running.turns)
            for off in off_deg:
                self._misses.add(True, off)
        status.missed, status.notice = counts["missed"], notice
        if notice:
            is_known = notice in self._notices or len(self._notices) < _MOST_NOTICES
            self._notices[notice if is_known else _MORE] += 1
        before_ns, self._submitted_ns = self._submitted_ns, None if refresh is None else submitted_ns
        if refresh is None:
            counts["waiting" if tick.render else "unseen"] += 1
            return
        self._misses.add(False, 0.0)
        if not self.count:
            self._first_ns = refresh.shown_ns
            # Not sooner: GarbageControl starts with a large collection.
            self._pauses.start()
        self._answers.see(refresh.shown_ns, refresh.frame.shows_ns)
        moment = frame_rows.Moment.of(
            self.count, refresh, self._first_ns, frame_rows.speeds_between(shown, refresh), submitted_ns
        )
        period_ms = math.nan if before_ns is None else (submitted_ns - before_ns) * 1e-6
        status.age_ms.append(moment.figures["age_ms"])
        if (pose_age_ms := moment.figures["pose_age_ms"]) is not None:
            status.pose_age_ms.append(pose_age_ms)
        if before_ns is not None:
            status.period_ms.append(period_ms)
        if self._out is not None:
            self._pictures.keep(self.count, refresh)
        self._last, self._pending = refresh, (moment, refresh, period_ms)
        self._fates.follow(running.host.run.channel)
        auto = running.host.run.auto
        if auto is not running.auto:  # the pipeline was built anew
            running.auto, running.auto_changes = auto, 0
        for change in auto.changes[running.auto_changes :] if auto is not None else ():
            before, after = ({"warp": passes.warp, "fill": passes.fill} for passes in (change.before, change.after))
            self._changed(before, after, change.reason)
            running.auto_changes += 1
        self.count += 1

    def _settle(self, now: Refresh | None) -> None:
        """Log the previous refresh: its times are known by now, and its holes soon."""
        if self._running is None:
            return
        warped = [eye.warped for eye in now.eyes if eye.warped is not None] if now is not None else []
        if now is not None:
            self._running.depths.take(now.inputs)
        if self._pending is not None or warped:
            self._running.holes.count(warped)
        if self._pending is None:
            return
        (moment, refresh, period_ms), self._pending = self._pending, None
        stages = [tuple(frame_rows.stage_columns(of_eye).values()) for of_eye in refresh.stage_ms]
        holes = self._running.holes.shares() or (None,) * moment.eyes
        render_ms = sum(ms for _, ms in refresh.frame.drawing.read()) if refresh.frame.drawing is not None else 0.0
        passes_ms = sum(stage[-1] for stage in stages)
        status, known = self.status, [share for share in holes if share is not None]
        status.stage_ms = {name: sum(stage[at] for stage in stages) for at, name in enumerate(_STAGES)}
        status.total_ms.append(passes_ms)
        status.holes.append(sum(known) / len(known) if len(known) == len(holes) else math.nan)
        self._counts["timed"] += 1
        self._counts["over"] += render_ms + passes_ms > status.budget_ms
        own = {"period_ms": period_ms, "render_ms": render_ms, "busy_ms": render_ms + passes_ms}
        columns = {**moment.figures, **own}
        row: list[float | None] = [columns[name] for name in SHARED]
        for stage, share in zip(stages, holes, strict=True):
            row += [*stage, share]
        self._times.add([math.nan if v is None else v for v in (*row, *(_NO_EYE if len(stages) == 1 else ()))])
        self._fates.add(refresh)
        if self._out is not None:
            self._rows.add(frame_rows.rows_text(moment, stages, holes))

    def leave(self) -> None:
        """Read the times of the last refresh, before the GPU goes away. Failures are ignored."""
        self._pauses.stop()
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
        self._pauses.stop()
        if self._running is None or not self.count:
            if self._out is not None:
                with suppress(Exception):
                    self._rows.close()
                self._out.discard()
        elif self._out is None:
            self._summary = self._sum_up(self._running)
        else:
            try:
                self._write(self._out, self._running)
            finally:
                self._out.commit()
                self._written = True

    def _write(self, out: OutputFolder, running: _Running) -> None:
        if self._pending is not None:  # the GPU went away before its times could be read
            moment = self._pending[0]
            self._rows.add(frame_rows.rows_text(moment, [frame_rows.NOT_KNOWN] * moment.eyes, (None,) * moment.eyes))
        try:
            self._rows.close()
        finally:
            self._pictures.close()
        self._summary = self._sum_up(running)
        page = render_live_report(self._summary, self._times.column, command=self.options.command)
        out.write_text("report.html", page)
        out.write_json("summary.json", self._summary)

    def _sum_up(self, running: _Running) -> dict[str, Any]:
        """Return the summary. Settings are those at the start; later changes are in `live`."""
        options, times, budget_ms = self.options, self._times, self.status.budget_ms
        of_eyes = {name: times.measured(*(f"{name}/{eye}" for eye in (0, 1))) for name in OF_EYE}
        seconds, render = times.column("time_s"), times.column("render_ms")
        # All eyes together: drawing, each stage, and the sum.
        both = {
            name: np.nansum([times.column(f"{name}/{eye}") for eye in (0, 1)], axis=0)
            for name in frame_rows.STAGE_COLUMNS
        }
        refresh = {"render": render, **{name.removesuffix("_ms"): values for name, values in both.items()}}
        refresh["total"] = render + refresh["total"]
        live: dict[str, Any] = {
            "source": running.source,
            "about": running.about,
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
            "garbage_collector": {"between": options.collect, **self._pauses.as_dict()},
            "sampled_every": times.every,
        }
        rate_hz = (self.count - 1) / live["seconds"] if live["seconds"] else running.facts["rate_hz"]
        show = "turned" if running.turns else "stands"
        more = {
            **aggregate_columns(of_eyes),
            "link": self._fates.as_dict(rate_hz),
            "miss": {"budget_ms": budget_ms, "times": "measured", "show": show, **self._misses.as_dict()},
            "notes": [*running.scene_notes, *options.notes, *self._notes()],
            "live": live,
        }
        if (acted := self._answers.entry())["count"]:
            more |= {"input": acted, "notes": [*more["notes"], self._answers.note()]}
        return {**running.facts, "frames": self.count, **more}

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
        if self._out is not None and self._pictures.count:
            notes.append("Kept pictures were read back from the GPU, which makes their refreshes late.")
        if self._out is not None and self._pictures.is_full:
            notes.append(f"Only the first {counted(self._pictures.count, 'picture')} were kept: the limit.")
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
