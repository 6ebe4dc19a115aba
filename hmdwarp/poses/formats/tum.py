"""TUM trajectories.

Seconds, position, quaternion, blank-separated, the columns named in a comment.
"""

from __future__ import annotations

from typing import IO

from ..options import TraceOptions
from ..reading.axes import OPENXR
from ..reading.file_head import Head, is_number
from ..reading.rows import Layout
from ..track import PoseTrack
from . import formats
from ._base import TraceFormat, has, named_layout, unnamed_layout
from ._writing import write_rows

COLUMNS = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")


class Tum(TraceFormat):
    """TUM RGB-D trajectories.

    Source: Sturm et al. 2012, A benchmark for the evaluation of RGB-D SLAM systems (the data set's
    file formats page).
    """

    name = "tum"
    summary = "# timestamp tx ty tz qx qy qz qw; seconds, blank-separated"
    writes = True

    def sniff(self, head: Head, options: TraceOptions) -> int:
        if has(head, *COLUMNS):
            return 90
        # Eight bare numbers: the layout of a TUM file that has lost its comment.
        bare = (
            head.names is None
            and head.separator is None
            and head.width == 8
            and all(is_number(f) for f in head.rows[0])
        )
        return 5 if bare else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        if head.names is not None:
            return named_layout(head, options, unit="s")
        return unnamed_layout(head, options, self.name, "xyzw", "s" if options.format else None)

    def write(self, track: PoseTrack, stream: IO[str]) -> None:
        stream.write(f"# axes: {OPENXR}\n")
        stream.write("# " + " ".join(COLUMNS) + "\n")
        write_rows(track, stream, " ", stamp=_seconds, order="xyzw")


def _seconds(time_ns: int) -> str:
    sign, time_ns = ("-", -time_ns) if time_ns < 0 else ("", time_ns)
    return f"{sign}{time_ns // 1_000_000_000}.{time_ns % 1_000_000_000:09d}"


formats.register(Tum())
