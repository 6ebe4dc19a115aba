"""TUM trajectories.

Seconds, position, quaternion, blank-separated, the columns named in a comment.
"""

from __future__ import annotations

from typing import IO

from ..assumptions import By
from ..options import TraceOptions
from ..reading.axes import OPENXR
from ..reading.file_head import Head
from ..track import PoseTrack
from . import TraceFormat, formats, numbers_alone, write_rows


@formats.register
class Tum(TraceFormat):
    """TUM RGB-D trajectories.

    Source: Sturm et al. 2012, A benchmark for the evaluation of RGB-D SLAM systems (the data set's
    file formats page).
    """

    name = "tum"
    summary = "# timestamp tx ty tz qx qy qz qw; seconds, blank-separated"
    header = ("timestamp", "tx", "ty", "tz", "qx", "qy", "qz", "qw")
    facts = {"unit": "s", "scale_by": By.FORMAT, "direction_by": By.FORMAT}
    bare_order = "xyzw"
    writes = True

    def sniff(self, head: Head, options: TraceOptions) -> int:
        # Eight bare numbers: the layout of a TUM file that has lost its comment.
        return 5 if numbers_alone(head, None, 8) else super().sniff(head, options)

    def write(self, track: PoseTrack, stream: IO[str]) -> None:
        stream.write(f"# axes: {OPENXR}\n# {' '.join(self.header)}\n")
        write_rows(track, stream, " ", stamp=_seconds, order="xyzw")


def _seconds(time_ns: int) -> str:
    sign, time_ns = ("-", -time_ns) if time_ns < 0 else ("", time_ns)
    return f"{sign}{time_ns // 1_000_000_000}.{time_ns % 1_000_000_000:09d}"
