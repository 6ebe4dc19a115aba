"""Recorded frames of every layout and bags of ROS: what holds for all, and what is refused in one
line."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import attrs
import numpy as np
import pytest
from PIL import Image
from recorded_folders import AS_TUM, LAYOUTS, MILLIMETRES, MIRRORED, REAL, REAL_CAMERAS, SIZE, STATED, fov_of, taken
from ros_bags import FORMS, Logged, Messages, form_of, logged, write_bag, write_ros2

from hmdwarp import WarpMap
from hmdwarp.base import InputError, UnknownNameError
from hmdwarp.poses import Origin, load_trace
from hmdwarp.poses.assumptions import By
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import FACTS, RecordedFrame, SequenceOptions, depth_notes, parse_intrinsics, readers

from .folders import edited, fact, made, refused

DEPTH_WITHIN_M = 0.5e-3 + 1e-6  # Half a step of 16 bits in millimetres, the coarsest unit


@pytest.fixture(params=FORMS)
def layout(request):
    return form_of(request.param)


@pytest.fixture
def folder(tmp_path):
    """A folder whose parent belongs to the same test."""
    (tmp_path / "taken").mkdir()
    return tmp_path / "taken"


def test_every_reader_is_tried():
    assert {form.reader for form in FORMS.values()} == set(readers.names())


@pytest.mark.parametrize("reader", list(readers), ids=lambda reader: reader.name)
def test_every_layout_says_what_it_assumes(reader):
    assert [assume.what for assume in reader.assumes if assume.what in FACTS] == list(FACTS)
    assert all(assume.value and isinstance(assume.by, By) for assume in reader.assumes)


def test_every_layout_gives_the_frames_that_were_taken(layout, folder):
    """Poses and fields of view within the digits of their files (12), depth within half a unit."""
    frames = taken(4)
    layout.write(folder, frames)
    sequence = sequences.open(folder, layout.options)
    assert (sequence.layout, sequence.name, len(sequence.frames)) == (layout.reader, folder.name, 4)
    assert sequence.rate_hz == pytest.approx(30, abs=1e-6)
    expected = fov_of()
    for found, one in zip(sequence.frames, frames, strict=True):
        assert found.pose.isclose(one.pose, 1e-9)
        assert attrs.astuple(found.fov)[:4] == pytest.approx(attrs.astuple(expected)[:4], abs=1e-9)
        assert found.view.pose is found.pose and found.view.fov is found.fov and found.time_ns == one.time_ns
        at = sequence.track.at(found.time_ns)
        assert at.origin is Origin.MEASURED and at.pose.isclose(found.pose, 0)
        assert found.size == SIZE
        colour, depth_m = found.read()
        assert colour.dtype == np.uint8
        assert np.abs(colour.astype(int) - one.colour).max() <= layout.colour_within
        assert depth_m.dtype == np.float32 and np.abs(depth_m - one.depth_m).max() <= DEPTH_WITHIN_M
        assert depth_m[0, 0] == 0
    assert [*sequence] == [*sequence.frames] and "4 frames" in repr(sequence) and sequence[-1] is sequence.frames[3]


def test_every_recording_says_who_states_each_fact(layout, folder):
    """Each fact is one entry; what an option states is the user's, and the others are not."""
    layout.write(folder, taken(2))
    found, options = sequences.open(folder, layout.options), layout.options
    by = {assumption.what: assumption.by for assumption in found.assumptions}
    assert set(FACTS) | {"camera axes"} <= by.keys() and len(by) == len(found.assumptions)
    assert (by["intrinsics"] is By.USER) == (options.intrinsics is not None)
    assert (by["depth scale"] is By.USER) == (options.depth_scale is not None)
    assert (by["frame clock"] is By.USER) == (options.frames_rate_hz is not None) and by["no depth"] is not By.USER
    stated = sequences.open(folder, attrs.evolve(options, frames_rate_hz=12.0, no_depth="far"))
    (clock,) = [one for one in found.assumptions if one.what == "frame clock"]
    assert fact(stated, "no depth")[1] is By.USER
    assert fact(stated, "frame clock")[1] is By.USER or "rate" not in clock.option


def test_cropping_leaves_every_pixel_where_it_was_seen(layout, folder):
    layout.write(folder, taken(2))
    whole, inner = (sequences.open(folder, attrs.evolve(layout.options, crop=crop)) for crop in (0, 3))
    for one, other in zip(whole.frames, inner.frames, strict=True):
        assert other.size == (one.size[0] - 6, one.size[1] - 6) and other.pose.isclose(one.pose, 0)
        for before, after in zip(one.read(), other.read(), strict=True):
            assert np.array_equal(before[3:-3, 3:-3], after)
        left, right, down, up = one.fov.tangents
        x, y = (right - left) / one.size[0], (up - down) / one.size[1]
        assert other.fov.tangents == pytest.approx((left + 3 * x, right - 3 * x, down + 3 * y, up - 3 * y), abs=1e-12)
    assert inner.notes == (*whole.notes, "The 3 outermost pixels of each picture are left out.")


def test_texts_with_a_mark_and_lines_of_windows_are_read_alike(layout, folder):
    layout.write(folder, taken(3))
    plain = sequences.open(folder, layout.options)
    for path in folder.parent.rglob("*"):
        if path.suffix in (".txt", ".json", ".freiburg", ".log", ".csv"):
            path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    again = sequences.open(folder, layout.options)
    assert (again.layout, len(again.frames)) == (layout.reader, 3)
    for one, other in zip(again.frames, plain.frames, strict=True):
        assert one.time_ns == other.time_ns and one.pose.isclose(other.pose, 0)


@pytest.mark.parametrize("form", [name for name in LAYOUTS if LAYOUTS[name].reader != "folder"])
def test_a_layout_by_name_refuses_an_empty_folder(form, tmp_path):
    with pytest.raises(InputError, match="expected|no such file|cannot be read") as caught:
        sequences.open(tmp_path, attrs.evolve(LAYOUTS[form].options, layout=LAYOUTS[form].reader))
    assert "\n" not in str(caught.value)


def test_a_crop_leaves_some_pixels(tmp_path):
    made(tmp_path, "npz")
    most = (min(SIZE) - 1) // 2
    assert min(sequences.open(tmp_path, SequenceOptions(crop=most)).frames[0].size) in (1, 2)
    with pytest.raises(InputError, match=f"--crop {most + 1}: .* has {SIZE[0]}x{SIZE[1]} pixels; expected to leave"):
        sequences.open(tmp_path, SequenceOptions(crop=most + 1))


def agreeing(first: RecordedFrame, second: RecordedFrame) -> float:
    """Share of the first's pixels seen in the second that have the same depth there, within 2 %. By
    the warp map, in pixels from the bottom left. What the second hides by something nearer is left
    out."""
    (wide, high), depths = first.size, [np.flipud(frame.depth_m).astype(float) for frame in (first, second)]
    y, x = np.nonzero(depths[0] > 0)
    warp = WarpMap.between(first.view, first.size, second.view, second.size)
    pixels, inverse, _ = warp.apply(np.stack([x + 0.5, y + 0.5], axis=1), 1 / depths[0][y, x])
    inside = (pixels >= 0).all(axis=1) & (pixels < (wide, high)).all(axis=1)
    column, row = pixels[inside].astype(int).T
    nearer = depths[1][row, column] * inverse[inside]
    return float((np.abs(nearer[nearer > 0.98] - 1) < 0.02).mean())


@pytest.mark.parametrize("name", REAL_CAMERAS)
def test_real_frames_agree_with_each_other_and_have_no_sky(name):
    """A share that only the right axes, unit and inverse give: the wrong inverse gives 2 to 6 %."""
    if not (REAL / name).is_dir():
        pytest.skip(f"no real frames: {REAL / name} is absent (they are not shipped)")
    intrinsics, scale, share = REAL_CAMERAS[name]
    sequence = sequences.open(REAL / name, SequenceOptions(intrinsics=parse_intrinsics(intrinsics), depth_scale=scale))
    assert len(sequence.frames) == 5 and depth_notes(sequence) == []
    assert agreeing(*sequence.frames[3:]) > share


# A form, a file of it, what takes its place (None: it is gone), and words of the error.
STRAY = "timestamp, frame, x, y, z, qx, qy, qz, qw\n"
CAMERA = {"intrinsics": [40, 40, 18, 12], "depth_scale": 0.001}
SKEWED = [[40, 0.5, 18], [0, 42, 12], [0, 0, 1]]
TWO_SCALES = {"integer_depth_scale": 0.002, "depth_unit_scale_factor": 0.001}


def grown(data: dict) -> None:
    extrinsic = data["parameters"][1]["extrinsic"]
    extrinsic[:12] = [2 * x for x in extrinsic[:12]]


def doubled(text: str) -> str:
    return "\n".join([text.splitlines()[0], "2 0 0 0", *text.splitlines()[2:]])


def renamed(data: dict) -> None:
    for one in data["frames"]:
        one["depth_map_name"] = one.pop("depth_file_path")


def turned_over(data: dict) -> None:
    data["frames"][1]["transform_matrix"] = np.array(data["frames"][1]["transform_matrix"]).T.tolist()


WRONG = [
    ("seven_scenes", "frame-000001.pose.txt", "1 0 0 0\n0 1 x 0\n", "pose.txt, line 2", "expected 4 numbers"),
    ("seven_scenes", "frame-000001.pose.txt", "1 0 0 0\n", "pose.txt", "1 lines; expected a matrix"),
    ("seven_scenes", "frame-000001.color.png", "no picture", "color.png", "not a picture"),
    ("twelve_scenes", "../info.txt", "m_calibrationColorIntrinsic = 1 2\n", "info.txt: m_depthShift is missing"),
    ("twelve_scenes", "../info.txt", "m_depthShift = 1\nm_calibrationColorIntrinsic = 1 2", "Intrinsic is 1 2;"),
    ("three_r_scan", "_info.txt", None, "intrinsics are for 640x480 pixels", "--intrinsics"),
    ("three_d_match", "../camera-intrinsics.txt", "1 0 0\n", "camera-intrinsics.txt", "3 lines of 3 numbers"),
    ("scannet", "intrinsic/intrinsic_color.txt", "1 2 3\n", "intrinsic_color.txt", "expected a matrix"),
    ("scannet", "intrinsic/extrinsic_depth.txt", "1 0 0 .1\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", "extrinsic_depth", "unit"),
    ("replica", "traj.txt", "1 0 0\n", "1 poses, and a picture frame000002.jpg"),
    ("replica", "traj.txt", "\n".join(["1 0 0"] * 3), "traj.txt, line 1", "expected 16 finite numbers"),
    ("replica", "../cam_params.json", '{"camera": {"w": 36}}', "cam_params.json: h is None"),
    ("tartanair", "pose_left.txt", "\n".join(["0 0 0 0 0 0"] * 3), "pose_left.txt, line 1", "7 finite numbers"),
    ("tartanair", "pose_left.txt", "0 0 0 0 0 0 1\n", "1 poses, and a picture 2"),
    ("stray_scanner", "odometry.csv", "x, y, z\n1, 2, 3\n", "odometry.csv, line 1", "the header timestamp, frame"),
    ("stray_scanner", "odometry.csv", STRAY + "1.0, 000000, 1, 2\n", "odometry.csv, line 2", "9 finite numbers"),
    ("stray_scanner", "odometry.csv", STRAY + "1.0, 000000, 0, 0, 0, 0, 0, 0, 2\n", "line 2", "quaternion of length 2"),
    ("stray_scanner", "rgb.mp4", "no video", "rgb.mp4", "not a video"),
    ("stray_scanner", "camera_matrix.csv", None, "camera_matrix.csv", "no such file"),
    ("rtabmap", "map_camera_poses.txt", "1.0 0 0 0 0 0 0 1\n", "poses.txt, line 1", "--poses_format 11"),
    ("rtabmap", "map_calib/8.yaml", None, "8.yaml", "expected the calibration of its image"),
    ("rtabmap", "map_calib/8.yaml", "image_width: 36\n", "8.yaml", "camera_matrix of 9 numbers"),
    ("open3d", "camera_trajectory.json", '{"class_name": "PinholeCameraTrajectory"}', "no list of parameters"),
    ("open3d", "color/00002.png", None, "3 parameters for 2 pictures"),
    ("open3d_scaled", "camera_trajectory.json", grown, "more than turn and move", "where all have the same"),
    ("colmap", "sparse/0/images.txt", "1 1 0 0 0 0 0\n", "images.txt, line 1", "IMAGE_ID QW QX QY QZ"),
    ("colmap", "sparse/0/images.txt", "1 2 0 0 0 0 0 0 1 0000.png\n", "images.txt, line 1", "quaternion of length"),
    ("colmap", "sparse/0/cameras.txt", "2 PINHOLE 36 24 1 1 1 1\n", "name camera 1"),
    ("colmap", "sparse/0/cameras.txt", "1 PINHOLE 36 24 1 1 1\n", "line 1", "3 parameters of PINHOLE; expected 4"),
    ("colmap", "sparse/0/cameras.txt", "1 SIMPLE_RADIAL 36 24 40 18 12 0.1\n", "line 1", "k1 is 0.1"),
    ("colmap", "sparse/0/cameras.txt", "1 OPENCV_FISHEYE 36 24 1 1 1 1 0 0 0 0\n", "camera model OPENCV_FISHEYE"),
    ("colmap_dense", "sparse/images.bin", "cut", "images.bin", "ends in the middle"),
    ("colmap_dense", "stereo/depth_maps/0001.png.geometric.bin", "36&24&1&cut", "geometric.bin", "as many floats"),
    ("traced", "trajectory.txt", None, "no file of poses; expected one head trace"),
    ("traced", "trajectory.txt", "# timestamp tx ty tz qx qy qz qw\nno row\n", "trajectory.txt", "no rows of numb"),
    ("traced", "groundtruth.csv", "t\n", "groundtruth.csv, trajectory.txt; expected one head trace"),
    ("traced", "intrinsics.txt", "40 0 17\n0 42 11\n", "intrinsics.txt: 6 numbers; expected fx fy cx cy"),
    ("traced_matrices", "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n" * 2, "2 poses in poses.txt for 3 pictures"),
    ("numbered", "depth/0.png", lambda depth: depth.astype(np.uint8), "0.png", "8 bits a channel"),
    ("numbered", "depth/0.png", b"GIF nonsense", "0.png", "not a picture"),
    ("numbered", "pose.txt", "# one\n0 0 0 0 0 0 1\n1 2 3\n0 0 0 0 0 0 1\n", "line 3", "expected 7 finite numbers"),
    ("numbered", "pose.txt", lambda text: text.splitlines()[0], "1 poses for 3 pictures"),
    ("redwood", "camera_intrinsic.json", None, "640x480 pixels, its pictures have 36x24", "--intrinsics FX"),
    ("redwood", "camera_intrinsic.json", {"width": 640, "height": 480}, "640x480", "36x24"),
    ("redwood", "trajectory.log", doubled, "trajectory.log, line 1", "does more than turn"),
    ("tum", "depth.txt", "1305031102.2 depth/0.png\n1305031102.3\n", "depth.txt, line 2", "expected seconds"),
    ("tum", "depth.txt", "5.0 depth/0.png\n", "the clocks are 1.30503e+09 s apart"),
    ("tum", "groundtruth.txt", lambda text: text.replace("\n13", "\n23"), "clocks are 1e+09 s apart", "one clock"),
    ("traced", "trajectory.txt", lambda text: text.replace("\n17", "\n27"), "clocks are 1e+09 s apart", "one clock"),
    ("npz", "frame-1.npz", {"time_s": None}, "frame-1.npz: no time_s"),
    ("nerfstudio", "transforms.json", TWO_SCALES, "0.001 and integer_depth_scale 0.002 differ", "--depth-scale"),
    ("nerfstudio", "transforms.json", renamed, "depth_map_name is not read, depth_file_path or"),
    ("nerfstudio", "transforms.json", turned_over, "matrix 0 is written by rows and matrix 1 by columns"),
    ("nerfstudio", "transforms.json", {"is_fisheye": True}, "is_fisheye is true"),
    ("numbered", "camera.json", json.dumps({"K": SKEWED, "depth_scale": 0.001}), "camera.json: K has a skew of 0.5"),
    ("pictures", "0.depth.png", lambda depth: depth[:, ::2], "0.depth.png", "of another shape"),
    *(("npz", "*.npz", {"depth_scale": x}, "frame-0.npz: depth_scale") for x in (0.0, -0.001, np.nan, 1e3)),
    ("npz", "*.npz", {"encoding": "rec709"}, "frame-0.npz: ", "encoding"),
    ("npz", "*.npz", lambda data: data.update(time_s=data["time_s"] * 1e9), "s apart", "unit"),
    ("npz", "*.npz", lambda data: data.update(time_s=data["time_s"] * 1e-6), "s apart", "unit"),
]
LENSES = [
    ({"k1": 0.05}, "k1 is 0.05"),
    ({"p2": -0.001}, "p2 is -0.001"),
    ({"camera_model": "OPENCV_FISHEYE"}, "camera model OPENCV_FISHEYE"),
    ({"distortion": [0, 0, 0.1]}, "distortion[2] is 0.1"),
]
WRONG += [("nerfstudio", "transforms.json", lens, named, "undistort") for lens, named in LENSES]
WRONG += [("numbered", "camera.json", json.dumps(CAMERA | lens), named, "undistort") for lens, named in LENSES]
NONE = SequenceOptions()
# By form: what the user says, and words of the error.
UNSAID = [
    ("numbered", NONE, "--intrinsics FX,FY,CX,CY", "camera.json"),
    ("numbered", STATED, "--depth-scale"),
    ("colmap", NONE, "--depth-scale"),  # its own stereo is in the unit of its poses
    *((form, MIRRORED, "fy is -42; expected above 0") for form in ("tartanair", "stray_scanner", "rtabmap")),
    *((form, NONE, "for 640x480 pixels, its pictures have 36x24") for form in ("tartanair", "seven_scenes")),
    ("tartanair_v2", NONE, "for 640x640 pixels, its pictures have 36x24"),
    ("replica", SequenceOptions(frames_axes="openxr"), "--frames-axes: layout replica", "expected traced"),
    ("replica", SequenceOptions(frames_topics="openxr"), "--frames-topics: layout replica", "expected rosbag"),
    ("replica", SequenceOptions(frames_camera="openxr"), "--frames-camera: layout replica", "expected colmap, "),
]
for _form in ("tum", "icl_nuim"):  # the numbers of a layout are for its own pictures
    _say = "--intrinsics FX,FY,CX,CY --depth-scale METRES"
    UNSAID += [
        (_form, NONE, "36x24", "is for 640x480", _say, "camera.json"),
        (_form, STATED, "36x24", "give --depth-scale METRES"),
        (_form, attrs.evolve(AS_TUM, intrinsics=None), "36x24", "give --intrinsics FX,FY,CX,CY"),
    ]


@pytest.mark.parametrize("case", WRONG, ids=lambda case: f"{case[0]} {case[1]} {case[3][:24]}")
def test_faults_are_named_in_one_line(case, tmp_path):
    form, file, change, *words = case
    folder = edited(tmp_path / "taken", form, {file: change}, 3)
    refused(folder, *words, options=attrs.evolve(FORMS[form].options, layout=FORMS[form].reader))


@pytest.mark.parametrize("case", UNSAID, ids=lambda case: f"{case[0]} {case[2][:24]}")
def test_what_nothing_says_is_requested_by_its_option(case, tmp_path):
    form, options, *words = case
    refused(made(tmp_path / "taken", form), *words, options=options)


def test_what_is_refused_can_be_said(tmp_path):
    """By the option that the refusal names, or by the file."""
    late = {"*.npz": lambda data: data.update(time_s=data["time_s"] * 1e9)}
    for form, edits, options in (
        ("nerfstudio", {"transforms.json": TWO_SCALES}, SequenceOptions(depth_scale=0.001)),
        ("numbered", {"camera.json": json.dumps(CAMERA)}, None),
        ("npz", late, SequenceOptions(frames_rate_hz=30)),
    ):
        assert len(sequences.open(edited(tmp_path / form, form, edits, 3), options).frames) == 3
    folder = edited(tmp_path / "scaled", "numbered", {"camera.json": json.dumps(CAMERA | {"depth_scale": 1000.0})})
    refused(folder, "camera.json: depth_scale is", options=attrs.evolve(MILLIMETRES, depth_scale=None))


def test_options_that_cannot_be_meant():
    for said, message in (({"crop": -1}, "--crop -1 px: expected a"), ({"no_depth": "sky"}, "expected hole or far")):
        with pytest.raises(InputError, match=message):
            SequenceOptions(**said)


def test_a_folder_of_no_layout_is_refused_with_its_content(tmp_path):
    refused(tmp_path, "an empty folder", "no layout", "tum", "nerfstudio", "redwood", "list layouts")
    refused(tmp_path / "nothing", "no such file or folder")
    (tmp_path / "notes.txt").write_text("nothing", encoding="utf-8")
    refused(tmp_path / "notes.txt", "a file", "no layout")
    (tmp_path / "rgb").mkdir()
    refused(tmp_path, "holds notes.txt, rgb/)", "no layout")
    with pytest.raises(UnknownNameError, match="did you mean 'tum'"):
        sequences.open(tmp_path, SequenceOptions(layout="tun"))
    for name in ("scene/seq-01", "scene/seq-02"):
        made(tmp_path / name, "seven_scenes", 1)
    refused(tmp_path / "scene", "holds the sequences seq-01, seq-02: name one")


def test_what_the_depth_of_a_folder_cannot_be(tmp_path):
    """A picture of bytes in place of TartanAir's floats; whole numbers beside any trace."""
    made(tmp_path / "tartanair", "tartanair", 1)
    depth = tmp_path / "tartanair/depth_left/000000_left_depth"
    depth.with_suffix(".npy").unlink()
    Image.fromarray(taken(1)[0].colour).save(depth.with_suffix(".png"))
    refused(tmp_path / "tartanair", "3 channels; expected four bytes a pixel", options=STATED)
    made(tmp_path / "traced", "traced")
    for file in sorted((tmp_path / "traced/depth").iterdir()):
        np.save(file.with_suffix(".npy"), np.ones((24, 36), np.uint16))
        file.unlink()
    refused(tmp_path / "traced", "nothing says the unit of its depth: give --depth-scale")


def test_a_count_is_no_clock(tmp_path):
    """Every fifth picture of a recording is not at second 0, 5 and 10 of its trace."""
    folder = made(tmp_path / "taken", "traced", 4)
    for i, file in enumerate(sorted(folder.glob("rgb/*.png"))):
        file.rename(file.with_name(f"{5 * i:04}.png"))
        (folder / "depth" / file.name).rename(folder / f"depth/{5 * i:04}.png")
    rows = (f"{at:.3f} 0 0 {at / 10} 0 0 0 1" for at in np.arange(0, 30, 0.1))
    (folder / "trajectory.txt").write_text("# timestamp tx ty tz qx qy qz qw\n" + "\n".join(rows))
    words = "300 poses in trajectory.txt for 4 pictures, whose names are no instants"
    refused(folder, words, options=FORMS["traced"].options)


needs_rosbags = partial(pytest.importorskip, "rosbags", reason="rosbags is not installed (pip install '.[bags]')")
COLOUR, DEPTH = "/camera/color/image_raw", "/camera/aligned_depth_to_color/image_raw"


Change = Callable[[Messages, Logged], Iterator[Logged]]


def changed(folder: Path, change: Change, motion: str = "tf") -> Path:
    """A bag of ROS 2 whose messages are changed one by one."""
    needs_rosbags()
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
    needs_rosbags()
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


DARK, STEPS, FLOATS = np.zeros((24, 36), np.uint8), np.ones((24, 36), np.uint16), np.full((24, 36), 2.5, np.float32)
BAYER = with_other(COLOUR, lambda messages, stamp: messages.image(stamp, DARK, "bayer_rggb8"))
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
    FLOATS[0, 0] = np.nan
    floats = with_other(DEPTH, lambda messages, stamp: messages.image(stamp, FLOATS, "32FC1"))
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
    needs_rosbags()
    (tmp_path / f"taken{ending}").write_bytes(b"no bag at all" * 20)
    refused(tmp_path / f"taken{ending}", f"taken{ending}: cannot be read as a bag")
    (tmp_path / "two.bag").write_bytes(b"")
    (tmp_path / "one.bag").write_bytes(b"")
    refused(tmp_path, "no bag, or several", options=SequenceOptions(layout="rosbag"))
