"""Bags of ROS for tests: colour, depth, camera and motion, as drivers log them."""

from __future__ import annotations

import importlib.util
import io
import shutil
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from recorded_folders import CX, CY, FX, FY, HAS_EXR, LAYOUTS, OPTICAL, ROBOT, Form, Taken, camera_matrix, ros
from scipy.spatial.transform import Rotation

HAS_ROSBAGS = importlib.util.find_spec("rosbags") is not None
FRAME, BEGINS_NS = "camera_color_optical_frame", 1_700_000_000_123_456_789
FIRST_TF = "tf/tfMessage"  # before tf2
DEPTH_LATE_NS = 4_000_000
Logged = tuple[str, str, int, Any]  # topic, type, ns, message


class Messages:
    """Messages of one ROS."""

    def __init__(self, ros_version: int) -> None:
        from rosbags.typesys import Stores, get_types_from_msg, get_typestore

        self.version = ros_version
        self.store = get_typestore(Stores.ROS1_NOETIC if ros_version == 1 else Stores.ROS2_HUMBLE)
        if ros_version == 1:  # rosbags has it of ROS 2 alone
            for name in ("tf2_msgs/msg/TFMessage", FIRST_TF.replace("/", "/msg/")):
                self.store.register(get_types_from_msg("geometry_msgs/TransformStamped[] transforms", name))

    def of(self, kind: str, **parts: Any) -> Any:
        """Return a message."""
        return self.store.types[kind.replace("/", "/msg/")](**parts)

    def header(self, time_ns: int, frame: str) -> Any:
        """Return the header of a message."""
        stamp = self.of("builtin_interfaces/Time", sec=time_ns // 10**9, nanosec=time_ns % 10**9)
        return self.of("std_msgs/Header", stamp=stamp, frame_id=frame, **({"seq": 0} if self.version == 1 else {}))

    def image(self, time_ns: int, pixels: np.ndarray, encoding: str, frame: str = FRAME, pad: int = 0) -> Any:
        """Return a raw picture. pad: bytes at the end of each row."""
        high, wide = pixels.shape[:2]
        rows = np.ascontiguousarray(pixels).view(np.uint8).reshape(high, -1)
        rows = np.pad(rows, ((0, 0), (0, pad)))
        parts = {"height": high, "width": wide, "is_bigendian": 0, "step": rows.shape[1], "data": rows.ravel()}
        return self.of("sensor_msgs/Image", header=self.header(time_ns, frame), encoding=encoding, **parts)

    def compressed(self, time_ns: int, form: str, data: bytes) -> Any:
        """Return a compressed picture."""
        head = self.header(time_ns, FRAME)
        return self.of("sensor_msgs/CompressedImage", header=head, format=form, data=np.frombuffer(data, np.uint8))

    def info(self, time_ns: int, size: tuple[int, int], distortion: float = 0.0) -> Any:
        """Return what a camera says of itself."""
        k = np.array([FX, 0, CX, 0, FY, CY, 0, 0, 1.0])
        p = np.array([FX, 0, CX, 0, 0, FY, CY, 0, 0, 0, 1.0, 0])
        named = {"d": np.array([distortion, 0, 0, 0, 0]), "k": k, "r": np.eye(3).ravel(), "p": p}
        named = {name.upper(): value for name, value in named.items()} if self.version == 1 else named
        roi = {"x_offset": 0, "y_offset": 0, "height": 0, "width": 0, "do_rectify": False}
        roi = self.of("sensor_msgs/RegionOfInterest", **roi)
        parts = {"width": size[0], "height": size[1], "distortion_model": "plumb_bob", "binning_x": 0, "binning_y": 0}
        return self.of("sensor_msgs/CameraInfo", header=self.header(time_ns, FRAME), roi=roi, **parts, **named)

    def pose(self, matrix: np.ndarray) -> Any:
        """Return a pose."""
        x, y, z, w = Rotation.from_matrix(matrix[:3, :3]).as_quat()
        place = self.of("geometry_msgs/Point", **dict(zip("xyz", matrix[:3, 3], strict=True)))
        turn = self.of("geometry_msgs/Quaternion", x=x, y=y, z=z, w=w)
        return self.of("geometry_msgs/Pose", position=place, orientation=turn)

    def transform(self, time_ns: int, parent: str, child: str, matrix: np.ndarray) -> Any:
        """Return a message of one transform."""
        pose = self.pose(matrix)
        place = self.of("geometry_msgs/Vector3", x=pose.position.x, y=pose.position.y, z=pose.position.z)
        moved = self.of("geometry_msgs/Transform", translation=place, rotation=pose.orientation)
        one = self.of(
            "geometry_msgs/TransformStamped", header=self.header(time_ns, parent), child_frame_id=child, transform=moved
        )
        return self.of("tf2_msgs/TFMessage", transforms=[one])

    def odometry(self, time_ns: int, child: str, matrix: np.ndarray) -> Any:
        """Return odometry of a frame."""
        zero = self.of("geometry_msgs/Vector3", x=0.0, y=0.0, z=0.0)
        pose = self.of("geometry_msgs/PoseWithCovariance", pose=self.pose(matrix), covariance=np.zeros(36))
        twist = self.of("geometry_msgs/Twist", linear=zero, angular=zero)
        twist = self.of("geometry_msgs/TwistWithCovariance", twist=twist, covariance=np.zeros(36))
        head = self.header(time_ns, "odom")
        return self.of("nav_msgs/Odometry", header=head, child_frame_id=child, pose=pose, twist=twist)


def robot_from_world(one: Taken) -> np.ndarray:
    """Return the robot's pose in a world of ROS, whose camera took this."""
    return camera_matrix(one, OPTICAL, ros) @ np.linalg.inv(np.vstack([ROBOT, [0, 0, 0, 1]]))


def logged(messages: Messages, frames: list[Taken], motion: str = "tf", packed: bool = False) -> Iterator[Logged]:
    """Yield what a driver logs. motion: tf or odometry. packed: pictures as PNG."""
    local = np.vstack([ROBOT, [0, 0, 0, 1]])
    yield "/tf_static", "tf2_msgs/TFMessage", BEGINS_NS, messages.transform(0, "base_link", FRAME, local)
    for frame in frames:
        at = BEGINS_NS + frame.time_ns
        late = at + DEPTH_LATE_NS
        pose = robot_from_world(frame)
        if motion == "tf":
            yield "/tf", "tf2_msgs/TFMessage", at, messages.transform(at, "map", "base_link", pose)
        else:
            yield "/odom", "nav_msgs/Odometry", at, messages.odometry(at, "base_link", pose)
        size = frame.colour.shape[1::-1]
        yield "/camera/color/camera_info", "sensor_msgs/CameraInfo", at, messages.info(at, size)
        millimetres = np.rint(frame.depth_m * 1000).astype(np.uint16)
        if packed:
            yield (
                "/camera/color/image_raw/compressed",
                *_packed(messages, at, "rgb8; png compressed bgr8", frame.colour),
            )
            yield (
                "/camera/aligned_depth_to_color/image_raw/compressedDepth",
                *_packed(messages, late, "16UC1; compressedDepth png", millimetres, b"\0" * 12),
            )
            continue
        image = messages.image(at, frame.colour[..., ::-1], "bgr8", pad=3)
        yield "/camera/color/image_raw", "sensor_msgs/Image", at, image
        image = messages.image(late, millimetres, "16UC1")
        yield "/camera/aligned_depth_to_color/image_raw", "sensor_msgs/Image", late, image


def _packed(messages: Messages, time_ns: int, form: str, pixels: np.ndarray, head: bytes = b"") -> tuple[Any, ...]:
    stream = io.BytesIO(head)
    stream.seek(len(head))
    Image.fromarray(pixels).save(stream, "PNG")
    return "sensor_msgs/CompressedImage", time_ns, messages.compressed(time_ns, form, stream.getvalue())


def write_bag(folder: Path, kind: str, rows: Iterable[Logged], messages: Messages, packed: Sequence[str] = ()) -> None:
    """Write .bag, .db3 or .mcap into a folder. packed: compression, its mode first for ROS 2."""
    from rosbags import rosbag1, rosbag2

    if kind == ".bag":
        writer: Any = rosbag1.Writer(folder / "taken.bag")
        pack = messages.store.serialize_ros1
    else:
        plugin = rosbag2.StoragePlugin.MCAP if kind == ".mcap" else rosbag2.StoragePlugin.SQLITE3
        writer = rosbag2.Writer(folder / "made", version=9, storage_plugin=plugin)
        pack = messages.store.serialize_cdr
    if packed:
        names = (
            (rosbag2.CompressionMode, rosbag2.CompressionFormat) if packed[1:] else (rosbag1.Writer.CompressionFormat,)
        )
        writer.set_compression(*(kinds[name] for kinds, name in zip(names, packed, strict=True)))
    with writer:
        connections: dict[str, Any] = {}
        for topic, msgtype, time_ns, message in rows:
            full = msgtype.replace("/", "/msg/")
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, full, typestore=messages.store)
            writer.write(connections[topic], time_ns, pack(message, full))
    if kind != ".bag":
        for file in (folder / "made").iterdir():
            shutil.move(file, folder / file.name)
        (folder / "made").rmdir()


def write_ros1(folder: Path, frames: list[Taken], **how: Any) -> None:
    """Write a .bag."""
    messages = Messages(1)
    write_bag(folder, ".bag", logged(messages, frames, **how), messages)


def write_ros2(folder: Path, frames: list[Taken], kind: str = ".db3", **how: Any) -> None:
    """Write the folder of a bag of ROS 2."""
    messages = Messages(2)
    write_bag(folder, kind, logged(messages, frames, **how), messages)


BAGS = {
    "ros1": Form("rosbag", write_ros1),
    "ros1_packed": Form("rosbag", partial(write_ros1, packed=True)),
    "ros2_db3": Form("rosbag", write_ros2),
    "ros2_mcap": Form("rosbag", partial(write_ros2, kind=".mcap")),
    "ros2_odometry": Form("rosbag", partial(write_ros2, motion="odometry")),
}
# Every layout by name, as readers must recognise it.
FORMS = LAYOUTS | BAGS


def form_of(name: str) -> Form:
    """Return that layout; skip the test where the library that writes it is not installed."""
    if name == "exr" and not HAS_EXR:
        pytest.skip("OpenEXR is not installed (pip install '.[exr]')")
    if name in BAGS and not HAS_ROSBAGS:
        pytest.skip("rosbags is not installed (pip install '.[bags]')")
    return FORMS[name]
