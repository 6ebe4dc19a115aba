"""ROS 2 messages as CSV: a column for each field, times as seconds and nanoseconds."""

from __future__ import annotations

from ..assumptions import By
from ..options import TraceOptions
from ..reading.columns import find_columns
from ..reading.file_head import Head
from . import TraceFormat, formats


@formats.register
class Ros2Csv(TraceFormat):
    """Poses, transforms and odometry of a bag, as exporters write them.

    Source: ROS 2 message std_msgs/Header; ROS REP 103 for the axes.
    """

    name = "ros2_csv"
    summary = "header.stamp.sec, header.stamp.nanosec, .. position.x, .. orientation.w; ROS axes"
    facts = {"axes": "ros", "axes_by": By.FORMAT, "scale_by": By.FORMAT, "direction_by": By.FORMAT}

    def sniff(self, head: Head, options: TraceOptions) -> int:
        if head.names is None or find_columns(head.names).nanoseconds is None:
            return 0
        return 50 if any("header" in name.lower() for name in head.names) else 0
