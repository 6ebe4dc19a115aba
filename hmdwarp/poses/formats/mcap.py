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

_TOPIC, _FRAME = "/head", "world"
_SECOND_NS = 1_000_000_000


_UNSTAMPED = Defect(
    "stamp-missing", "its messages have no time stamps of their own", "the times at which they were logged taken"
)


def _object(**properties: dict[str, Any]) -> dict[str, Any]:
    """Return the JSON schema of an object."""
    return {"type": "object", "properties": properties}


def _numbers(names: str) -> dict[str, Any]:
    return _object(**{name: {"type": "number"} for name in names})


# Of foxglove.PoseInFrame.
_SCHEMA = {
    "title": "foxglove.PoseInFrame",
    **_object(
        timestamp=_object(sec={"type": "integer", "minimum": 0}, nsec={"type": "integer", "minimum": 0}),
        frame_id={"type": "string"},
        pose=_object(position=_numbers("xyz"), orientation=_numbers("xyzw")),
    ),
}


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
    axes_written = "ros"
    order = "quaternion xyzw"
    facts = {
        **{"unit": "ns", "axes": axes_written, "axes_by": By.FORMAT, "scale_by": By.FORMAT},
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
        writer = import_extra("mcap.writer", "mcap", EXTRA).Writer(stream)
        writer.start(profile="", library="hmdwarp")
        writer.add_metadata(METADATA, {"axes": self.axes_written, "origin": track.origin})
        schema = writer.register_schema(_SCHEMA["title"], "jsonschema", json.dumps(_SCHEMA).encode())
        channel = writer.register_channel(_TOPIC, "json", schema)
        times = track.time_ns + clock_offset_ns(track)
        times -= min(0, int(times[0]))  # a log begins at 0 or later
        basis = parse_axes(self.axes_written).world
        position, turn = track.position_m @ basis, track.orientation_xyzw[:, :3] @ basis
        turned = np.column_stack([turn, track.orientation_xyzw[:, 3]])
        for time_ns, p, q in zip(times.tolist(), position.tolist(), turned.tolist(), strict=True):
            pose = {"position": dict(zip("xyz", p, strict=True)), "orientation": dict(zip("xyzw", q, strict=True))}
            stamp = dict(zip(("sec", "nsec"), divmod(time_ns, _SECOND_NS), strict=True))
            text = json.dumps({"timestamp": stamp, "frame_id": _FRAME, "pose": pose})
            writer.add_message(channel, time_ns, text.encode(), time_ns)
        writer.finish()
