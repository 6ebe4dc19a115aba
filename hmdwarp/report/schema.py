"""The names other tools read: columns of frames.csv and keys of summary.json."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Mapping
from typing import Any

from ..errors import InputError
from ..metrics import QUALITY, STAGES

SCHEMA = 1

POSE_PARTS = ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")

# One row per frame and eye, of a replay and of a live run. Metrics are empty where a frame was not
# measured; a live run has those that need no truth.
FRAME_COLUMNS = (
    "frame",  # counts the shown frames from 0
    "eye",  # 0 left, 1 right
    "time_s",  # shown_ns since the start of the trace, in seconds; live: since the first picture
    "shown_ns",  # when the picture is seen
    "drawn_ns",  # when the late frame it was made from was drawn
    "age_ms",  # shown_ns - drawn_ns
    "pose_age_ms",  # from reading the head to handing the picture over; empty in a replay
    "pose_origin",  # how the shown pose was obtained: measured, interpolated, predicted, held
    "angular_speed_deg_s",
    "linear_speed_m_s",
    *(f"{stage}_ms" for stage in STAGES),
    *QUALITY,
    *(f"shown_{part}" for part in POSE_PARTS),  # world_from_head the picture was warped to
    "drawn_origin",  # how the pose the frame was drawn for was obtained
    *(f"drawn_{part}" for part in POSE_PARTS),  # world_from_head the frame was drawn for
    "warp",  # of this picture; the same in all rows unless warp "auto" or the user of a live run changed it
    "fill",
)

# What differs from run to run, and between machines: equal runs are equal in all else.
TIMED_COLUMNS = ("pose_age_ms", *(f"{stage}_ms" for stage in STAGES))
TIMED_KEYS = ("time_ms", "response_ms", "machine", "made_with", "hmdwarp", "notes", "digests")

SUMMARY_KEYS = (
    "schema",
    "hmdwarp",
    "trace",
    "scene",
    "effects",
    "latency_ms",
    "warp",
    "fill",
    "lens",
    "headset",
    "size",
    "frames",
    "machine",
    "clock",
    "time_ms",
    "quality",
)
MACHINE_KEYS = ("gl_renderer", "gl_version", "cpu_count")
CLOCKS = ("gpu", "wall")
_LARGEST = sys.float_info.max  # JSON may hold whole numbers beyond it
_MOST_PIXELS = 1 << 20  # on a side

_TEXTS = ("hmdwarp", "trace", "scene", "warp", "fill", "lens", "headset")


def validate_summary(summary: Mapping[str, Any]) -> None:
    """Check that this is a summary of this schema; unknown keys are fine.

    Numbers are finite; a figure may be None where nothing was measured.
    Errors: InputError that names every fault at once.
    """
    faults = summary_faults(summary)
    if faults:
        raise InputError(f"no summary of schema {SCHEMA}: {'; '.join(faults)}")


def summary_faults(summary: Any) -> list[str]:
    """Return the faults of a summary, one phrase each."""
    if not isinstance(summary, Mapping):
        return [f"it is a {type(summary).__name__}, expected an object"]
    faults = [f"'{key}' is missing" for key in SUMMARY_KEYS if key not in summary]
    for key, expected, fits in _CHECKS:
        if key in summary and not fits(summary[key]):
            faults.append(f"'{key}' is {summary[key]!r}, expected {expected}")
    faults += _table_faults(summary, "time_ms", STAGES, ("median", "p95"))
    faults += _table_faults(summary, "quality", QUALITY, ("mean", "p95"))
    return faults


def _is_count(value: Any, least: int = 0) -> bool:
    return isinstance(value, int) and not isinstance(value, bool) and value >= least


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and -_LARGEST <= value <= _LARGEST


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and value != ""


def _is_guard(value: Any) -> bool:
    if isinstance(value, str):
        return re.fullmatch(r"[1-9]\d*(\.\d+)?x[1-9]\d*(\.\d+)?", value) is not None
    return _is_number(value) and value >= 1


def _is_size(value: Any) -> bool:
    sides = value if isinstance(value, list | tuple) else ()
    return len(sides) == 2 and all(_is_count(side, 1) and side <= _MOST_PIXELS for side in sides)


def _is_machine(value: Any) -> bool:
    return isinstance(value, Mapping) and set(MACHINE_KEYS) <= set(value) and _is_count(value["cpu_count"], 1)


_CHECKS: tuple[tuple[str, str, Callable[[Any], bool]], ...] = (
    ("schema", str(SCHEMA), lambda v: _is_count(v) and v == SCHEMA),
    *((key, "a text", _is_text) for key in _TEXTS),
    ("effects", "a list of names", lambda v: isinstance(v, list) and all(_is_text(name) for name in v)),
    ("latency_ms", "a number from 0", lambda v: _is_number(v) and v >= 0),
    ("size", "[w, h] in pixels", _is_size),
    ("frames", "a count", _is_count),
    ("machine", f"an object with {', '.join(MACHINE_KEYS)}", _is_machine),
    ("clock", " or ".join(CLOCKS), lambda v: v in CLOCKS),
    # Optional, but read where they are.
    ("rate_hz", "a number above 0", lambda v: _is_number(v) and v > 0),
    ("server_rate_hz", "a number above 0, or null", lambda v: v is None or (_is_number(v) and v > 0)),
    ("guard", "a number from 1, or a text like 1.25x1.125", _is_guard),
    ("predict", "a text", _is_text),
    ("strategy", "a text", _is_text),
)


def _table_faults(summary: Mapping[str, Any], key: str, names: tuple[str, ...], figures: tuple[str, ...]) -> list[str]:
    table = summary.get(key, {})
    if not isinstance(table, Mapping):
        return [f"'{key}' is {table!r}, expected an object"]
    faults = []
    for name in names if key in summary else ():
        entry = table.get(name)
        if not isinstance(entry, Mapping) or not set(figures) <= set(entry):
            faults.append(f"'{key}.{name}' is {entry!r}, expected {' and '.join(figures)}")
            continue
        bad = [f for f in figures if entry[f] is not None and not _is_number(entry[f])]
        faults += [f"'{key}.{name}.{f}' is {entry[f]!r}, expected a finite number or null" for f in bad]
    return faults
