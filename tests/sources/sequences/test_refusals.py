"""What of a folder is missing, wrong or of another unit is named in one line."""

from __future__ import annotations

import json

import attrs
import numpy as np
import pytest
from PIL import Image
from recorded_folders import AS_TUM, MILLIMETRES, MIRRORED, STATED, taken
from ros_bags import FORMS

from hmdwarp.errors import InputError, UnknownNameError
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import SequenceOptions

from .folders import edited, made, refused

STRAY = "timestamp, frame, x, y, z, qx, qy, qz, qw\n"
CAMERA = {"intrinsics": [40, 40, 18, 12], "depth_scale": 0.001}
# By form: files, what takes the place of each (None: it is gone), and words of the error.
WRONG = [
    ("seven_scenes", {"frame-000001.pose.txt": "1 0 0 0\n0 1 x 0\n"}, ("pose.txt, line 2", "expected 4 numbers")),
    ("seven_scenes", {"frame-000001.pose.txt": "1 0 0 0\n"}, ("pose.txt", "1 lines; expected a matrix")),
    ("seven_scenes", {"frame-000001.color.png": "no picture"}, ("color.png", "not a picture")),
    ("twelve_scenes", {"../info.txt": "m_calibrationColorIntrinsic = 1 2\n"}, ("info.txt: m_depthShift is missing",)),
    ("twelve_scenes", {"../info.txt": "m_depthShift = 1\nm_calibrationColorIntrinsic = 1 2"}, ("Intrinsic is 1 2;",)),
    ("three_r_scan", {"_info.txt": None}, ("intrinsics are for 640x480 pixels", "--intrinsics")),
    ("three_d_match", {"../camera-intrinsics.txt": "1 0 0\n"}, ("camera-intrinsics.txt", "3 lines of 3 numbers")),
    ("scannet", {"intrinsic/intrinsic_color.txt": "1 2 3\n"}, ("intrinsic_color.txt", "expected a matrix")),
    (
        "scannet",
        {"intrinsic/extrinsic_depth.txt": "1 0 0 .1\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"},
        ("extrinsic_depth", "unit"),
    ),
    ("replica", {"traj.txt": "1 0 0\n"}, ("1 poses, and a picture frame000002.jpg",)),
    ("replica", {"traj.txt": "\n".join(["1 0 0"] * 3)}, ("traj.txt, line 1", "expected 16 finite numbers")),
    ("replica", {"../cam_params.json": '{"camera": {"w": 36}}'}, ("cam_params.json: h is None",)),
    ("tartanair", {"pose_left.txt": "\n".join(["0 0 0 0 0 0"] * 3)}, ("pose_left.txt, line 1", "7 finite numbers")),
    ("tartanair", {"pose_left.txt": "0 0 0 0 0 0 1\n"}, ("1 poses, and a picture 2",)),
    ("stray_scanner", {"odometry.csv": "x, y, z\n1, 2, 3\n"}, ("odometry.csv, line 1", "the header timestamp, frame")),
    ("stray_scanner", {"odometry.csv": STRAY + "1.0, 000000, 1, 2\n"}, ("odometry.csv, line 2", "9 finite numbers")),
    (
        "stray_scanner",
        {"odometry.csv": STRAY + "1.0, 000000, 0, 0, 0, 0, 0, 0, 2\n"},
        ("line 2", "quaternion of length 2"),
    ),
    ("stray_scanner", {"rgb.mp4": "no video"}, ("rgb.mp4", "not a video")),
    ("stray_scanner", {"camera_matrix.csv": None}, ("camera_matrix.csv", "no such file")),
    ("rtabmap", {"map_camera_poses.txt": "1.0 0 0 0 0 0 0 1\n"}, ("poses.txt, line 1", "--poses_format 11")),
    ("rtabmap", {"map_calib/8.yaml": None}, ("8.yaml", "expected the calibration of its image")),
    ("rtabmap", {"map_calib/8.yaml": "image_width: 36\n"}, ("8.yaml", "camera_matrix of 9 numbers")),
    ("open3d", {"camera_trajectory.json": '{"class_name": "PinholeCameraTrajectory"}'}, ("no list of parameters",)),
    ("open3d", {"color/00002.png": None}, ("3 parameters for 2 pictures",)),
    (
        "open3d_scaled",
        {"camera_trajectory.json": lambda data: grown(data["parameters"][1]["extrinsic"])},
        ("more than turn and move; expected", "a scale only where all have the same"),
    ),
    ("colmap", {"sparse/0/images.txt": "1 1 0 0 0 0 0\n"}, ("images.txt, line 1", "IMAGE_ID QW QX QY QZ")),
    ("colmap", {"sparse/0/images.txt": "1 2 0 0 0 0 0 0 1 0000.png\n"}, ("images.txt, line 1", "quaternion of length")),
    ("colmap", {"sparse/0/cameras.txt": "2 PINHOLE 36 24 1 1 1 1\n"}, ("name camera 1",)),
    ("colmap", {"sparse/0/cameras.txt": "1 PINHOLE 36 24 1 1 1\n"}, ("line 1", "3 parameters of PINHOLE; expected 4")),
    ("colmap", {"sparse/0/cameras.txt": "1 SIMPLE_RADIAL 36 24 40 18 12 0.1\n"}, ("line 1", "k1 is 0.1")),
    ("colmap", {"sparse/0/cameras.txt": "1 OPENCV_FISHEYE 36 24 1 1 1 1 0 0 0 0\n"}, ("camera model OPENCV_FISHEYE",)),
    ("colmap_dense", {"sparse/images.bin": "cut"}, ("images.bin", "ends in the middle")),
    ("colmap_dense", {"stereo/depth_maps/0001.png.geometric.bin": "36&24&1&cut"}, ("geometric.bin", "as many floats")),
    ("traced", {"trajectory.txt": None}, ("no file of poses; expected one head trace",)),
    ("traced", {"trajectory.txt": "# timestamp tx ty tz qx qy qz qw\nno row\n"}, ("trajectory.txt", "no rows of numb")),
    ("traced", {"groundtruth.csv": "t\n"}, ("groundtruth.csv, trajectory.txt; expected one head trace",)),
    ("traced", {"intrinsics.txt": "40 0 17\n0 42 11\n"}, ("intrinsics.txt: 6 numbers; expected fx fy cx cy",)),
    ("traced_matrices", {"poses.txt": "1 0 0 0 0 1 0 0 0 0 1 0\n" * 2}, ("2 poses in poses.txt for 3 pictures",)),
    ("numbered", {"depth/0.png": lambda depth: depth.astype(np.uint8)}, ("0.png", "8 bits a channel")),
    ("numbered", {"depth/0.png": b"GIF nonsense"}, ("0.png", "not a picture")),
    (
        "numbered",
        {"pose.txt": lambda text: "# a comment\n0 0 0 0 0 0 1\n1 2 3\n0 0 0 0 0 0 1\n"},
        ("pose.txt, line 3", "expected 7 finite numbers"),
    ),
    ("numbered", {"pose.txt": lambda text: text.splitlines()[0]}, ("1 poses for 3 pictures",)),
    ("redwood", {"camera_intrinsic.json": {"width": 640, "height": 480}}, ("640x480", "36x24")),
    (
        "redwood",
        {"trajectory.log": lambda text: "\n".join([text.splitlines()[0], "2 0 0 0", *text.splitlines()[2:]])},
        ("trajectory.log, line 1", "does more than turn"),
    ),
    ("tum", {"depth.txt": "1305031102.2 depth/0.png\n1305031102.3\n"}, ("depth.txt, line 2", "expected seconds")),
    ("tum", {"depth.txt": "5.0 depth/0.png\n"}, ("the clocks are 1.30503e+09 s apart",)),
    # The poses' clock is 10^9 s ahead.
    ("tum", {"groundtruth.txt": lambda text: text.replace("\n13", "\n23")}, ("clocks are 1e+09 s apart", "one clock")),
    (
        "traced",
        {"trajectory.txt": lambda text: text.replace("\n17", "\n27")},
        ("clocks are 1e+09 s apart", "one clock"),
    ),
    ("npz", {"frame-1.npz": {"time_s": None}}, ("frame-1.npz: no time_s",)),
    (
        "nerfstudio",
        {"transforms.json": {"integer_depth_scale": 0.002, "depth_unit_scale_factor": 0.001}},
        ("0.001 and integer_depth_scale 0.002 differ", "--depth-scale"),
    ),
    (
        "nerfstudio",
        {"transforms.json": lambda data: [renamed(one, "depth_file_path", "depth_map_name") for one in data["frames"]]},
        ("depth_map_name is not read, depth_file_path or depth_path is",),
    ),
    (
        "nerfstudio",
        {"transforms.json": lambda data: turned_over(data["frames"][1])},
        ("matrix 0 is written by rows and matrix 1 by columns",),
    ),
    ("nerfstudio", {"transforms.json": {"is_fisheye": True}}, ("is_fisheye is true",)),
    (
        "numbered",
        {"camera.json": json.dumps({"K": [[40, 0.5, 18], [0, 42, 12], [0, 0, 1]], "depth_scale": 0.001})},
        ("camera.json: K has a skew of 0.5",),
    ),
    ("pictures", {"0.depth.png": lambda depth: depth[:, ::2]}, ("0.depth.png", "of another shape")),
    # A scale of 0 was metres, one of 1000 units a metre kilometres, an unknown encoding light.
    *(
        ("npz", {"*.npz": {"depth_scale": scale}}, ("frame-0.npz: depth_scale",))
        for scale in (0.0, -0.001, np.nan, 1e3)
    ),
    ("npz", {"*.npz": {"encoding": "rec709"}}, ("frame-0.npz: ", "encoding")),
    ("npz", {"*.npz": lambda data: data.update(time_s=data["time_s"] * 1e9)}, ("s apart", "unit")),
    ("npz", {"*.npz": lambda data: data.update(time_s=data["time_s"] * 1e-6)}, ("s apart", "unit")),
]
LENSES = [
    ({"k1": 0.05}, "k1 is 0.05"),
    ({"p2": -0.001}, "p2 is -0.001"),
    ({"camera_model": "OPENCV_FISHEYE"}, "camera model OPENCV_FISHEYE"),
    ({"distortion": [0, 0, 0.1]}, "distortion[2] is 0.1"),
]
# By form: files that are changed, what the user says, and words of the error.
UNSAID = [
    ("numbered", {}, None, ("--intrinsics FX,FY,CX,CY", "camera.json")),
    ("numbered", {}, STATED, ("--depth-scale",)),
    ("redwood", {"camera_intrinsic.json": None}, None, ("640x480 pixels, its pictures have 36x24", "--intrinsics FX")),
    ("colmap", {}, None, ("--depth-scale",)),  # its own stereo is in the unit of its poses
    *((form, {}, MIRRORED, ("fy is -42; expected above 0",)) for form in ("tartanair", "stray_scanner", "rtabmap")),
    *(
        (form, {}, options, words)
        for form in ("tum", "icl_nuim")  # the numbers of a layout are for its own pictures
        for options, words in (
            (None, ("36x24", "is for 640x480", "--intrinsics FX,FY,CX,CY --depth-scale METRES", "camera.json")),
            (STATED, ("36x24", "give --depth-scale METRES")),
            (attrs.evolve(AS_TUM, intrinsics=None), ("36x24", "give --intrinsics FX,FY,CX,CY")),
        )
    ),
    *(
        (form, {}, SequenceOptions(), (f"for {size} pixels, its pictures have 36x24",))
        for form, size in (("tartanair", "640x480"), ("tartanair_v2", "640x640"), ("seven_scenes", "640x480"))
    ),
    *(
        ("replica", {}, SequenceOptions(**{option: "openxr"}), (f"{flag}: layout replica does not take it; {takes}",))
        for option, flag, takes in (
            ("frames_axes", "--frames-axes", "expected traced"),
            ("frames_topics", "--frames-topics", "expected rosbag"),
            ("frames_camera", "--frames-camera", "expected colmap, "),
        )
    ),
]


def grown(extrinsic: list[float]) -> None:
    extrinsic[:12] = [2 * x for x in extrinsic[:12]]


def renamed(data: dict, before: str, after: str) -> None:
    data[after] = data.pop(before)


def turned_over(frame: dict) -> None:
    frame["transform_matrix"] = np.array(frame["transform_matrix"]).T.tolist()


def ids(case: tuple) -> str:
    return f"{case[0]} {' '.join(case[1])} {case[-1][0][:24]}"


@pytest.mark.parametrize("case", WRONG, ids=ids)
def test_faults_are_named_in_one_line(case, tmp_path):
    form, edits, words = case
    folder = edited(tmp_path / "taken", form, edits, 3)
    refused(folder, *words, options=attrs.evolve(FORMS[form].options, layout=FORMS[form].reader))


@pytest.mark.parametrize("case", UNSAID, ids=ids)
def test_what_nothing_says_is_requested_by_its_option(case, tmp_path):
    form, edits, options, words = case
    refused(edited(tmp_path / "taken", form, edits), *words, options=options)


@pytest.mark.parametrize(("lens", "named"), LENSES)
def test_lens_distortion_is_refused_by_its_name(lens, named, tmp_path):
    refused(edited(tmp_path / "nerf", "nerfstudio", {"transforms.json": lens}), named, "undistort")
    folder = edited(tmp_path / "numbered", "numbered", {"camera.json": json.dumps(CAMERA | lens)})
    refused(folder, named, "undistort")


def test_what_is_refused_can_be_said(tmp_path):
    """By the option that the refusal names, or by the file."""
    both = {"transforms.json": {"integer_depth_scale": 0.002, "depth_unit_scale_factor": 0.001}}
    late = {"*.npz": lambda data: data.update(time_s=data["time_s"] * 1e9)}
    for form, edits, options in (
        ("nerfstudio", both, SequenceOptions(depth_scale=0.001)),
        ("numbered", {"camera.json": json.dumps(CAMERA)}, None),
        ("npz", late, SequenceOptions(frames_rate_hz=30)),
    ):
        assert len(sequences.open(edited(tmp_path / form, form, edits, 3), options).frames) == 3
    folder = edited(tmp_path / "scaled", "numbered", {"camera.json": json.dumps(CAMERA | {"depth_scale": 1000.0})})
    refused(folder, "camera.json: depth_scale is", options=attrs.evolve(MILLIMETRES, depth_scale=None))


@pytest.mark.parametrize(
    ("said", "message"),
    [
        ({"crop": -1}, "--crop -1 px: expected a whole number of at least 0"),
        ({"no_depth": "sky"}, "--no-depth 'sky': expected hole or far"),
    ],
)
def test_options_that_cannot_be_meant(said, message):
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
