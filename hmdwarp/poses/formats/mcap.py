"""MCAP: poses of ROS 2 and Foxglove messages; written as foxglove.PoseInFrame in JSON."""

from __future__ import annotations

import json
from typing import IO, Any

import numpy as np

from ...resources import import_extra
from ..assumptions import By, Defect, Layout
from ..options import TraceOptions
from ..reading.axes import parse_axes
from ..reading.file_head import Head
from ..reading.pose_messages import COLUMNS, EXTRA, METADATA
from ..track import PoseTrack
from . import TraceFormat, clock_offset_ns, formats

AXES = "ros"
_TOPIC, _FRAME = "/head", "world"
_SECOND_NS = 1_000_000_000


_UNSTAMPED = Defect(
    "stamp-missing", "its messages have no time stamps of their own", "the times at which they were logged taken"
)


def of_object(**properties: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON schema of an object."""
    return {"type": "object", "properties": properties}


def numbers(names: str) -> dict[str, Any]:
    """Return the JSON schema of an object of numbers with one-letter names."""
    return of_object(**{name: {"type": "number"} for name in names})


# The properties of foxglove.PoseInFrame.
POSES = {
    "timestamp": of_object(sec={"type": "integer", "minimum": 0}, nsec={"type": "integer", "minimum": 0}),
    "frame_id": {"type": "string"},
    "pose": of_object(position=numbers("xyz"), orientation=numbers("xyzw")),
}


def stamp(time_ns: int) -> dict[str, int]:
    """Return a time stamp of Foxglove's JSON."""
    return dict(zip(("sec", "nsec"), divmod(time_ns, _SECOND_NS), strict=True))


class PoseMessages:
    """Write an MCAP file with the head as foxglove.PoseInFrame in JSON, in the axes of ROS.

    metadata: what is stated of the poses beside their axes.
    """

    def __init__(self, stream: IO[bytes], **metadata: str) -> None:
        self._writer = import_extra("mcap.writer", "mcap", EXTRA).Writer(stream)
        self._writer.start(profile="", library="hmdwarp")
        self._writer.add_metadata(METADATA, {"axes": AXES, **metadata})
        self._head = self.channel(_TOPIC, "foxglove.PoseInFrame", POSES)

    def channel(self, topic: str, name: str, properties: dict[str, Any]) -> int:
        """Return the number of a new topic of JSON messages, as put() takes it."""
        text = json.dumps({"title": name, **of_object(**properties)}).encode()
        number: int = self._writer.register_channel(
            topic, "json", self._writer.register_schema(name, "jsonschema", text)
        )
        return number

    def add(self, time_ns: int, position: dict[str, float], orientation: dict[str, float]) -> None:
        """Add the head. time_ns: 0 or later."""
        pose = {"position": position, "orientation": orientation}
        self.put(self._head, time_ns, json.dumps({"timestamp": stamp(time_ns), "frame_id": _FRAME, "pose": pose}))

    def put(self, channel: int, time_ns: int, text: str) -> None:
        """Add a message."""
        self._writer.add_message(channel, time_ns, text.encode(), time_ns)

    def close(self) -> None:
        """Write the index. The stream stays open."""
        self._writer.finish()


@formats.register
class Mcap(TraceFormat):
    """Recordings of ROS 2 and Foxglove.

    Axes are those of ROS unless the file states others. Source: MCAP specification; Foxglove
    schemas; ROS REP 103 and REP 105.
    """

    name = kind = "mcap"
    summary = "MCAP of ROS 2 or Foxglove: poses, transforms, odometry; ROS axes (pip install '.[mcap]')"
    file = "MCAP file"  # for messages
    writes = True
    binary = True
    axes_written = AXES
    order = "quaternion xyzw"
    facts = {
        **{"unit": "ns", "axes": AXES, "axes_by": By.FORMAT, "scale_by": By.FORMAT},
        **{"order_by": By.FORMAT, "direction_by": By.FORMAT},
    }

    def layout(self, head: Head, options: TraceOptions) -> Layout:
        stamped = any(int(row[0]) for row in head.rows)
        return Layout(
            time=COLUMNS.index("stamp_ns" if stamped else "log_time_ns"),
            unit_by=By.FORMAT,
            columns_by=By.FORMAT,
            **self.facts,
            device=COLUMNS.index("topic"),
            position=(3, 4, 5),
            orientation=(6, 7, 8, 9),
            caveats=() if stamped else (_UNSTAMPED,),
        )

    def write(self, track: PoseTrack, stream: IO[bytes]) -> None:
        messages = PoseMessages(stream, origin=track.origin)
        times = track.time_ns + clock_offset_ns(track)
        times -= min(0, int(times[0]))  # a log begins at 0 or later
        basis = parse_axes(AXES).world
        position, turn = track.position_m @ basis, track.orientation_xyzw[:, :3] @ basis
        turned = np.column_stack([turn, track.orientation_xyzw[:, 3]])
        for time_ns, p, q in zip(times.tolist(), position.tolist(), turned.tolist(), strict=True):
            messages.add(time_ns, dict(zip("xyz", p, strict=True)), dict(zip("xyzw", q, strict=True)))
        messages.close()
