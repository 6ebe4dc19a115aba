"""hmdwarp's own traces: CSV with a comment header that states the origin of the motion."""

from __future__ import annotations

from collections.abc import Iterable
from typing import IO

from ...geometry import Pose
from ..assumptions import By
from ..track import PoseTrack
from . import TraceFormat, formats, write_rows

COLUMNS = ("time_ns", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
GAZE = ("gaze_x", "gaze_y", "gaze_z")
TITLE = "hmdwarp head trace"
AXES = "world_from_head in OpenXR axes: right-handed, +x right, +y up, -z forward, metres; quaternion x y z w"


@formats.register
class Native(TraceFormat):
    name = "native"
    summary = "time_ns,x_m,y_m,z_m,qx,qy,qz,qw[,gaze_x,gaze_y,gaze_z]; comment header with origin; OpenXR axes"
    header = COLUMNS
    likelihood = 100
    facts = {"gaze": GAZE, "unit": "ns", "axes_by": By.FORMAT, "scale_by": By.FORMAT, "direction_by": By.FORMAT}
    writes = True

    def write(self, track: PoseTrack, stream: IO[str]) -> None:
        write_native(track, stream)


def write_native(track: PoseTrack, stream: IO[str], decimals: tuple[int, int] | None = None) -> None:
    """Write header, column names, rows. decimals: of positions, quaternions; None for every bit."""
    columns = COLUMNS if track.gaze is None else (*COLUMNS, *GAZE)
    stream.write(header_text(track.origin, track.rate_hz, track.notes, columns))
    write_rows(track, stream, ",", stamp=str, order="xyzw", decimals=decimals, gaze=True)


def header_text(origin: str, rate_hz: float, notes: Iterable[str] = (), columns: Iterable[str] = COLUMNS) -> str:
    """Return what is above the rows. origin: of the motion, in words. notes: for readers."""
    head = [TITLE, f"origin: {origin or 'not told'}", f"rate: {rate_hz:.6g} Hz", f"axes: {AXES}", *notes]
    # One line each: a note with a newline in it would become a row.
    return "".join(f"# {' '.join(text.split())}\n" for text in head) + ",".join(columns) + "\n"


def row_text(time_ns: int, pose: Pose) -> str:
    """Return one sample in full precision, for a trace that is written while it grows."""
    numbers = (*pose.position_m.tolist(), *pose.orientation_xyzw.tolist())
    return f"{time_ns},{','.join(map(repr, numbers))}\n"
