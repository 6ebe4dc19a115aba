"""What a run remembers of each refresh: one row per eye as in frames.csv, in bounded bytes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

import numpy as np

from ..link import ResponseTime
from ..metrics import QUALITY
from ..pipeline.loop import Refresh
from ..poses import Origin, PoseSample, PoseTrack
from ..poses.quaternions import angle_between
from ..report import POSE_PARTS

Row = dict[str, Any]
Stages = Iterable[tuple[str, float]]
_NOT_MEASURED = dict.fromkeys(QUALITY)


class RunLog:
    """`rows` are what the figures are made from, two for each refresh; `frames_csv` adds the poses, which both eyes share; `responses`: one
    response time for each refresh.

    Poses are kept as they are and turned into columns only while they are written: ten minutes at 60 Hz are 72,000 rows.
    """

    def __init__(self, track: PoseTrack) -> None:
        self._track = track
        self.rows: list[Row] = []
        self.responses: list[ResponseTime] = []
        self._heads: list[tuple[PoseSample, PoseSample | None]] = []

    def add(self, refresh: Refresh) -> None:
        """The next refresh."""
        number = len(self._heads)
        turning, moving = speeds(self._track, refresh.shown_ns)
        self._heads.append((refresh.head, refresh.frame.head))
        self.responses.append(refresh.response)
        for eye, stages in enumerate(refresh.stage_ms):
            self.rows.append(
                {
                    "frame": number,
                    "eye": eye,
                    "time_s": (refresh.shown_ns - self._track.start_ns) * 1e-9,
                    "shown_ns": refresh.shown_ns,
                    "drawn_ns": refresh.frame.drawn_ns,
                    "age_ms": refresh.age_ns * 1e-6,
                    "pose_origin": Origin(refresh.head.origin).name.lower(),
                    "angular_speed_deg_s": turning,
                    "linear_speed_m_s": moving,
                    **stage_columns(stages),
                    "warp": str(refresh.plan.choice),
                    "fill": refresh.plan.fill,
                }
            )

    def measured(self, figures: Mapping[tuple[int, int], Row]) -> None:
        """Enter the figures of the refreshes that were measured, by (frame, eye)."""
        for row in self.rows:
            row.update(figures.get((row["frame"], row["eye"]), _NOT_MEASURED))

    def compared(self, times: Mapping[tuple[int, int], Stages], figures: Mapping[tuple[int, int], Row]) -> list[Row]:
        """Rows of another warp that ran beside this one on some refreshes: its own times and figures, the same head."""
        return [
            {**row, **stage_columns(times[key]), **figures.get(key, _NOT_MEASURED)}
            for row in self.rows
            if (key := (row["frame"], row["eye"])) in times
        ]

    def frames_csv(self) -> Iterator[Row]:
        """The rows with all columns of report.schema.FRAME_COLUMNS."""
        for row in self.rows:
            shown, drawn = self._heads[row["frame"]]
            yield {**row, **_pose_columns("shown", shown), **_drawn_columns(drawn)}


def stage_columns(stages: Stages) -> Row:
    """Times by frames.csv's columns; the client's own depth belongs to the warp that asked for it. 0 for a stage not in the plan."""
    columns = dict.fromkeys(("warp_ms", "fill_ms", "effects_ms", "lens_ms"), 0.0)
    for name, milliseconds in stages:
        columns["warp_ms" if name == "client_depth" else f"{name}_ms"] += milliseconds
    return {**columns, "total_ms": sum(columns.values())}


def _pose_columns(prefix: str, head: PoseSample) -> Row:
    values = (*head.pose.position_m, *head.pose.orientation_xyzw)
    return {f"{prefix}_{part}": float(value) for part, value in zip(POSE_PARTS, values, strict=True)}


def _drawn_columns(head: PoseSample | None) -> Row:
    return {} if head is None else {"drawn_origin": Origin(head.origin).name.lower(), **_pose_columns("drawn", head)}


def speeds(track: PoseTrack, time_ns: int, half_ns: int = 5_000_000) -> tuple[float, float]:
    """Angular speed in deg/s and linear speed in m/s, by central differences over 10 ms."""
    before, after = track.at(time_ns - half_ns).pose, track.at(time_ns + half_ns).pose
    turned = angle_between(before.orientation_xyzw, after.orientation_xyzw)
    seconds = 2 * half_ns * 1e-9
    return float(np.degrees(turned) / seconds), float(np.linalg.norm(after.position_m - before.position_m) / seconds)
