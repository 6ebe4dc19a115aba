"""Data sets and recorders: what of a folder is missing or wrong is named in one line."""

from __future__ import annotations

import io
import json
import re

import attrs
import numpy as np
import pytest
from PIL import Image
from published_folders import (
    PUBLISHED,
    write_open3d,
    write_scannet,
    write_stray_scanner,
    write_tartanair,
    write_traced,
    write_with_info,
)
from recorded_folders import CX, CY, FX, FY, MIRRORED, SIZE, STATED, fov_of, taken, write_numbered, write_tum
from ros_bags import BAGS, HAS_ROSBAGS

from hmdwarp import View, Warper, WarpMap
from hmdwarp.errors import InputError
from hmdwarp.poses.assumptions import By
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import SequenceOptions, readers

STRAY = "timestamp, frame, x, y, z, qx, qy, qz, qw\n"
# By form: a file, what takes its place (None: it is gone), and words of the error.
WRONG = [
    ("seven_scenes", "frame-000001.pose.txt", "1 0 0 0\n0 1 x 0\n", ("pose.txt, line 2", "expected 4 numbers")),
    ("seven_scenes", "frame-000001.pose.txt", "1 0 0 0\n", ("pose.txt", "1 lines; expected a matrix")),
    ("seven_scenes", "frame-000001.color.png", "no picture", ("color.png", "not a picture")),
    ("twelve_scenes", "../info.txt", "m_calibrationColorIntrinsic = 1 2\n", ("info.txt: m_depthShift is missing",)),
    ("twelve_scenes", "../info.txt", "m_depthShift = 1\nm_calibrationColorIntrinsic = 1 2", ("Intrinsic is 1 2;",)),
    ("three_r_scan", "_info.txt", None, ("intrinsics are for 640x480 pixels", "--intrinsics")),
    ("three_d_match", "../camera-intrinsics.txt", "1 0 0\n", ("camera-intrinsics.txt", "3 lines of 3 numbers")),
    ("scannet", "intrinsic/intrinsic_color.txt", "1 2 3\n", ("intrinsic_color.txt", "expected a matrix")),
    ("scannet", "intrinsic/extrinsic_depth.txt", "1 0 0 .1\n0 1 0 0\n0 0 1 0\n0 0 0 1\n", ("extrinsic_depth", "unit")),
    ("replica", "traj.txt", "1 0 0\n", ("1 poses, and a picture frame000002.jpg",)),
    ("replica", "traj.txt", "\n".join(["1 0 0"] * 3), ("traj.txt, line 1", "expected 16 finite numbers")),
    ("replica", "../cam_params.json", '{"camera": {"w": 36}}', ("cam_params.json: h is None",)),
    ("tartanair", "pose_left.txt", "\n".join(["0 0 0 0 0 0"] * 3), ("pose_left.txt, line 1", "7 finite numbers")),
    ("tartanair", "pose_left.txt", "0 0 0 0 0 0 1\n", ("1 poses, and a picture 2",)),
    ("stray_scanner", "odometry.csv", "x, y, z\n1, 2, 3\n", ("odometry.csv, line 1", "the header timestamp, frame")),
    ("stray_scanner", "odometry.csv", STRAY + "1.0, 000000, 1, 2\n", ("odometry.csv, line 2", "9 finite numbers")),
    (
        "stray_scanner",
        "odometry.csv",
        STRAY + "1.0, 000000, 0, 0, 0, 0, 0, 0, 2\n",
        ("line 2", "quaternion of length 2"),
    ),
    ("stray_scanner", "rgb.mp4", "no video", ("rgb.mp4", "not a video")),
    ("stray_scanner", "camera_matrix.csv", None, ("camera_matrix.csv", "no such file")),
    ("rtabmap", "map_camera_poses.txt", "1.0 0 0 0 0 0 0 1\n", ("poses.txt, line 1", "--poses_format 11")),
    ("rtabmap", "map_calib/8.yaml", None, ("8.yaml", "expected the calibration of its image")),
    ("rtabmap", "map_calib/8.yaml", "image_width: 36\n", ("8.yaml", "camera_matrix of 9 numbers")),
    ("open3d", "camera_trajectory.json", '{"class_name": "PinholeCameraTrajectory"}', ("no list of parameters",)),
    ("open3d", "color/00002.png", None, ("3 parameters for 2 pictures",)),
    ("colmap", "sparse/0/images.txt", "1 1 0 0 0 0 0\n", ("images.txt, line 1", "IMAGE_ID QW QX QY QZ")),
    ("colmap", "sparse/0/images.txt", "1 2 0 0 0 0 0 0 1 0000.png\n", ("images.txt, line 1", "quaternion of length 2")),
    ("colmap", "sparse/0/cameras.txt", "2 PINHOLE 36 24 1 1 1 1\n", ("name camera 1",)),
    ("colmap", "sparse/0/cameras.txt", "1 PINHOLE 36 24 1 1 1\n", ("line 1", "3 parameters of PINHOLE; expected 4")),
    ("colmap", "sparse/0/cameras.txt", "1 SIMPLE_RADIAL 36 24 40 18 12 0.1\n", ("line 1", "k1 is 0.1")),
    ("colmap", "sparse/0/cameras.txt", "1 OPENCV_FISHEYE 36 24 1 1 1 1 0 0 0 0\n", ("camera model OPENCV_FISHEYE",)),
    ("colmap_dense", "sparse/images.bin", "cut", ("images.bin", "ends in the middle")),
    ("colmap_dense", "stereo/depth_maps/0001.png.geometric.bin", "36&24&1&cut", ("geometric.bin", "as many floats")),
    ("traced", "trajectory.txt", None, ("no file of poses; expected one head trace",)),
    (
        "traced",
        "trajectory.txt",
        "# timestamp tx ty tz qx qy qz qw\nno row\n",
        ("trajectory.txt", "no rows of numbers"),
    ),
    ("traced", "groundtruth.csv", "t\n", ("groundtruth.csv, trajectory.txt; expected one head trace",)),
    ("traced", "intrinsics.txt", "40 0 17\n0 42 11\n", ("intrinsics.txt: 6 numbers; expected fx fy cx cy",)),
    ("traced_matrices", "poses.txt", "1 0 0 0 0 1 0 0 0 0 1 0\n" * 2, ("2 poses in poses.txt for 3 pictures",)),
]


ALL = PUBLISHED | BAGS


def need(form: str) -> None:
    if form in BAGS and not HAS_ROSBAGS:
        pytest.skip("rosbags is not installed (pip install '.[bags]')")


@pytest.fixture
def folder(tmp_path):
    """A folder whose parent belongs to the same test."""
    (tmp_path / "taken").mkdir()
    return tmp_path / "taken"


@pytest.mark.parametrize(("form", "file", "content", "words"), WRONG)
def test_faults_are_named_in_one_line(form, file, content, words, folder):
    PUBLISHED[form].write(folder, taken(3))
    if content is None:
        (folder / file).unlink()
    else:
        (folder / file).write_text(content)
    with pytest.raises(InputError) as caught:
        for frame in sequences.open(
            folder, attrs.evolve(PUBLISHED[form].options, layout=PUBLISHED[form].reader)
        ).frames:
            frame.read()
    message = str(caught.value)
    assert all(word in message for word in words) and "\n" not in message, message


@pytest.mark.parametrize("form", PUBLISHED)
def test_a_layout_by_name_refuses_an_empty_folder(form, tmp_path):
    with pytest.raises(InputError, match="expected|no such file|cannot be read") as caught:
        sequences.open(tmp_path, attrs.evolve(PUBLISHED[form].options, layout=PUBLISHED[form].reader))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("form", PUBLISHED)
def test_assumptions_about_a_folder_are_entries(form, folder):
    """Intrinsics, the depth's unit, axes and the clock, each with who says so."""
    PUBLISHED[form].write(folder, taken(2))
    entries = sequences.open(folder, PUBLISHED[form].options).assumptions
    assert {"intrinsics", "depth scale", "camera axes", "frame clock"} <= {entry.what for entry in entries}
    if PUBLISHED[form].options.intrinsics is not None:
        assert next(entry.by for entry in entries if entry.what == "intrinsics") is By.USER


@pytest.mark.parametrize("form", PUBLISHED)
def test_a_pixel_is_seen_where_the_truth_sees_it(form, folder):
    """By the warp map from first to last: an error of axes, scale or inverse moves it."""
    frames = taken(3, step_m=0.05, step_deg=3)
    PUBLISHED[form].write(folder, frames)
    first, *_, last = sequences.open(folder, PUBLISHED[form].options).frames
    view, other = (attrs.evolve(first.view, pose=frame.pose, fov=fov_of()) for frame in (frames[0], frames[-1]))
    at = np.array([[5.0, 7.0], [20.0, 12.0]])
    inverse = [
        1 / np.flipud(depth)[at[:, 1].astype(int), at[:, 0].astype(int)] for depth in (first.depth_m, frames[0].depth_m)
    ]
    found, expected = (
        WarpMap.between(one, first.size, two, first.size).apply(at + 0.5, depth)[0]
        for (one, two), depth in zip(((first.view, last.view), (view, other)), inverse, strict=True)
    )
    assert np.abs(found - expected).max() < 0.02 and np.abs(expected - at - 0.5).max() > 1


@pytest.fixture(scope="module")
def warper():
    with Warper(SIZE, fill="none") as warper:
        yield warper


@pytest.mark.parametrize("form", ALL)
def test_a_warp_of_what_is_read_is_the_warp_of_the_truth(form, folder, warper):
    """From the first frame to the last: within what a JPEG and half a step of depth change."""
    frames = taken(3, step_m=0.05, step_deg=3)
    need(form)
    ALL[form].write(folder, frames)
    first, *_, last = sequences.open(folder, ALL[form].options).frames
    rendered, shown = (View(frame.pose, fov_of()) for frame in (frames[0], frames[-1]))
    true = warper.warp(frames[0].colour, frames[0].depth_m, rendered=rendered, shown=shown)
    found = warper.warp(*first.read(), rendered=first.view, shown=last.view)
    both = (true.coverage > 0.999) & (found.coverage > 0.999)
    assert both.mean() > 0.7 and (both == (true.coverage > 0.999)).mean() > 0.97
    assert np.abs(found.colour.astype(int) - true.colour)[both].mean() < 1.5
    assert np.abs(true.colour.astype(int) - frames[0].colour)[both].mean() > 10


@pytest.mark.parametrize(("form", "bad"), [("seven_scenes", "nan"), ("scannet", "-inf")])
def test_frames_without_a_pose_are_left_out_and_counted(form, bad, folder):
    PUBLISHED[form].write(folder, taken(4))
    file = next(folder.rglob("*1*.txt"))
    file.write_text("\n".join([f"{bad} " * 4] * 4))
    sequence = sequences.open(folder, PUBLISHED[form].options)
    assert [frame.time_ns for frame in sequence.frames] == [taken(4)[i].time_ns for i in (0, 2, 3)]
    assert "1 frames were left out: no depth, or no pose of finite numbers." in sequence.notes


def test_a_scene_of_seven_scenes_names_its_sequences(tmp_path):
    for name in ("seq-01", "seq-02"):
        PUBLISHED["seven_scenes"].write(tmp_path / name, taken(1))
    with pytest.raises(InputError, match="holds the sequences seq-01, seq-02: name one"):
        sequences.open(tmp_path)


@pytest.mark.parametrize(
    ("form", "size"), [("tartanair", (640, 480)), ("tartanair_v2", (640, 640)), ("seven_scenes", (640, 480))]
)
def test_a_camera_of_a_data_set_is_for_its_own_size(form, size, folder):
    """And taken there: TartanAir sees 90 degrees across, evenly about the middle."""
    PUBLISHED[form].write(folder, taken(1, size))
    sequence = sequences.open(folder)
    left, right, down, up = sequence.frames[0].fov.tangents
    if form != "seven_scenes":
        assert (left, right) == pytest.approx((-1, 1)) and -down == pytest.approx(up)
    by = By.DEFAULT if form == "seven_scenes" else By.FORMAT  # others have taken over its names
    assert next(entry.by for entry in sequence.assumptions if entry.what == "intrinsics") is by
    with pytest.raises(InputError, match=f"for {size[0]}x{size[1]} pixels, its pictures have 36x24"):
        PUBLISHED[form].write(folder, taken(1))
        sequences.open(folder)


@pytest.mark.parametrize("write", [write_scannet, write_with_info])
def test_depth_of_fewer_pixels_goes_through_both_cameras(write, folder):
    """Every second pixel: the nearest to the colour's ray, and none beyond the depth's border."""
    write(folder, taken(1), stride=2)
    found, true = sequences.open(folder).frames[0].depth_m, taken(1)[0].depth_m
    row, column = (np.rint(np.arange(count) / 2).astype(int) for count in true.shape)
    inside = (row < 12)[:, None] & (column < 18)
    expected = np.where(inside, true[::2, ::2][row.clip(0, 11)[:, None], column.clip(0, 17)], 0)
    assert np.abs(found - expected).max() <= 0.5e-3 + 1e-6 and inside.mean() > 0.9


def test_colour_that_was_shrunk_to_its_depth_has_the_camera_of_the_depth(folder):
    """Its own file is still that of the larger pictures; without another it is refused."""
    write_scannet(folder, taken(1))
    larger = "1170 0 648 0\n0 1170 484 0\n0 0 1 0\n0 0 0 1\n"
    (folder / "intrinsic/intrinsic_color.txt").write_text(larger)
    left, right, _, _ = sequences.open(folder).frames[0].fov.tangents
    assert right - left == pytest.approx(36 / FX)
    (folder / "intrinsic/intrinsic_depth.txt").write_text(larger)
    with pytest.raises(InputError, match="its centre at 648,484, which is not the middle of pictures of 36x24"):
        sequences.open(folder)


@pytest.mark.parametrize("form", ["tartanair", "stray_scanner", "rtabmap"])
def test_a_camera_with_y_up_is_refused_where_the_layout_has_it_down(form, folder):
    PUBLISHED[form].write(folder, taken(1))
    with pytest.raises(InputError, match="fy is -42; expected above 0"):
        sequences.open(folder, MIRRORED)


def test_tartanair_depth_is_refused_where_it_is_no_float(folder):
    write_tartanair(folder, taken(1))
    (folder / "depth_left/000000_left_depth.npy").unlink()
    Image.fromarray(taken(1)[0].colour).save(folder / "depth_left/000000_left_depth.png")
    with pytest.raises(InputError, match="3 channels; expected four bytes a pixel"):
        sequences.open(folder, SequenceOptions(intrinsics=STATED.intrinsics)).frames[0].read()


def test_pictures_of_a_video_are_read_in_any_order(folder):
    PUBLISHED["stray_scanner"].write(folder, taken(40))
    frames = sequences.open(folder).frames
    for at in (3, 0, 39, 38, 37, 2, 2, 1, 20, 39):
        assert np.array_equal(frames[at].colour, taken(40)[at].colour)


def test_depth_of_a_telephone_has_fewer_pixels_than_its_video(folder):
    """Each covers two by two of the colour's pixels."""
    write_stray_scanner(folder, taken(1), stride=2)
    found = sequences.open(folder).frames[0].depth_m
    assert np.array_equal(found, np.repeat(np.repeat(found[::2, ::2], 2, 0), 2, 1)) and found.shape == (24, 36)


def test_a_focus_that_breathes_is_taken_in_the_middle(folder):
    """Within 0.5 % of the width at the border, and beyond it each frame has its own."""
    write_stray_scanner(folder, taken(3), focus=(1.0, 1.002, 1.004))
    sequence = sequences.open(folder)
    left, right, _, _ = sequence.frames[0].fov.tangents
    assert right - left == pytest.approx(36 / FX / 1.002)
    assert len({frame.fov for frame in sequence.frames}) == 1
    assert "differ from frame to frame, by up to" in sequence.notes[0]
    write_stray_scanner(folder, taken(3), focus=(1.0, 1.1, 1.2))
    wide = [frame.fov.tangents[1] - frame.fov.tangents[0] for frame in sequences.open(folder).frames]
    assert wide == pytest.approx([36 / FX, 36 / FX / 1.1, 36 / FX / 1.2])
    (folder / "depth/000001.png").unlink()  # a frame that is left out takes its own along
    wide = [frame.fov.tangents[1] - frame.fov.tangents[0] for frame in sequences.open(folder).frames]
    assert wide == pytest.approx([36 / FX, 36 / FX / 1.2])


def test_a_scale_that_all_matrices_share_is_told_and_others_are_refused(folder):
    write_open3d(folder, taken(2), scale=2.5)
    said = next(entry for entry in sequences.open(folder).assumptions if entry.what == "camera pose")
    assert said.by is By.FILE and said.value.endswith("by columns, their scale of 2.5 divided out")
    file = folder / "camera_trajectory.json"
    data = json.loads(file.read_text())
    extrinsic = data["parameters"][1]["extrinsic"]
    data["parameters"][1]["extrinsic"] = [2 * x for x in extrinsic[:12]] + extrinsic[12:]
    file.write_text(json.dumps(data))
    with pytest.raises(InputError, match="more than turn and move; expected .* a scale only where all have the same"):
        sequences.open(folder)


def test_a_model_of_colmap_needs_the_unit_of_foreign_depth(folder):
    """Its own stereo is in the unit of its poses; that of a depth camera is not."""
    PUBLISHED["colmap"].write(folder, taken(1))
    with pytest.raises(InputError, match="--depth-scale"):
        sequences.open(folder)
    assert "length: 1 m per unit of the model, whose own is any (default)" in [
        str(entry) for entry in sequences.open(folder, PUBLISHED["colmap"].options).assumptions
    ]


def test_an_image_of_colmap_without_depth_is_left_out(folder):
    PUBLISHED["colmap"].write(folder, taken(3))
    (folder / "depth/0001.png").unlink()
    sequence = sequences.open(folder, PUBLISHED["colmap"].options)
    assert [frame.name for frame in sequence.frames] == ["0000.png", "0002.png"]
    assert sequence.notes == ("1 frames were left out: no picture or no depth.",)


@pytest.mark.parametrize(("cameras", "left"), [("11221", [0, 3, 4]), ("12345", [0, 1, 2, 3, 4])])
def test_of_two_cameras_of_colmap_one_is_chosen_but_not_of_one_for_each_image(cameras, left, folder):
    """The last image stands first in the file."""
    PUBLISHED["colmap"].write(folder, taken(5))
    images, known, number = folder / "sparse/0/images.txt", folder / "sparse/0/cameras.txt", iter(cameras)
    known.write_text(known.read_text() + "".join(f"{n} PINHOLE 36 24 40 40 18 12\n" for n in range(2, 6)))
    images.write_text(re.sub(r" \d+ (\d+\.png)", lambda one: f" {next(number)} {one[1]}", images.read_text()))
    sequence = sequences.open(folder, PUBLISHED["colmap"].options)
    assert [frame.name for frame in sequence.frames] == [f"{n:04}.png" for n in left]
    said = "2 frames of other cameras than 1 were left out, as it has most images; --frames-camera reads another (1: 3 "
    assert [note[: len(said)] for note in sequence.notes] == [said] * (len(left) == 3)
    options = attrs.evolve(PUBLISHED["colmap"].options, frames_camera="2")
    second = [f"{n:04}.png" for n in range(5) if cameras[::-1][n] == "2"] if len(left) == 3 else ["0003.png"]
    assert [frame.name for frame in sequences.open(folder, options).frames] == second
    with pytest.raises(InputError, match="--frames-camera is 7; expected one of its cameras: 1: "):
        sequences.open(folder, attrs.evolve(options, frames_camera="7"))


@pytest.mark.parametrize("seed", range(12))
def test_colour_goes_with_the_depth_of_its_number_or_is_refused(seed, folder):
    """Names of several writers; where each lacks a frame of the other, equal counts say nothing."""
    rng = np.random.default_rng(seed)
    PUBLISHED["traced"].write(folder, taken(8))
    of_colour, of_depth = (
        ("{:06}", "frame-{}", "rgb8_{:03}")[seed % 3],
        ("{}", "depth_{:05}", "raw16-{}")[seed // 3 % 3],
    )
    for side, name in (("rgb", of_colour), ("depth", of_depth)):
        for i, file in enumerate(sorted((folder / side).iterdir())):
            file.rename(file.with_name(f"{name.format(i + 8)}{file.suffix}"))
    (folder / "trajectory.txt").write_text("".join(f"{100 + i / 30} 0.0{i + 1} 0 0 0 0 0 1\n" for i in range(8)))
    found = sequences.open(folder, PUBLISHED["traced"].options)
    assert len(found.frames) == 8
    for frame, one in zip(found.frames, taken(8), strict=True):
        assert np.abs(frame.depth_m - one.depth_m).max() <= 1e-3
    here, there = rng.choice(8, 2, replace=False) + 8
    (folder / f"rgb/{of_colour.format(here)}.png").unlink()
    (folder / f"depth/{of_depth.format(there)}.png").unlink()
    with pytest.raises(InputError, match=f"7 pictures in rgb, 7 in depth, without depth .*{there}"):
        sequences.open(folder, PUBLISHED["traced"].options)


def test_a_trace_beside_pictures_gives_the_motion_between_them_and_who_says_its_axes(folder):
    PUBLISHED["traced"].write(folder, taken(3))
    sequence = sequences.open(folder, PUBLISHED["traced"].options)
    assert len(sequence.track) == 5
    said = {entry.what: (entry.value, entry.by) for entry in sequence.assumptions}
    assert said["camera axes"] == ("x right, y down, z forward, of world and camera", By.DEFAULT)
    assert said["frame clock"] == ("pictures are named by the trace's clock, in s", By.FILE)
    file = folder / "trajectory.txt"
    file.write_text("# axes: opencv\n" + file.read_text())
    again = sequences.open(folder, PUBLISHED["traced"].options)
    assert next(entry.by for entry in again.assumptions if entry.what == "camera axes") is By.FILE
    assert again.frames[2].pose.isclose(sequence.frames[2].pose, 1e-12)


@pytest.mark.parametrize("per_second", [10**3, 10**6, 10**9])
def test_whole_numbers_are_instants_of_the_trace_in_the_unit_that_fits(per_second, folder):
    PUBLISHED["traced"].write(folder, taken(4))
    for file in [*folder.glob("*/*.png")]:
        file.rename(file.with_name(f"{round(float(file.stem) * per_second)}.png"))
    found = sequences.open(folder, PUBLISHED["traced"].options)
    assert len(found.frames) >= 3 and found.rate_hz == pytest.approx(30, rel=0.03)


@pytest.mark.parametrize("layout", ["traced", "tum"])
def test_clocks_that_are_apart_are_told_with_how_far(layout, folder):
    """The poses' clock is 10^9 s ahead."""
    (write_tum if layout == "tum" else write_traced)(folder, taken(3))
    file = folder / ("groundtruth.txt" if layout == "tum" else "trajectory.txt")
    file.write_text(re.sub(r"(?m)^1(\d{9})", r"2\1", file.read_text()))
    with pytest.raises(InputError, match=r"the clocks are 1e\+09 s apart \(.*; expected one clock"):
        sequences.open(folder, PUBLISHED["traced"].options if layout == "traced" else SequenceOptions())


@pytest.mark.parametrize("name", ["cam{}_{:04}", "{1:04}_{0}", "frame{1}.{0}"])
def test_of_a_rig_of_cameras_the_user_names_one(name, folder):
    """Else it is refused with their names: each of six frames was one camera's or the other's."""
    PUBLISHED["traced"].write(folder, taken(6))
    trace = folder / "trajectory.txt"
    trace.write_text("".join(trace.read_text().splitlines(keepends=True)[:4]))
    stated, pictures = PUBLISHED["traced"].options, {}
    for side in ("rgb", "depth"):
        for i, file in enumerate(sorted((folder / side).iterdir())):
            pictures[side, i] = file.read_bytes()
            file.rename(file.with_name(f"{name.format(('left', 'right')[i % 2], i // 2)}{file.suffix}"))
    for wanted in (None, "t", "middle"):
        with pytest.raises(InputError, match=f"--frames-camera is {wanted or 'not given'}; .*: .*left.*, .*right"):
            sequences.open(folder, attrs.evolve(stated, frames_camera=wanted))
    found = sequences.open(folder, attrs.evolve(stated, frames_camera="right"))
    assert [frame.colour.tobytes() for frame in found.frames] == [
        np.asarray(Image.open(io.BytesIO(pictures["rgb", i]))).tobytes() for i in (1, 3, 5)
    ]


@pytest.mark.parametrize("turned", [False, True])
def test_a_projection_matrix_states_the_camera(turned, folder):
    """That of the frames' own intrinsics, as OpenGL has it, by rows or columns."""
    wide, high = SIZE
    matrix = np.diag([2 * FX / wide, 2 * FY / high, -1.002, 0])
    matrix[:3, 2], matrix[2, 3], matrix[3, 2] = (1 - (2 * CX + 1) / wide, (2 * CY + 1) / high - 1, -1.002), -0.2, -1
    text = ",".join(map(repr, (matrix.T if turned else matrix).ravel().tolist()))
    write_numbered(folder, taken(1))
    stated = SequenceOptions(projection=sequences.parse_projection(text), depth_scale=1e-3)
    fov = sequences.open(folder, stated).frames[0].fov
    assert np.allclose(fov.tangents, fov_of().tangents, atol=1e-9)
    with pytest.raises(InputError, match="--projection '1,2': projection is .*16 numbers"):
        sequences.parse_projection("1,2")
    with pytest.raises(InputError, match="--intrinsics and --projection both state the camera"):
        attrs.evolve(stated, intrinsics=sequences.parse_intrinsics("1,1,0,0"))


def test_whole_numbers_of_an_array_have_no_unit(folder):
    """Floats are metres; whole numbers beside any trace may be millimetres or anything else."""
    write_traced(folder, taken(2))
    for file in sorted((folder / "depth").iterdir()):
        np.save(file.with_suffix(".npy"), np.asarray(Image.open(file)))
        file.unlink()
    with pytest.raises(InputError, match="nothing says the unit of its depth: give --depth-scale"):
        sequences.open(folder)


def test_a_bag_beside_pictures_is_their_trace(folder):
    """Where a folder holds pictures, the bag in it is not where they are looked for."""
    PUBLISHED["traced"].write(folder, taken(1))
    (folder / "trajectory.txt").rename(folder / "trajectory.bag")
    chances = {name: readers.get(name).fits(folder) for name in ("rosbag", "traced")}
    assert 0 < chances["rosbag"] < chances["traced"]


def test_a_count_is_no_clock(folder):
    """Every fifth picture of a recording is not at second 0, 5 and 10 of its trace."""
    PUBLISHED["traced"].write(folder, taken(4))
    for i, file in enumerate(sorted(folder.glob("rgb/*.png"))):
        file.rename(file.with_name(f"{5 * i:04}.png"))
        (folder / "depth" / file.name).rename(folder / f"depth/{5 * i:04}.png")
    rows = (f"{at:.3f} 0 0 {at / 10} 0 0 0 1" for at in np.arange(0, 30, 0.1))
    (folder / "trajectory.txt").write_text("# timestamp tx ty tz qx qy qz qw\n" + "\n".join(rows))
    with pytest.raises(InputError, match="300 poses in trajectory.txt for 4 pictures, whose names are no instants"):
        sequences.open(folder, PUBLISHED["traced"].options)


def test_a_stated_rate_takes_the_place_of_the_trace_s_clock(folder):
    PUBLISHED["traced"].write(folder, taken(3))
    sequence = sequences.open(folder, attrs.evolve(PUBLISHED["traced"].options, frames_rate_hz=10.0))
    assert sequence.rate_hz == pytest.approx(10) and sequence.frames[2].pose.isclose(taken(3)[2].pose, 1e-9)


def test_pictures_beyond_the_trace_are_left_out(folder):
    PUBLISHED["traced"].write(folder, taken(4))
    file = folder / "trajectory.txt"
    file.write_text("\n".join(file.read_text().splitlines()[:6]) + "\n")
    sequence = sequences.open(folder, PUBLISHED["traced"].options)
    assert len(sequence.frames) == 3
    assert "1 frames were left out: the trace has no pose at their instants." in sequence.notes


@pytest.mark.parametrize(
    ("option", "takes"), [("frames_axes", "traced"), ("frames_topics", "rosbag"), ("frames_camera", "colmap, ")]
)
def test_an_option_that_a_layout_does_not_take_is_refused(option, takes, folder):
    PUBLISHED["replica"].write(folder, taken(1))
    flag = f"--{option.replace('_', '-')}"
    with pytest.raises(InputError, match=f"{flag}: layout replica does not take it; expected {takes}"):
        sequences.open(folder, SequenceOptions(**{option: "openxr"}))
