"""Write head traces, so that reading them gives the same poses bit for bit."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import IO

import numpy as np

from ..geometry import Pose
from .reading.axes import OPENXR
from .track import PoseTrack

COLUMNS = ("time_ns", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
GAZE = ("gaze_x", "gaze_y", "gaze_z")
TITLE = "hmdwarp head trace"
AXES = "world_from_head in OpenXR axes: right-handed, +x right, +y up, -z forward, metres; quaternion x y z w"
_BLOCK = 65536  # rows written at a time
_LARGEST_NS = 2**62  # what the readers accept
_SECOND_NS = 1_000_000_000


def write_rows(
    track: PoseTrack, stream: IO[str], separator: str, order: str = "xyzw", stamp: Callable[[int], str] = str,
    decimals: tuple[int, int] | None = None, gaze: bool = False,
) -> None:  # fmt: skip
    """Write time, position and quaternion of every sample.

    order: xyzw or wxyz. stamp: nanoseconds to text. decimals: of positions and quaternions; None
    writes the shortest text that reads back as the same number. gaze: where the eyes look, too, if
    the track has it; 0 0 0 where it is not known.
    """
    # What restores the recording's own clock, if readers take that.
    offset = track.epoch_ns if abs(track.epoch_ns) + max(abs(track.start_ns), abs(track.end_ns)) < _LARGEST_NS else 0
    columns, seen, row = ["xyzw".index(c) for c in order], track.gaze if gaze else None, ""
    for a in range(0, len(track), _BLOCK):
        part = slice(a, a + _BLOCK)
        position, orientation = track.position_m[part], track.orientation_xyzw[part][:, columns]
        if seen is not None:
            orientation = np.hstack([orientation, np.nan_to_num(seen[part])])
        if decimals is not None:  # + 0.0 turns a rounded -0.0 into 0.0
            position, orientation = np.round(position, decimals[0]) + 0.0, np.round(orientation, decimals[1]) + 0.0
            row = separator.join([f"%.{decimals[0]}f"] * 3 + [f"%.{decimals[1]}f"] * orientation.shape[1])
        for time, p, q in zip(track.time_ns[part].tolist(), position.tolist(), orientation.tolist(), strict=True):
            text = row % (*p, *q) if row else separator.join(map(repr, p + q))
            stream.write(f"{stamp(time + offset)}{separator}{text}\n")


def write_native(track: PoseTrack, stream: IO[str], decimals: tuple[int, int] | None = None) -> None:
    """Write header, column names, rows. decimals: of positions, quaternions; None for every bit."""
    columns = COLUMNS if track.gaze is None else (*COLUMNS, *GAZE)
    stream.write(header_text(track.origin, track.rate_hz, track.notes, columns))
    write_rows(track, stream, ",", decimals=decimals, gaze=True)


def header_text(origin: str, rate_hz: float, notes: Iterable[str] = (), columns: Iterable[str] = COLUMNS) -> str:
    """Return what is above the rows. origin: of the motion, in words. notes: for readers."""
    head = [TITLE, f"origin: {origin or 'not told'}", f"rate: {rate_hz:.6g} Hz", f"axes: {AXES}", *notes]
    # One line each: a note with a newline in it would become a row.
    return "".join(f"# {' '.join(text.split())}\n" for text in head) + ",".join(columns) + "\n"


def row_text(time_ns: int, pose: Pose) -> str:
    """Return one sample in full precision, for a trace that is written while it grows."""
    numbers = (*pose.position_m.tolist(), *pose.orientation_xyzw.tolist())
    return f"{time_ns},{','.join(map(repr, numbers))}\n"


def write_text(
    track: PoseTrack, stream: IO[str], names: str, separator: str, order: str, seconds: bool = False
) -> None:
    """Write names of columns and rows. seconds: stamps are decimal seconds, else nanoseconds."""

    def stamp(time_ns: int) -> str:
        whole, rest = divmod(abs(time_ns), _SECOND_NS)
        return f"{'-' * (time_ns < 0)}{whole}.{rest:09d}" if seconds else str(time_ns)

    stream.write(f"# axes: {OPENXR}\n{names}\n")
    write_rows(track, stream, separator, order, stamp)


WRITERS: dict[str, Callable[..., None]] = {"native": write_native, "text": write_text}
