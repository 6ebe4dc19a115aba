"""Bags of ROS: which topics are taken, in which frame the camera is, and what is refused."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from recorded_folders import taken
from ros_bags import HAS_ROSBAGS, Logged, Messages, logged, write_bag, write_ros2

from hmdwarp.poses import load_trace
from hmdwarp.poses.assumptions import By
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import SequenceOptions

from .folders import fact, refused

pytestmark = pytest.mark.skipif(not HAS_ROSBAGS, reason="rosbags is not installed (pip install '.[bags]')")
COLOUR, DEPTH = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"


Change = Callable[[Messages, Logged], Iterator[Logged]]


def changed(folder: Path, change: Change, motion: str = "tf") -> Path:
    """A bag of ROS 2 whose messages are changed one by one."""
    messages = Messages(2)
    rows = (new for row in logged(messages, taken(3), motion) for new in change(messages, row))
    write_bag(folder, ".db3", rows, messages)
    return folder


def without(*topics: str) -> Change:
    return lambda _, row: iter([] if row[0] in topics else [row])


def with_other(topic: str, make: Callable[[Messages, int], object]) -> Change:
    """Change the messages of topics that end so. make(messages, stamp)."""
    return lambda messages, row: iter([(*row[:3], make(messages, row[2])) if row[0].endswith(topic) else row])


def test_one_file_of_several_is_told(tmp_path):
    """A recorder begins a new file after so many bytes; alone it is a part of frames and poses."""
    write_ros2(tmp_path, taken(2))
    file, metadata = next(tmp_path.glob("*.db3")), tmp_path / "metadata.yaml"
    text = metadata.read_text()
    metadata.write_text(text.replace(f"  - {file.name}\n", f"  - {file.name}\n  - taken_1.db3\n"))
    assert metadata.read_text() != text
    said = f"{file.name} is one of the 2 files of its recording"
    assert any(note.startswith(said) for note in sequences.open(file).notes)
    assert any(said in str(defect) for defect in load_trace(file).defects)


def test_of_several_cameras_the_user_names_one(tmp_path):
    def second(messages: Messages, row: Logged) -> Iterator[Logged]:
        yield row
        if row[0] == COLOUR:
            yield "/other/image_raw", row[1], row[2], messages.image(row[2], np.zeros((24, 36, 3), np.uint8), "rgb8")

    changed(tmp_path, second)
    refused(tmp_path, f"several topics of colour ({COLOUR}, /other/image_raw)", "--frames-topics")
    sequence = sequences.open(tmp_path, SequenceOptions(frames_topics="colour=/other/image_raw"))
    assert not sequence.frames[0].colour.any() and fact(sequence, "topics")[1] is By.USER
    refused(tmp_path, "no topic '/third'", COLOUR, options=SequenceOptions(frames_topics="colour=/third"))
    refused(tmp_path, "expected colour=TOPIC", options=SequenceOptions(frames_topics="left=/other"))


GREY, STEPS, METRES = np.zeros((24, 36), np.uint8), np.ones((24, 36), np.uint16), np.full((24, 36), 2.5, np.float32)
BAYER = with_other(COLOUR, lambda messages, stamp: messages.image(stamp, GREY, "bayer_rggb8"))
DISTORTED = with_other("camera_info", lambda messages, stamp: messages.info(stamp, (36, 24), 0.1))
MOVED = with_other(DEPTH, lambda messages, stamp: messages.image(stamp, STEPS, "16UC1", "depth_frame"))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (MOVED, (f"{DEPTH} is in frame 'depth_frame'", "registered")),
        (DISTORTED, ("distortion[0] is 0.1", "undistort")),
        (BAYER, ("no topic of colour", f"{COLOUR} (unknown)")),  # pictures of an unknown encoding are no colour
        (without(COLOUR), ("no topic of colour", DEPTH)),
        (without(DEPTH), ("no topic of depth", COLOUR)),
        (without("/tf"), ("no topic of pose", COLOUR)),
    ],
)
def test_what_a_bag_cannot_be_is_refused_with_what_it_holds(change, words, tmp_path):
    refused(changed(tmp_path, change), *words)


def test_an_encoding_that_is_not_known_is_named(tmp_path):
    refused(changed(tmp_path, BAYER), "bayer_rggb8", options=SequenceOptions(frames_topics=f"colour={COLOUR}"))


def test_depth_of_floats_is_in_metres(tmp_path):
    METRES[0, 0] = np.nan
    floats = with_other(DEPTH, lambda messages, stamp: messages.image(stamp, METRES, "32FC1"))
    sequence = sequences.open(changed(tmp_path, floats))
    depth_m = sequence.frames[0].depth_m
    assert depth_m[5, 5] == 2.5 and not depth_m[0, 0] > 0
    assert fact(sequence, "depth scale") == ("1 m per unit", By.FORMAT)


def test_a_picture_that_is_rectified_has_no_distortion_left(tmp_path):
    def rectified(messages: Messages, row: Logged) -> Iterator[Logged]:
        for topic, *rest in DISTORTED(messages, row):
            yield topic.replace("color/image_raw", "color/image_rect_color"), *rest

    assert len(sequences.open(changed(tmp_path, rectified)).frames) == 3


@pytest.mark.parametrize("topic", [DEPTH, "/tf", "/odom"])
def test_clocks_that_are_apart_are_told_with_how_far(topic, tmp_path):
    """One topic is stamped by a clock that began an hour later."""

    def ahead(_: Messages, row: Logged) -> Iterator[Logged]:
        message = row[3]
        for header in [each.header for each in getattr(message, "transforms", [message])] if row[0] == topic else ():
            header.stamp.sec += 3600
        yield row

    changed(tmp_path, ahead, "odometry" if topic == "/odom" else "tf")
    refused(tmp_path, "the clocks are 3599.9", f"{COLOUR}: 17000", f"{topic}", "expected one clock")


@pytest.mark.parametrize("ending", [".bag", ".db3", ".mcap"])
def test_what_is_no_bag_is_refused_in_one_line(ending, tmp_path):
    (tmp_path / f"taken{ending}").write_bytes(b"no bag at all" * 20)
    refused(tmp_path / f"taken{ending}", f"taken{ending}: cannot be read as a bag")
    (tmp_path / "two.bag").write_bytes(b"")
    (tmp_path / "one.bag").write_bytes(b"")
    refused(tmp_path, "no bag, or several", options=SequenceOptions(layout="rosbag"))
