"""The rows of frames.csv, one per eye and refresh; how the last frames came; answers to inputs."""

from __future__ import annotations

import csv
import io
import math
from collections import deque
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import attrs
import numpy as np

from ..link import ResponseTime, TransitStats
from ..metrics import QUALITY
from ..pipeline.loop import Refresh
from ..poses import PoseSample, PoseTrack, quaternions
from ..report import FRAME_COLUMNS, POSE_PARTS
from ..scenes import INPUT_COLUMNS, InputEvent

_HALF_NS = 5_000_000
_APART_NS = 500_000_000  # after a longer break the speed between two pictures is meaningless
Speeds = tuple[float | None, float | None]


def speeds_at(track: PoseTrack, time_ns: int) -> Speeds:
    """Return angular speed in deg/s and linear speed in m/s, by central differences over 10 ms."""
    before, after = track.at(time_ns - _HALF_NS).pose, track.at(time_ns + _HALF_NS).pose
    turned = quaternions.angle_between(before.orientation_xyzw, after.orientation_xyzw)
    seconds = 2 * _HALF_NS * 1e-9
    return float(np.degrees(turned) / seconds), float(np.linalg.norm(after.position_m - before.position_m) / seconds)


def speeds_between(before: Refresh | None, now: Refresh) -> Speeds:
    """Return both speeds between two pictures; None for the first picture and after a break."""
    if before is None or not 0 < now.shown_ns - before.shown_ns <= _APART_NS:
        return None, None
    seconds = (now.shown_ns - before.shown_ns) * 1e-9
    a, b = before.head.pose, now.head.pose
    turned = angle_between(a.orientation_xyzw.tolist(), b.orientation_xyzw.tolist())
    return math.degrees(turned) / seconds, math.dist(a.position_m.tolist(), b.position_m.tolist()) / seconds


def angle_between(a: Sequence[float], b: Sequence[float]) -> float:
    """Return `poses.quaternions.angle_between` of two, in plain floats: 1 us instead of 20."""
    apart, together = math.dist(a, b), math.dist(a, [-value for value in b])
    return 4 * math.atan2(min(apart, together), max(apart, together))


MOST_FRAMES = 12


class Timeline:
    """Keep how the last MOST_FRAMES frames that were shown came there, and when they were seen."""

    def __init__(self) -> None:
        # How each came, and the first and the last instant when it was seen.
        self._kept: deque[tuple[TransitStats, int, int]] = deque(maxlen=MOST_FRAMES)

    def add(self, refresh: Refresh) -> None:
        """Add a refresh; it may show the frame of the one before."""
        first_ns = refresh.shown_ns
        if self._kept and self._kept[-1][0] is refresh.transit:
            _, first_ns, _ = self._kept.pop()
        self._kept.append((refresh.transit, first_ns, refresh.shown_ns))

    def as_list(self) -> list[dict[str, Any]]:
        """Return the `timeline` of summary.json, in ms since the first of its frames was drawn."""
        if not self._kept:
            return []
        start_ns = self._kept[0][0].sent_ns
        return [
            {
                "frame": transit.number,
                "drawn": (transit.sent_ns - start_ns) * 1e-6,
                "parts": {name: part_ns * 1e-6 for name, part_ns in transit.parts_ns().items()},
                "shown": (first_ns - start_ns) * 1e-6,
                "until": (last_ns - start_ns) * 1e-6,
            }
            for transit, first_ns, last_ns in self._kept
        ]


Row = dict[str, Any]
Stages = Iterable[tuple[str, float]]
STAGE_COLUMNS = ("warp_ms", "fill_ms", "effects_ms", "lens_ms", "total_ms")
_NAMES = {prefix: tuple(f"{prefix}_{part}" for part in POSE_PARTS) for prefix in ("shown", "drawn")}


@attrs.frozen(eq=False)
class Moment:
    """One refresh, except for the times of each eye's passes."""

    # The columns that figures and charts use, by name; None: not known, or not defined for the
    # first picture.
    figures: Row
    # See Frame.
    shows_ns: int
    # The head as it was shown, and that which the frame was drawn for.
    shown: PoseSample
    drawn: PoseSample | None
    # How many eyes were shown.
    eyes: int

    @classmethod
    def of(
        cls, number: int, refresh: Refresh, start_ns: int, speeds: Speeds, submitted_ns: int | None = None
    ) -> Moment:
        """Return the moment of a refresh; start_ns: the origin of time."""
        head, frame, plan = refresh.head, refresh.frame, refresh.plan
        figures = {
            "frame": number,
            "time_s": (refresh.shown_ns - start_ns) * 1e-9,
            "shown_ns": refresh.shown_ns,
            "drawn_ns": frame.drawn_ns,
            "age_ms": refresh.age_ns * 1e-6,
            # From reading the head pose to submitting the picture.
            "pose_age_ms": None
            if submitted_ns is None or head.read_ns is None
            else (submitted_ns - head.read_ns) * 1e-6,
            "pose_origin": head.origin.name.lower(),
            "angular_speed_deg_s": speeds[0],
            "linear_speed_m_s": speeds[1],
            "warp": str(plan.choice),
            "fill": plan.fill,
        }
        return cls(figures, frame.shows_ns, head, frame.head, len(refresh.eyes))

    def poses(self) -> Row:
        """Return the columns of both poses, by name."""
        columns: Row = {}
        for which, head in (("shown", self.shown), ("drawn", self.drawn)):
            if head is not None:
                values = (*head.pose.position_m.tolist(), *head.pose.orientation_xyzw.tolist())
                columns |= dict(zip(_NAMES[which], values, strict=True))
        return columns if self.drawn is None else {**columns, "drawn_origin": self.drawn.origin.name.lower()}


def stage_columns(stages: Stages) -> Row:
    """Return times by the columns of frames.csv; 0 for a stage that is not in the plan."""
    columns = dict.fromkeys(STAGE_COLUMNS[:-1], 0.0)
    for name, milliseconds in stages:  # the client's own depth is for the warp, which reads it
        columns["warp_ms" if name == "client_depth" else f"{name}_ms"] += milliseconds
    return {**columns, "total_ms": sum(columns.values())}


def csv_text(rows: Iterable[Row]) -> str:
    """Return lines of frames.csv."""
    text = io.StringIO()
    csv.DictWriter(text, FRAME_COLUMNS, extrasaction="ignore", lineterminator="\n").writerows(rows)
    return text.getvalue()


_NOT_MEASURED = dict.fromkeys(QUALITY)


class ReplayLog:
    """Rows and response times of a replay; poses become columns only when written."""

    def __init__(self, track: PoseTrack) -> None:
        self._track = track
        # Two for each refresh; figures are made from them.
        self.rows: list[Row] = []
        # One for each refresh.
        self.responses: list[ResponseTime] = []
        self.timeline = Timeline()
        # One for each refresh.
        self.moments: list[Moment] = []
        # Of a scene that reacts, once all pictures were shown.
        self.answers: Answers | None = None

    def add(self, refresh: Refresh) -> None:
        speeds = speeds_at(self._track, refresh.shown_ns)
        moment = Moment.of(len(self.moments), refresh, self._track.start_ns, speeds)
        self.moments.append(moment)
        self.responses.append(refresh.response)
        self.timeline.add(refresh)
        for eye, stages in enumerate(refresh.stage_ms):
            self.rows.append({**moment.figures, "eye": eye, **stage_columns(stages)})

    def measured(self, figures: Mapping[tuple[int, int], Row]) -> None:
        """Add the figures of the measured refreshes, by (frame, eye)."""
        for row in self.rows:
            row.update(figures.get((row["frame"], row["eye"]), _NOT_MEASURED))

    def compared(self, times: Mapping[tuple[int, int], Stages], figures: Mapping[tuple[int, int], Row]) -> list[Row]:
        """Return rows of a comparison on some refreshes: own times and figures, the same heads."""
        return [
            {**row, **stage_columns(times[key]), **figures.get(key, _NOT_MEASURED)}
            for row in self.rows
            if (key := (row["frame"], row["eye"])) in times
        ]

    def frames_csv(self) -> Iterator[Row]:
        """Yield the rows with the columns of report.FRAME_COLUMNS; both eyes share the poses."""
        for row in self.rows:
            yield {**row, **self.moments[row["frame"]].poses()}


ANSWER_COLUMNS = (*INPUT_COLUMNS, "response_ms")


@attrs.define(eq=False)
class Answers:
    """Inputs, each with the instant when a picture first showed what came of it."""

    # When the first picture was drawn: older inputs do not count.
    since_ns: int = 0
    _last_ns: int = 0
    # Instant 0 on the clock of a file of inputs.
    epoch_ns: int = 0
    _early: list[InputEvent] = attrs.field(factory=list)
    _waiting: deque[InputEvent] = attrs.field(factory=deque)  # oldest first
    _answered: list[tuple[InputEvent, int]] = attrs.field(factory=list)

    def add(self, event: InputEvent) -> None:
        """Add an input, later than those before."""
        (self._waiting if event.time_ns >= self.since_ns else self._early).append(event)

    def see(self, shown_ns: int, shows_ns: int) -> None:
        """Take note of a picture: it shows what came of all inputs until an instant."""
        self._last_ns = shown_ns
        while self._waiting and self._waiting[0].time_ns <= shows_ns:
            self._answered.append((self._waiting.popleft(), shown_ns))

    def entry(self) -> dict[str, Any]:
        """Return the `input` of summary.json: of inputs until the last picture."""
        found = [(shown_ns - event.time_ns) * 1e-6 for event, shown_ns in self._answered]
        waiting = sum(event.time_ns <= self._last_ns for event in self._waiting)
        count = len(found) + waiting
        if not found:
            return {"count": count, "answered": 0}
        times = {"mean": float(np.mean(found)), "p95": float(np.percentile(found, 95)), "most": max(found)}
        return {"count": count, "answered": len(found), "response_time_ms": times}

    def note(self) -> str:
        entry = self.entry()
        if "response_time_ms" not in entry:
            return f"No picture showed what came of {entry['count']} inputs."
        times = entry["response_time_ms"]
        return (
            f"Response time, from an input to the first picture drawn after it: {times['mean']:.0f} ms on average, "
            f"{times['p95']:.0f} at the 95th percentile ({entry['answered']} of {entry['count']} inputs)."
        )

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield the rows of inputs.csv, which --input takes."""
        rows: list[tuple[InputEvent, float | None]] = [(event, None) for event in self._early]
        rows += [(event, (shown_ns - event.time_ns) * 1e-6) for event, shown_ns in self._answered]
        rows += [(event, None) for event in self._waiting]
        for event, ms in rows:
            values = (event.time_ns + self.epoch_ns, event.action, event.target, *event.origin_m, *event.direction, ms)
            yield dict(zip(ANSWER_COLUMNS, values, strict=True))
