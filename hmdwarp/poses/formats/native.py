"""hmdwarp's own traces: CSV with a comment header that states the origin of the motion."""

from __future__ import annotations

from collections.abc import Iterable
from typing import IO, TYPE_CHECKING

from ..options import TraceOptions
from ..reading.file_head import Head
from ..reading.rows import BY_FORMAT, Layout
from ..track import PoseTrack
from . import formats
from ._base import TraceFormat, has, named_layout
from ._writing import exact_text, write_rows

if TYPE_CHECKING:
    from ...geometry import Pose

COLUMNS = ("time_ns", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
TITLE = "hmdwarp head trace"
AXES = "world_from_head in OpenXR axes: right-handed, +x right, +y up, -z forward, metres; quaternion x y z w"


class Native(TraceFormat):
    name = "native"
    summary = "time_ns,x_m,y_m,z_m,qx,qy,qz,qw; comment header with origin; OpenXR axes"
    writes = True

    def sniff(self, head: Head, options: TraceOptions) -> int:
        return 100 if has(head, *COLUMNS) else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        return named_layout(head, options, unit="ns", axes_by=BY_FORMAT)

    def write(self, track: PoseTrack, stream: IO[str]) -> None:
        write_native(track, stream)


formats.register(Native())


def write_native(track: PoseTrack, stream: IO[str], decimals: tuple[int, int] | None = None) -> None:
    """Write comment header, column names, rows.

    decimals: of positions and quaternions; None writes every bit.
    """
    stream.write(header_text(track.origin, track.rate_hz, track.notes))
    write_rows(track, stream, ",", stamp=str, order="xyzw", decimals=decimals)


def header_text(origin: str, rate_hz: float, notes: Iterable[str] = ()) -> str:
    """Return everything above the rows.

    origin: of the motion, in words. notes: for readers of the file.
    """
    head = [TITLE, f"origin: {origin or 'not told'}", f"rate: {rate_hz:.6g} Hz", f"axes: {AXES}", *notes]
    # One line each: a note with a newline in it would become a row.
    return "".join(f"# {' '.join(text.split())}\n" for text in head) + ",".join(COLUMNS) + "\n"


def row_text(time_ns: int, pose: Pose) -> str:
    """Return one sample in full precision, for a trace that is written while it grows."""
    return f"{time_ns},{exact_text((*pose.position_m.tolist(), *pose.orientation_xyzw.tolist()), ',')}\n"
