"""Figures of a live run of any length in bounded memory, and its summary."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import TYPE_CHECKING, Any

import attrs
import moderngl
import numpy as np
from numpy.typing import NDArray

from ..colour import picture_from_linear
from ..display import Display
from ..errors import counted
from ..gpu.context import Gpu
from ..gpu.textures import Canvas, download
from ..link import ResponseTime, figures_of_parts
from ..metrics import aggregate_columns, middle_and_tail
from ..options import AUTO
from ..pipeline.channel import Channel
from ..pipeline.loop import Refresh
from ..report import OutputFolder
from .ending import Pauses
from .frame_rows import STAGE_COLUMNS, Answers, Timeline
from .host import PipelineHost
from .misses import MEASURED, STANDS, TURNED, MissTally
from .options import OPENXR, LiveOptions
from .run_summary import EYES, Facts

if TYPE_CHECKING:
    from numpy.typing import NDArray


MOST_EYES = 2
_BYTES = 4 * MOST_EYES


class HoleCounter:
    """Count holes on the GPU: count() starts, shares() returns those of the refresh before.

    Those are finished long ago, so nothing stalls.
    """

    def __init__(self, gpu: Gpu) -> None:
        gl = self._gl = gpu.gl
        self._program = gpu.shaders.compute("live/holes.comp")
        # Cleared by a copy on the GPU: a write from the CPU could wait for a pending read.
        self._empty = gl.buffer(bytes(_BYTES))
        self._now, self._before = (gl.buffer(reserve=_BYTES) for _ in range(2))
        self._pixels: tuple[int, ...] | None = None
        self._pixels_before: tuple[int, ...] | None = None

    def count(self, canvases: Sequence[Canvas]) -> None:
        """Count the pixels with alpha 0 of each eye's picture, which earlier passes have finished.

        Call once a refresh.
        """
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
        """Return the share of holes in each eye's pixels, 0..1, at the count before the last one.

        None before the second count.
        """
        if self._pixels_before is None:
            return None
        counts = np.frombuffer(self._before.read(), np.uint32)
        return tuple(int(count) / pixels for count, pixels in zip(counts, self._pixels_before, strict=False))

    def close(self) -> None:
        """Free the buffers."""
        for buffer in (self._empty, self._now, self._before):
            buffer.release()


MOST_ROWS = 1 << 15  # six minutes at 90 Hz are kept whole
MOST_EVENTS = 1000  # switches, losses; a held key makes thirty a second
_MOST_NOTICES = 50  # different ones
_MORE = "others"
OF_EYE = (*STAGE_COLUMNS, "hole_share")
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
    stay evenly spaced over the whole run, at least `most` / 2 of them.
    """

    def __init__(self, columns: Sequence[str], most: int = MOST_ROWS) -> None:
        """Make an empty table. most: an even number."""
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

    def column(self, name: str) -> NDArray[np.float64]:
        """Return all rows of one column, NaN included."""
        return self._table[: self._kept, self._at[name]].copy()

    def measured(self, *names: str) -> NDArray[np.float64]:
        """Return the measured values of these columns, concatenated."""
        values = np.concatenate([self.column(name) for name in names])
        kept: NDArray[np.float64] = values[~np.isnan(values)]
        return kept


class Events:
    """Events of a run: changes by the user and by warp "auto", notices, losses of the display."""

    def __init__(self) -> None:
        # Settings as [before, after] by name, with the time of the last picture before the change.
        self.changes: list[dict[str, Any]] = []
        self.notices: Counter[str] = Counter()
        # Reason and duration.
        self.lost: list[dict[str, Any]] = []
        self.change_count = 0
        self._lost_at: float | None = None

    def changed(
        self, frame: int, time_s: float, before: Mapping[str, object], after: Mapping[str, object], reason: str
    ) -> None:
        """Add a change of settings, as [before, after] by name.

        frame, time_s: of the last picture. reason: "" for a manual change.
        """
        what = {name: [before.get(name), value] for name, value in after.items() if before.get(name) != value}
        if what:
            self.change_count += 1
            if len(self.changes) < MOST_EVENTS:
                self.changes.append({"time_s": time_s, "frame": frame, "what": what, "reason": reason or "manual"})

    def noticed(self, notice: str) -> None:
        """Count a notice shown over a picture."""
        self.notices[notice if notice in self.notices or len(self.notices) < _MOST_NOTICES else _MORE] += 1

    def on_display_lost(self, frame: int, time_s: float, why: str) -> None:
        """Add a loss of the display."""
        self._lost_at = time.monotonic()
        if len(self.lost) < MOST_EVENTS:
            self.lost.append({"time_s": time_s, "frame": frame, "why": why, "away_s": None})

    def came_back(self) -> None:
        """Record how long the display was away."""
        if self._lost_at is not None and self.lost:
            self.lost[-1]["away_s"] = time.monotonic() - self._lost_at
        self._lost_at = None

    def as_dict(self) -> dict[str, Any]:
        """Return its part of summary.json."""
        return {
            "changes": self.changes,
            "change_count": self.change_count,
            "notices": dict(self.notices.most_common()),
            "lost": self.lost,
        }


@attrs.define(eq=False)
class Counts:
    """How many refreshes there were of each kind."""

    # Passed without a new picture, after the first one.
    missed: int = 0
    # Before the first frame arrived.
    waiting: int = 0
    # While the display was not visible.
    unseen: int = 0
    # Passes and drawing together took longer than a refresh, out of `timed`.
    over: int = 0
    timed: int = 0


class FrameFates:
    """Fates of the frames, over all links of a run in succession."""

    def __init__(self) -> None:
        self._past: Counter[str] = Counter()
        self._channel: Channel | None = None
        self._responses = Thinned(_RESPONSE)
        self._timeline = Timeline()
        self._seen = 0

    def follow(self, channel: Channel) -> None:
        """Count on this channel from now on; the previous one is closed."""
        if channel is self._channel:
            return
        self._timeline = Timeline()
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
        """Return the `link` of summary.json; size and codec are those of the last link.

        rate_hz: measured rate of the pictures.
        """
        if self._channel is None:
            return {}
        last = self._channel.summary(rate_hz)
        frames = dict(Counter(last["frames"]) + self._past) if self._past else last["frames"]
        response = figures_of_parts(np.column_stack([self._responses.column(name) for name in _RESPONSE]))
        frames = {name: frames.get(name, 0) for name in last["frames"]}
        return {**last, "frames": frames, "response_ms": response, "timeline": self._timeline.as_list()}


@attrs.define(eq=False)
class LiveFigures:
    """All figures of a live run."""

    # One row for each refresh, under COLUMNS.
    times: Thinned = attrs.field(factory=lambda: Thinned(COLUMNS))
    events: Events = attrs.field(factory=Events)
    pauses: Pauses = attrs.field(factory=Pauses)
    counts: Counts = attrs.field(factory=Counts)
    misses: MissTally = attrs.field(factory=MissTally)
    fates: FrameFates = attrs.field(factory=FrameFates)
    answers: Answers = attrs.field(factory=Answers)


MOST = 1000
_WAITING = 8  # full pictures in memory at a time; beyond that the loop waits for the disk


class Pictures:
    """Keep every n-th refresh as images/frame-NNNNNN-{left,right}.png, at most `MOST` of them.

    Reading a picture back waits for the GPU: such a refresh is late, and its time shows it. A
    thread encodes and writes the PNGs. every: 0 for none.
    """

    def __init__(self, out: OutputFolder, every: int, most: int = MOST) -> None:
        self._out, self._every, self._most = out, every, most
        self._writer = ThreadPoolExecutor(1, "pictures") if every else None
        self._under_way: deque[Future[None]] = deque()
        self.count = 0

    def wants(self, number: int) -> bool:
        """Return whether the refresh of that number is to be kept."""
        return self._writer is not None and number % self._every == 0 and self.count < self._most

    @property
    def is_full(self) -> bool:
        """Whether the limit was reached."""
        return self.count >= self._most

    def keep(self, number: int, refresh: Refresh) -> None:
        """Read a picture back. Errors: as OutputFolder.write_png, for an earlier picture."""
        if self._writer is None:
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
        """Wait until all pictures are written. Errors: as keep; safe to call twice."""
        if self._writer is None:
            return
        self._writer.shutdown()
        while self._under_way:
            self._under_way.popleft().result()


@attrs.frozen(eq=False)
class LiveFacts:
    """Facts about a live run that are settled when it begins."""

    shared: Facts
    options: LiveOptions
    # Name of the display, and its own description.
    source: str
    about: dict[str, str]
    # Of the first plan.
    lens: str
    scene_notes: tuple[str, ...]

    @property
    def budget_ms(self) -> float:
        """The period of the display."""
        return 1e3 / self.shared.rate_hz

    @property
    def turns(self) -> bool:
        """Whether the display turns a picture that it shows again to the newest head."""
        return self.source == OPENXR


def live_facts_of(options: LiveOptions, display: Display, host: PipelineHost) -> LiveFacts:
    """Return the facts of a run on this display."""
    headset = display.headset.name if display.headset is not None else display.about.get("headset") or display.name
    named = options.record or options.trace
    own = display.about.get("trace") if host.run.source.kind.has_head else ""
    trace, axes = Path(named).stem if named else own or display.name, display.about.get("trace_axes", "")
    shared = Facts.of(host.run, trace, headset, display.rate_hz, axes)
    notes = (*host.run.source.notes, *host.run.source.scene.notes)
    return LiveFacts(shared, options, display.name, dict(display.about), host.run.plans[0].lens.name, notes)


def live_summary_of(facts: LiveFacts, frames: int, figures: LiveFigures, pictures: Pictures | None) -> dict[str, Any]:
    """Return the summary. Settings are those at the start; later changes are in `live`."""
    options, times = facts.options, figures.times
    of_eyes = {name: times.measured(*(f"{name}/{eye}" for eye in (0, 1))) for name in OF_EYE}
    live = _live(facts, frames, figures)
    more = {
        **aggregate_columns(of_eyes),
        "link": figures.fates.as_dict((frames - 1) / live["seconds"] if live["seconds"] else facts.shared.rate_hz),
        "miss": {
            "budget_ms": facts.budget_ms,
            "times": MEASURED,
            "show": TURNED if facts.turns else STANDS,
            **figures.misses.as_dict(),
        },
        "notes": [*facts.scene_notes, *options.notes, *_notes(figures.events, live, pictures)],
        "live": live,
    }
    if (acted := figures.answers.entry())["count"]:
        more |= {"input": acted, "notes": [*more["notes"], figures.answers.note()]}
    fill = AUTO if options.warp == AUTO else options.fill
    return facts.shared.summary((options.warp, fill, facts.lens), frames, more)


def _live(facts: LiveFacts, frames: int, figures: LiveFigures) -> dict[str, Any]:
    """Return the keys that only a live run has."""
    times, options = figures.times, facts.options
    seconds, render = times.column("time_s"), times.column("render_ms")
    # All eyes together: drawing, each stage, and the sum.
    both = {name: np.nansum([times.column(f"{name}/{eye}") for eye in (0, 1)], axis=0) for name in STAGE_COLUMNS}
    refresh = {"render": render, **{name.removesuffix("_ms"): values for name, values in both.items()}}
    refresh["total"] = render + refresh["total"]
    return {
        "source": facts.source,
        "about": facts.about,
        "record": str(options.record) if options.record is not None else None,
        "seconds": float(seconds[-1]) if len(seconds) else 0.0,
        "refreshes": frames,
        **attrs.asdict(figures.counts),
        **{name: middle_and_tail(times.measured(name)) for name in ("age_ms", "pose_age_ms", "period_ms")},
        "budget_ms": facts.budget_ms,
        "refresh_ms": {name: middle_and_tail(values) for name, values in refresh.items()},
        **figures.events.as_dict(),
        "garbage_collector": {"between": options.collect, **figures.pauses.as_dict()},
        "sampled_every": times.every,
    }


def _notes(events: Events, live: dict[str, Any], pictures: Pictures | None) -> list[str]:
    notes = []
    if events.change_count:
        times = "once" if events.change_count == 1 else f"{events.change_count} times"
        notes.append(
            f"Settings were changed {times} while it ran. Figures are over all of it; frames.csv has each one's warp "
            "and fill."
        )
    for lost in events.lost[:5]:
        away = "and did not come back" if lost["away_s"] is None else f"for {lost['away_s']:.1f} s"
        notes.append(f"The display went away at {lost['time_s']:.2f} s {away}: {lost['why']}")
    if pictures is not None and pictures.count:
        notes.append("Kept pictures were read back from the GPU, which makes their refreshes late.")
    if pictures is not None and pictures.is_full:
        notes.append(f"Only the first {counted(pictures.count, 'picture')} were kept: the limit.")
    if live["sampled_every"] > 1:
        notes.append(
            f"Medians, percentiles and curves are of every {live['sampled_every']}th refresh; frames.csv has all of "
            "them."
        )
    if not live["timed"]:
        notes.append("The times of the passes are unknown: the run ended before they could be read.")
    return notes
