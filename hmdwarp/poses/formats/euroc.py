"""EuRoC (ASL) ground truth.

Columns: ns, position, quaternion with w first, optionally velocities and biases.
"""

from __future__ import annotations

from typing import IO

from ..assumptions import By
from ..options import TraceOptions
from ..reading.axes import OPENXR
from ..reading.file_head import Head
from ..track import PoseTrack
from . import TraceFormat, formats, numbers_alone, write_rows

HEADER = "#timestamp [ns], p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z []"


@formats.register
class Euroc(TraceFormat):
    """Ground truth of the EuRoC data sets.

    Source: Burri et al. 2016, The EuRoC micro aerial vehicle datasets (section on the ASL data
    format).
    """

    name = "euroc"
    summary = "#timestamp [ns], p_RS_R_x [m], .., q_RS_w [], ..; nanoseconds, w first"
    facts = {"unit": "ns", "scale_by": By.FORMAT, "direction_by": By.FORMAT}
    bare_order = "wxyz"
    writes = True

    def sniff(self, head: Head, options: TraceOptions) -> int:
        if head.names is not None:
            return 95 if {n.split(" ")[0] for n in head.names} >= {"p_RS_R_x", "q_RS_w"} else 0
        return 5 if numbers_alone(head, ",", 8, 17) else 0

    def write(self, track: PoseTrack, stream: IO[str]) -> None:
        stream.write(f"# axes: {OPENXR}\n{HEADER}\n")
        write_rows(track, stream, ",", stamp=str, order="wxyz")
