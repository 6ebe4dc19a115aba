"""MCAP files: written ones are read back, and those of ROS 2 and Foxglove are read right."""

from __future__ import annotations

import json

import numpy as np
import pytest

from hmdwarp.errors import TraceError
from hmdwarp.poses import TraceOptions, load_trace
from hmdwarp.poses.reading.axes import parse_axes

from .traces import found, head, kinds, same_motion, save

READER = pytest.importorskip("mcap.reader", reason="mcap is not installed (pip install '.[mcap]')")
WRITER = pytest.importorskip("mcap.writer")
ROS_WRITER = pytest.importorskip(
    "mcap_ros2.writer", reason="mcap-ros2-support is not installed (pip install '.[mcap]')"
)
EPOCH_NS = 1_700_000_000 * 10**9

_HEADER = "std_msgs/Header header\n"
_TAIL = (
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id",
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec",
    "MSG: geometry_msgs/Point\nfloat64 x\nfloat64 y\nfloat64 z",
    "MSG: geometry_msgs/Vector3\nfloat64 x\nfloat64 y\nfloat64 z",
    "MSG: geometry_msgs/Quaternion\nfloat64 x\nfloat64 y\nfloat64 z\nfloat64 w",
    "MSG: geometry_msgs/Pose\ngeometry_msgs/Point position\ngeometry_msgs/Quaternion orientation",
    "MSG: geometry_msgs/PoseWithCovariance\ngeometry_msgs/Pose pose\nfloat64[36] covariance",
    "MSG: geometry_msgs/Twist\ngeometry_msgs/Vector3 linear\ngeometry_msgs/Vector3 angular",
    "MSG: geometry_msgs/TwistWithCovariance\ngeometry_msgs/Twist twist\nfloat64[36] covariance",
    "MSG: geometry_msgs/Transform\ngeometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
    f"MSG: geometry_msgs/TransformStamped\n{_HEADER}string child_frame_id\ngeometry_msgs/Transform transform",
)
ROS = {
    "geometry_msgs/msg/PoseStamped": f"{_HEADER}geometry_msgs/Pose pose",
    "geometry_msgs/msg/PoseWithCovarianceStamped": f"{_HEADER}geometry_msgs/PoseWithCovariance pose",
    "geometry_msgs/msg/TransformStamped": f"{_HEADER}string child_frame_id\ngeometry_msgs/Transform transform",
    "nav_msgs/msg/Odometry": f"{_HEADER}string child_frame_id\ngeometry_msgs/PoseWithCovariance pose\n"
    "geometry_msgs/TwistWithCovariance twist",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms",
}


def message(kind: str, ns: int, numbers, child: str = "head", parent: str = "map") -> dict:
    """The parts of a message whose pose is the seven numbers."""
    place, turn = dict(zip("xyz", numbers, strict=False)), dict(zip("xyzw", numbers[3:], strict=True))
    made = {"header": {"stamp": {"sec": ns // 10**9, "nanosec": ns % 10**9}, "frame_id": parent}}
    if kind.endswith(("TFMessage", "TransformStamped")):
        made |= {"child_frame_id": child, "transform": {"translation": place, "rotation": turn}}
        return {"transforms": [made]} if kind.endswith("TFMessage") else made
    pose, unknown = {"position": place, "orientation": turn}, [0.0] * 36
    if kind.endswith("Odometry"):
        still = dict.fromkeys(("linear", "angular"), dict.fromkeys("xyz", 0.0))
        made |= {"child_frame_id": child, "twist": {"twist": still, "covariance": unknown}}
    return made | {"pose": pose if kind.endswith("PoseStamped") else {"pose": pose, "covariance": unknown}}


def in_ros(track):
    """Position and quaternion of each sample, in the axes of ROS."""
    basis = parse_axes("ros").world
    q = track.orientation_xyzw
    return np.hstack([track.position_m @ basis, q[:, :3] @ basis, q[:, 3:]]).tolist()


def each(track):
    """The time and the seven numbers of each sample, in the axes of ROS."""
    return zip(track.time_ns.tolist(), in_ros(track), strict=True)


def ros_bag(path, messages, **how):
    """A recording of ROS 2: each message has its topic, kind, the time it was logged, and parts."""
    with path.open("wb") as stream:
        writer = ROS_WRITER.Writer(stream, **how)
        schemas = {
            kind: writer.register_msgdef(kind, f"\n{'=' * 80}\n".join([text, *_TAIL])) for kind, text in ROS.items()
        }
        for topic, kind, logged_ns, parts in messages:
            writer.write_message(topic, schemas[kind], parts, logged_ns, logged_ns)
        writer.finish()
    return path


def other_bag(path, messages, **how):
    """A recording of anything: topic, name, time, bytes, encoding and schema of each message."""
    with path.open("wb") as stream:
        writer, channels = WRITER.Writer(stream, **how), {}
        writer.start()
        for topic, name, ns, data, encoding, schema in messages:
            if topic not in channels:
                kind = {"cdr": "ros2msg", "json": "jsonschema"}.get(encoding, encoding)
                found = writer.register_schema(name, kind, schema)
                channels[topic] = writer.register_channel(topic, encoding, found)
            writer.add_message(channels[topic], ns, data, ns)
        writer.finish()
    return path


def test_other_tools_find_a_pose_in_frame_in_a_written_file(tmp_path):
    """By the reader of the format's authors: schema, times, and up is z."""
    track = head()
    with save(track.evolve(epoch_ns=EPOCH_NS), tmp_path / "a.mcap", "mcap").open("rb") as stream:
        schema, _, message = list(READER.make_reader(stream, validate_crcs=True).iter_messages())[7]
    said = json.loads(message.data)
    assert schema.name == "foxglove.PoseInFrame" and set(json.loads(schema.data)["properties"]) == set(said)
    assert said["timestamp"] == {"sec": message.log_time // 10**9, "nsec": message.log_time % 10**9}
    assert message.log_time == EPOCH_NS + int(track.time_ns[7])
    assert said["pose"]["position"]["z"] == track.position_m[7, 1]


@pytest.mark.parametrize("kind", ROS)
def test_poses_of_ros_2_are_read_in_the_axes_of_ros(tmp_path, kind):
    track = load_trace("walk").track
    sent = (("/vr/head", kind, EPOCH_NS + ns, message(kind, EPOCH_NS + ns, numbers)) for ns, numbers in each(track))
    loaded = load_trace(ros_bag(tmp_path / "bag.mcap", sent))
    assert same_motion(loaded.track, track)
    assert "by the format" in loaded.axes and "contradict" not in loaded.axes
    assert "= /vr/head" in loaded.columns


@pytest.mark.parametrize("stamped", [True, False])
def test_the_stamp_of_a_message_counts_not_when_it_was_logged(tmp_path, stamped):
    """Unless the messages have none, which is said."""
    kind, track, late = "geometry_msgs/msg/PoseStamped", head(), 1_000_000 if stamped else 0
    sent = (
        ("/head", kind, EPOCH_NS + ns + i % 3 * late, message(kind, (EPOCH_NS + ns) * stamped, numbers))
        for i, (ns, numbers) in enumerate(each(track))
    )
    loaded = load_trace(ros_bag(tmp_path / "bag.mcap", sent))
    assert same_motion(loaded.track, track) and ("stamp-missing" in kinds(loaded)) != stamped


def test_the_head_is_chosen_by_its_name_and_named(tmp_path):
    """Among a robot's topics and frames; static transforms are no head; --device takes another."""
    pose, frames, still = "geometry_msgs/msg/PoseStamped", "tf2_msgs/msg/TFMessage", [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
    long, track = "the_left_hand_of_a_person_with_a_very_long_name", head()
    sent = [("/tf_static", frames, 0, message(frames, 0, still, "head_camera_mount"))]
    for ns, numbers in each(track):
        sent.append(("/arm", pose, ns, message(pose, ns, still)))
        bodies = ((f"{long}_1", still), (f"{long}_2", [5.0, *still[1:]]), ("hmd", numbers))
        sent += [("/tf", frames, ns, message(frames, ns, where, body)) for body, where in bodies]
    path = ros_bag(tmp_path / "bag.mcap", sent)
    loaded = load_trace(path)
    assert same_motion(loaded.track, track)
    assert "= /tf hmd" in loaded.columns and "devices-interleaved" in kinds(loaded)
    other = load_trace(path, TraceOptions(device=f"/tf {long}_2")).track
    np.testing.assert_array_equal(other.position_m, np.tile([0.0, 0.0, -5.0], (len(other), 1)) + [0, 1.0, 0])


def test_a_pose_in_a_moving_frame_is_reported(tmp_path):
    kind, sent = "tf2_msgs/msg/TFMessage", []
    for ns, numbers in each(head()):
        base = [ns * 1e-9, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]
        sent.append(("/tf", kind, ns, message(kind, ns, base, "base", "odom")))
        sent.append(("/tf", kind, ns, message(kind, ns, numbers, "head", "base")))
    loaded = load_trace(ros_bag(tmp_path / "bag.mcap", sent))
    assert "frame 'base', which is itself in frame 'odom'" in str(found(loaded, "frame-nested"))


def test_json_of_foxglove_is_read(tmp_path):
    track, sent = head(), []
    for ns, numbers in each(track):
        one = {
            "timestamp": {"sec": ns // 10**9, "nsec": ns % 10**9}, "parent_frame_id": "world", "child_frame_id": "head",
            "translation": dict(zip("xyz", numbers, strict=False)),
            "rotation": dict(zip("xyzw", numbers[3:], strict=True)),
        }  # fmt: skip
        data = json.dumps({"transforms": [one]}).encode()
        sent.append(("/tf", "foxglove.FrameTransforms", ns, data, "json", b"{}"))
    assert same_motion(load_trace(other_bag(tmp_path / "bag.mcap", sent)).track, track)


def test_protobuf_of_foxglove_is_read(tmp_path):
    """As Foxglove's own SDK writes it."""
    pytest.importorskip("mcap_protobuf", reason="mcap-protobuf-support is not installed (pip install '.[mcap]')")
    from google.protobuf import descriptor_pb2, message_factory

    files = descriptor_pb2.FileDescriptorSet()
    file = files.file.add(name="pose.proto", package="foxglove", syntax="proto3")
    kinds_of = {"double": 1, "int64": 3, "int32": 5, "string": 9}
    fields = {
        "Time": {"seconds": "int64", "nanos": "int32"}, "Vector3": dict.fromkeys("xyz", "double"),
        "Quaternion": dict.fromkeys("xyzw", "double"), "Pose": {"position": "Vector3", "orientation": "Quaternion"},
        "PoseInFrame": {"timestamp": "Time", "frame_id": "string", "pose": "Pose"},
    }  # fmt: skip
    for name, parts in fields.items():
        kind_of_message = file.message_type.add(name=name)
        for number, (part, kind) in enumerate(parts.items(), 1):
            field = kind_of_message.field.add(name=part, number=number, label=1, type=kinds_of.get(kind, 11))
            if kind not in kinds_of:
                field.type_name = f".foxglove.{kind}"
    made = message_factory.GetMessages([file])["foxglove.PoseInFrame"]
    track, sent, schema = head(), [], files.SerializeToString()
    for ns, numbers in each(track):
        pose = message("PoseStamped", ns, numbers)["pose"]
        data = made(timestamp={"seconds": ns // 10**9, "nanos": ns % 10**9}, frame_id="world", pose=pose)
        sent.append(("/head", "foxglove.PoseInFrame", ns, data.SerializeToString(), "protobuf", schema))
    assert same_motion(load_trace(other_bag(tmp_path / "bag.mcap", sent)).track, track)


def test_a_file_that_was_cut_off_is_read_up_to_there(tmp_path):
    """A recorder that crashed left no index, and half a chunk."""
    kind, track = "geometry_msgs/msg/PoseStamped", head()
    sent = (("/head", kind, ns, message(kind, ns, numbers)) for ns, numbers in each(track))
    raw = ros_bag(tmp_path / "bag.mcap", sent, chunk_size=4096).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(raw[: len(raw) // 2])
    loaded = load_trace(cut)
    n = len(loaded.track)
    assert "file-cut" in kinds(loaded) and 20 < n < len(track)
    np.testing.assert_allclose(loaded.track.position_m, track.position_m[:n], atol=1e-12)


def test_damage_is_refused(tmp_path):
    path = save(head(), tmp_path / "a.mcap", "mcap")
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 3] ^= 0xFF
    path.write_bytes(raw)
    with pytest.raises(TraceError, match=r"a\.mcap.*damaged.*copy or record it again"):
        load_trace(path)


def test_a_file_without_poses_is_refused_with_what_it_holds(tmp_path):
    sent = [("/imu", "sensor_msgs/msg/Imu", 0, b"\0" * 8, "cdr", b"float64 x")]
    sent.append(("/old", "geometry_msgs/PoseStamped", 0, b"\0" * 8, "ros1", b"x"))
    with pytest.raises(TraceError, match=r"/imu \(sensor_msgs/Imu, cdr\), /old \(geometry_msgs/PoseStamped, ros1\)"):
        load_trace(other_bag(tmp_path / "bag.mcap", sent))


def test_a_chunk_that_unpacks_to_more_than_it_may_is_refused(tmp_path):
    sent = [("/head", "geometry_msgs/msg/PoseStamped", 0, bytes(17 << 20), "cdr", b"float64 x")]
    path = other_bag(tmp_path / "bag.mcap", sent, chunk_size=1 << 26)
    with pytest.raises(TraceError, match="more than 16777216 bytes, unpacked"):
        load_trace(path)
