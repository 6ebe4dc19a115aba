"""Rows of frames.csv: two for each refresh, in a replay and in a live run."""

from __future__ import annotations

import functools
from collections.abc import Iterable, Sequence
from typing import Any

import attrs

from ..pipeline.loop import Refresh
from ..poses import Origin, PoseSample
from ..report import FRAME_COLUMNS, POSE_PARTS
from .speeds import Speeds

Row = dict[str, Any]
Stages = Iterable[tuple[str, float]]
HEADER = ",".join(FRAME_COLUMNS) + "\n"
STAGE_COLUMNS = ("warp_ms", "fill_ms", "effects_ms", "lens_ms", "total_ms")
NOT_KNOWN = (None,) * len(STAGE_COLUMNS)
_ORIGINS = {origin: origin.name.lower() for origin in Origin}
# The columns that differ between the eyes of a refresh, by index.
_EYE, _HOLES, _FIRST = (FRAME_COLUMNS.index(name) for name in ("eye", "hole_share", STAGE_COLUMNS[0]))
_STAGES = slice(_FIRST, _FIRST + len(STAGE_COLUMNS))
assert FRAME_COLUMNS[_STAGES] == STAGE_COLUMNS


@attrs.define(eq=False)
class Moment:
    """One refresh, except for the times of each eye's passes.

    None: not known, or not defined for the first picture.
    """

    frame: int
    # Since the start of the trace or the first picture.
    time_s: float
    shown_ns: int
    drawn_ns: int
    age_ms: float
    # From reading the head pose to submitting the picture.
    pose_age_ms: float | None
    # Angular in deg/s, linear in m/s.
    speeds: Speeds
    shown: PoseSample
    # The head pose that the frame was drawn for.
    drawn: PoseSample | None
    warp: str
    fill: str
    # How many eyes were shown.
    eyes: int

    @classmethod
    def of(
        cls, number: int, refresh: Refresh, start_ns: int, speeds: Speeds, submitted_ns: int | None = None
    ) -> Moment:
        """Return the moment of a refresh.

        start_ns: the origin of time. submitted_ns: when the picture was submitted to a display.
        """
        head, frame, plan = refresh.head, refresh.frame, refresh.plan
        read = submitted_ns is not None and head.read_ns is not None
        return cls(
            number,
            (refresh.shown_ns - start_ns) * 1e-9,
            refresh.shown_ns,
            frame.drawn_ns,
            refresh.age_ns * 1e-6,
            (submitted_ns - head.read_ns) * 1e-6 if read else None,  # type: ignore[operator]
            speeds,
            head,
            frame.head,
            str(plan.choice),
            plan.fill,
            len(refresh.eyes),
        )

    def figures(self) -> Row:
        """Return the columns that figures and charts use, by name."""
        turning, moving = self.speeds
        return {
            "frame": self.frame,
            "time_s": self.time_s,
            "shown_ns": self.shown_ns,
            "drawn_ns": self.drawn_ns,
            "age_ms": self.age_ms,
            "pose_age_ms": self.pose_age_ms,
            "pose_origin": _ORIGINS[self.shown.origin],
            "angular_speed_deg_s": turning,
            "linear_speed_m_s": moving,
            "warp": self.warp,
            "fill": self.fill,
        }

    def poses(self) -> Row:
        """Return the columns of both poses, by name."""
        columns = _pose_columns("shown", self.shown)
        if self.drawn is not None:
            columns |= {"drawn_origin": _ORIGINS[self.drawn.origin], **_pose_columns("drawn", self.drawn)}
        return columns


def stage_columns(stages: Stages) -> Row:
    """Return times by the columns of frames.csv; 0 for a stage that is not in the plan.

    The time of the client's own depth is added to that of the warp that reads it.
    """
    columns = dict.fromkeys(STAGE_COLUMNS[:-1], 0.0)
    for name, milliseconds in stages:
        columns["warp_ms" if name == "client_depth" else f"{name}_ms"] += milliseconds
    return {**columns, "total_ms": sum(columns.values())}


def rows_text(moment: Moment, stages: Sequence[Sequence[float | None]], holes: Sequence[float | None]) -> str:
    """Return one line for each eye. Fast enough for every refresh: both take about 30 us.

    stages: of each eye, in the order of STAGE_COLUMNS; holes: the share of each eye's pixels.
    """
    columns = {**moment.figures(), **moment.poses()}
    fields = [_text(columns.get(name)) for name in FRAME_COLUMNS]
    lines = []
    for eye in range(moment.eyes):
        fields[_EYE] = str(eye)
        fields[_STAGES] = map(_text, stages[eye])
        fields[_HOLES] = _text(holes[eye])
        lines.append(",".join(fields))
    lines.append("")
    return "\n".join(lines)


def _pose_columns(prefix: str, head: PoseSample) -> Row:
    values = (*head.pose.position_m.tolist(), *head.pose.orientation_xyzw.tolist())
    return dict(zip(_NAMES[prefix], values, strict=True))


_NAMES = {prefix: tuple(f"{prefix}_{part}" for part in POSE_PARTS) for prefix in ("shown", "drawn")}


def _text(value: float | str | None) -> str:
    if value is None:
        return ""
    return _quoted(value) if isinstance(value, str) else repr(value)


@functools.lru_cache(64)
def _quoted(text: str) -> str:
    """Quote a value for CSV: a warp's settings are separated by commas."""
    return '"' + text.replace('"', '""') + '"' if any(mark in text for mark in ',"\r\n') else text
