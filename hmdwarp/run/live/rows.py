"""Rows of frames.csv as text, as fast as pictures come: a refresh of two eyes takes about 25 us."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import attrs

from ...poses import Origin, PoseSample
from ...report import FRAME_COLUMNS, POSE_PARTS

_SHOWN = tuple(f"shown_{part}" for part in POSE_PARTS)
_DRAWN = tuple(f"drawn_{part}" for part in POSE_PARTS)
_ORIGINS = {origin: origin.name.lower() for origin in Origin}
HEADER = ",".join(FRAME_COLUMNS) + "\n"

STAGE_COLUMNS = ("warp_ms", "fill_ms", "effects_ms", "lens_ms", "total_ms")
NOT_KNOWN = (None,) * len(STAGE_COLUMNS)
# What differs between the eyes of a refresh, by its place in a line.
_EYE, _HOLES, _FIRST = (FRAME_COLUMNS.index(name) for name in ("eye", "hole_share", STAGE_COLUMNS[0]))
_STAGES = slice(_FIRST, _FIRST + len(STAGE_COLUMNS))
assert FRAME_COLUMNS[_STAGES] == STAGE_COLUMNS


@attrs.define(eq=False)
class Moment:
    """What is told of one refresh, but for what each eye's passes took. None: not known, or not there at the first picture.

    drawn: the head the frame was drawn for. eyes: how many were shown.
    """

    frame: int
    time_s: float
    shown_ns: int
    drawn_ns: int
    age_ms: float
    pose_age_ms: float | None
    angular_speed_deg_s: float | None
    linear_speed_m_s: float | None
    shown: PoseSample
    drawn: PoseSample | None
    warp: str
    fill: str
    eyes: int


def rows_text(moment: Moment, stages: Sequence[Sequence[float | None]], holes: Sequence[float | None]) -> str:
    """One line for each eye. stages: of each eye, in the order of STAGE_COLUMNS; holes: the share of each eye's pixels."""
    texts = _shared(moment)
    fields = [texts.get(name, "") for name in FRAME_COLUMNS]
    lines = []
    for eye in range(moment.eyes):
        fields[_EYE] = str(eye)
        fields[_STAGES] = map(_number, stages[eye])
        fields[_HOLES] = _number(holes[eye])
        lines.append(",".join(fields))
    lines.append("")
    return "\n".join(lines)


def _shared(moment: Moment) -> dict[str, str]:
    texts = {
        "frame": str(moment.frame),
        "time_s": repr(moment.time_s),
        "shown_ns": str(moment.shown_ns),
        "drawn_ns": str(moment.drawn_ns),
        "age_ms": repr(moment.age_ms),
        "pose_age_ms": _number(moment.pose_age_ms),
        "pose_origin": _ORIGINS[moment.shown.origin],
        "angular_speed_deg_s": _number(moment.angular_speed_deg_s),
        "linear_speed_m_s": _number(moment.linear_speed_m_s),
        "warp": _field(moment.warp),
        "fill": _field(moment.fill),
    }
    texts.update(zip(_SHOWN, _pose(moment.shown), strict=True))
    if moment.drawn is not None:
        texts["drawn_origin"] = _ORIGINS[moment.drawn.origin]
        texts.update(zip(_DRAWN, _pose(moment.drawn), strict=True))
    return texts


def _pose(head: PoseSample) -> list[str]:
    return [repr(value) for value in (*head.pose.position_m.tolist(), *head.pose.orientation_xyzw.tolist())]


def _number(value: float | None) -> str:
    return "" if value is None else repr(value)


@functools.lru_cache(64)
def _field(text: str) -> str:
    """As csv quotes it: a warp's settings are separated by commas."""
    return '"' + text.replace('"', '""') + '"' if any(mark in text for mark in ',"\r\n') else text
