"""Bags of ROS 1 (.bag) and of ROS 2 in SQLite (.db3): poses, transforms, odometry."""

from . import TraceFormat, formats
from .mcap import Mcap


@formats.register
class RosBag(Mcap):
    """Recordings of ROS; those of ROS 2 in MCAP are of format mcap.

    Source: ROS REP 103 and REP 105; the format of bags, as rosbags reads it.
    """

    name = kind = "rosbag"
    summary = "bag of ROS 1 or 2 (.bag, .db3): poses, transforms, odometry (pip install '.[bags]')"
    file = "bag of ROS"
    writes = binary = False
    write = TraceFormat.write
