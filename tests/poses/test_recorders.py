"""Head traces in bags of ROS and in COLMAP's images.txt."""

from __future__ import annotations

import numpy as np
import pytest
from recorded_folders import taken, write_colmap
from ros_bags import BEGINS_NS, FIRST_TF, HAS_ROSBAGS, Messages, logged, write_bag

from hmdwarp.base import TraceError
from hmdwarp.poses import TraceOptions, load_trace
from hmdwarp.poses.assumptions import By

from .traces import found, head, kinds, matrices, same_motion

needs_rosbags = pytest.mark.skipif(not HAS_ROSBAGS, reason="rosbags is not installed (pip install '.[bags]')")
FRAMES = taken(6)


def bag(folder, version: int, ending: str, motion: str):
    messages = Messages(version)
    write_bag(folder, ending, logged(messages, FRAMES, motion), messages)
    return next(folder.glob(f"*{ending}"))


@needs_rosbags
@pytest.mark.parametrize(("version", "ending"), [(1, ".bag"), (2, ".db3"), (2, ".mcap")])
@pytest.mark.parametrize("motion", ["tf", "odometry"])
def test_a_bag_is_a_head_trace(version, ending, motion, tmp_path):
    """The robot's frame, whose camera looks along its x, 0.1 m ahead, 0.02 left and 0.3 up."""
    loaded = load_trace(bag(tmp_path, version, ending, motion))
    assert (loaded.format, loaded.track.epoch_ns) == ("rosbag", BEGINS_NS)
    assert [int(time_ns) for time_ns in loaded.track.time_ns] == [frame.time_ns for frame in FRAMES]
    for robot, frame in zip(map(loaded.track.pose, range(6)), FRAMES, strict=True):
        assert np.allclose(robot.rotation_matrix, frame.pose.rotation_matrix, atol=1e-9)
        camera = robot.position_m + robot.rotation_matrix @ (-0.02, 0.3, -0.1)
        assert np.allclose(camera, frame.pose.position_m, atol=1e-9)
    assert next(entry.by for entry in loaded.assumptions if entry.what == "axes") is By.FORMAT


@needs_rosbags
def test_transforms_of_the_first_tf_are_read(tmp_path):
    """As old bags of ROS 1 have them, those of TUM RGB-D among them."""
    messages = Messages(1)
    rows = ((topic, FIRST_TF if "tf" in topic else kind, *rest) for topic, kind, *rest in logged(messages, FRAMES))
    write_bag(tmp_path, ".bag", rows, messages)
    track = load_trace(tmp_path / "taken.bag").track
    assert len(track) == 6 and np.allclose(track.pose(5).rotation_matrix, FRAMES[5].pose.rotation_matrix, atol=1e-9)


def posed(folder, sent, stamped: bool = True):
    """A recording of ROS 2 in MCAP: topic, child frame or "", parent, ns, matrix of each pose."""
    messages = Messages(2)
    rows = []
    for topic, child, parent, ns, matrix in sent:
        if child:
            message, kind = messages.transform(ns, parent, child, matrix), "tf2_msgs/TFMessage"
        else:
            head, kind = messages.header(ns * stamped, parent), "geometry_msgs/PoseStamped"
            message = messages.of(kind, header=head, pose=messages.pose(matrix))
        rows.append((topic, kind, BEGINS_NS + ns, message))
    write_bag(folder, ".mcap", rows, messages)
    return next(folder.glob("**/*.mcap"))


def in_ros(track):
    """Time and matrix of each pose of a track in the axes of ROS: x ahead, y left, z up."""
    basis = np.array([[0, 0, -1.0, 0], [-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])
    return list(zip(track.time_ns.tolist(), basis @ matrices(track) @ basis.T, strict=True))


@needs_rosbags
@pytest.mark.parametrize("stamped", [True, False])
def test_the_head_is_chosen_by_its_name_and_its_own_stamps_count(tmp_path, stamped):
    """Among a robot's topics; static transforms are no head; --device takes another."""
    track, still = head(40), np.eye(4)
    sent = [("/tf_static", "mount", "map", 0, still)]
    for i, (ns, matrix) in enumerate(in_ros(track)):
        sent += [("/left_hand", "", "map", ns, still), ("/arm", "", "map", ns, still)]
        sent += [("/vr/head", "", "map", ns + 1 + i, matrix)]
    path = posed(tmp_path, sent, stamped)
    loaded = load_trace(path)
    assert "= /vr/head" in loaded.columns and ("stamp-missing" in kinds(loaded)) != stamped
    assert "devices-interleaved" in kinds(loaded) and "by the format" in loaded.axes
    assert same_motion(loaded.track.evolve(time_ns=track.time_ns), track, atol=1e-9)
    assert loaded.track.epoch_ns == 1 + BEGINS_NS * (not stamped)
    assert not load_trace(path, TraceOptions(device="/arm")).track.position_m.any()


@needs_rosbags
def test_a_pose_in_a_moving_frame_is_reported(tmp_path):
    frames = ("base", "odom"), ("head", "base")
    sent = [("/tf", *names, ns, matrix) for ns, matrix in in_ros(head(40)) for names in frames]
    loaded = load_trace(posed(tmp_path, sent))
    assert "frame 'base', which is itself in frame 'odom'" in str(found(loaded, "frame-nested"))


@needs_rosbags
def test_a_bag_without_poses_says_what_it_holds(tmp_path):
    messages = Messages(2)
    write_bag(tmp_path, ".db3", (row for row in logged(messages, FRAMES) if "tf" not in row[0]), messages)
    with pytest.raises(TraceError, match="is a bag without poses that can be read; it holds /camera/color/camera_info"):
        load_trace(next(tmp_path.glob("*.db3")))


@needs_rosbags
@pytest.mark.parametrize("magic", [b"#ROSBAG V2.0\n", b"SQLite format 3\x00", b"\x89MCAP0\r\n"])
def test_a_damaged_bag_is_refused_in_one_line(magic, tmp_path):
    path = tmp_path / "taken.bag"
    path.write_bytes(magic + b"cut off")
    with pytest.raises(TraceError, match="cannot be read as a bag") as caught:
        load_trace(path)
    assert "\n" not in str(caught.value)


def test_images_of_colmap_are_inverted_in_the_order_of_their_names(tmp_path):
    """A model has no clock; its world is that of the first camera here."""
    write_colmap(tmp_path, FRAMES)
    path = tmp_path / "sparse/0/images.txt"
    with pytest.raises(TraceError, match="has no time .*--trace-rate"):
        load_trace(path)
    loaded = load_trace(path, TraceOptions(rate=30.0))
    assert loaded.format == "colmap"
    for pose, frame in zip(map(loaded.track.pose, range(6)), FRAMES, strict=True):
        assert pose.isclose(frame.pose, 1e-9)
    said = {entry.what: entry.by for entry in loaded.assumptions}
    assert (said["pose"], said["axes"], said["length"]) == (By.FORMAT, By.FORMAT, By.DEFAULT)


def test_a_broken_line_of_colmap_is_named(tmp_path):
    write_colmap(tmp_path, FRAMES)
    path = tmp_path / "sparse/0/images.txt"
    path.write_text(path.read_text().replace(" 1 0003.png", " x 0003.png"))
    with pytest.raises(TraceError, match=r"images.txt, line 6: .*expected IMAGE_ID QW QX QY QZ"):
        load_trace(path, TraceOptions(rate=30.0))
