"""ROS 2 messages as CSV: a column for each field, times as seconds beside nanoseconds."""

from __future__ import annotations

from ..options import TraceOptions
from ..reading.columns import find_columns
from ..reading.file_head import Head
from ..reading.rows import BY_FORMAT, Layout
from . import formats
from ._base import TraceFormat, named_layout

AXES = "ros"


class Ros2Csv(TraceFormat):
    """Poses, transforms and odometry of a bag, as exporters write them.

    Source: ROS 2 message std_msgs/Header; ROS REP 103 for the axes.
    """

    name = "ros2_csv"
    summary = "header.stamp.sec, header.stamp.nanosec, .. position.x, .. orientation.w; ROS axes"

    def sniff(self, head: Head, options: TraceOptions) -> int:
        if head.names is None or find_columns(head.names).nanoseconds is None:
            return 0
        return 50 if any("header" in name.lower() for name in head.names) else 0

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        return named_layout(head, options, axes=AXES, axes_by=BY_FORMAT)


formats.register(Ros2Csv())
