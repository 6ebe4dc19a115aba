"""hmdwarp's own traces: CSV with a comment header that says where the motion comes from."""

from __future__ import annotations

from typing import IO

from ..options import TraceOptions
from ..reading.head import Head
from ..reading.rows import Layout
from ..track import PoseTrack
from . import FORMATS
from ._base import TraceFormat, has, named_layout
from ._writing import write_rows

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
        return named_layout(head, options, unit="ns")

    def origin(self, head: Head) -> str:
        return next((text.removeprefix("origin:").strip() for _, text in head.comments if text.startswith("origin:")), "")

    def write(self, track: PoseTrack, stream: IO[str]) -> None:
        write_native(track, stream)


FORMAT = FORMATS.register(Native())


def write_native(track: PoseTrack, stream: IO[str], decimals: tuple[int, int] | None = None) -> None:
    """Comment header, column names, rows. decimals: of positions and quaternions; None writes every bit."""
    head = [TITLE, f"origin: {track.origin or 'not told'}", f"rate: {track.rate_hz:.6g} Hz", f"axes: {AXES}", *track.notes]
    # One line each: a note with a newline in it would become a row.
    stream.writelines(f"# {' '.join(text.split())}\n" for text in head)
    stream.write(",".join(COLUMNS) + "\n")
    write_rows(track, stream, ",", stamp=str, order="xyzw", decimals=decimals)
