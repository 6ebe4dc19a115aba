"""MCAP: poses of ROS 2 and Foxglove messages; written as foxglove.PoseInFrame in JSON."""

from __future__ import annotations

import json
from typing import IO, Any

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


def _object(**properties: dict[str, Any]) -> dict[str, Any]:
    return {"type": "object", "properties": properties}


def _numbers(names: str) -> dict[str, Any]:
    return _object(**{name: {"type": "number"} for name in names})


_SCHEMA = {
    "title": "foxglove.PoseInFrame",
    **_object(
        timestamp=_object(sec={"type": "integer", "minimum": 0}, nsec={"type": "integer", "minimum": 0}),
        frame_id={"type": "string"},
        pose=_object(position=_numbers("xyz"), orientation=_numbers("xyzw")),
    ),
}


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
        writer = import_extra("mcap.writer", "mcap", EXTRA).Writer(stream)
        writer.start(profile="", library="hmdwarp")
        schema = writer.register_schema("foxglove.PoseInFrame", "jsonschema", json.dumps(_SCHEMA).encode())
        channel = writer.register_channel(_TOPIC, "json", schema)
        writer.add_metadata(METADATA, {"axes": AXES, "origin": track.origin})
        times = track.time_ns + clock_offset_ns(track)
        times -= min(0, int(times[0]))  # a log begins at 0 or later
        basis = parse_axes(AXES).world
        position, turn = track.position_m @ basis, track.orientation_xyzw[:, :3] @ basis
        for i, (time_ns, p, v, w) in enumerate(
            zip(times.tolist(), position.tolist(), turn.tolist(), track.orientation_xyzw[:, 3].tolist(), strict=True)
        ):
            sec, nsec = divmod(time_ns, _SECOND_NS)
            place, turned = dict(zip("xyz", p, strict=True)), dict(zip("xyzw", (*v, w), strict=True))
            pose = {"position": place, "orientation": turned}
            data = json.dumps({"timestamp": {"sec": sec, "nsec": nsec}, "frame_id": _FRAME, "pose": pose}).encode()
            writer.add_message(channel, time_ns, data, time_ns, sequence=i)
        writer.finish()


formats.register(Mcap())
