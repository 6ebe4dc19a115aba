"""What the files of a recording say is read: cameras, units, axes, clocks, and who says it."""

from __future__ import annotations

import io
import json
import re

import attrs
import numpy as np
import pytest
from PIL import Image
from recorded_folders import AS_TUM, CX, CY, FX, FY, MILLIMETRES, SIZE, fov_of, taken
from ros_bags import FORMS

from hmdwarp.errors import InputError
from hmdwarp.poses.assumptions import By
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import SequenceOptions, depth_notes, is_largest, parse_intrinsics, readers
from hmdwarp.sources.sequences.frame_files import camera_of

from .folders import blotted, edited, fact, made, refused

TRACED, COLMAP = FORMS["traced"].options, FORMS["colmap"].options


@pytest.fixture
def folder(tmp_path):
    """A folder whose parent belongs to the same test."""
    return tmp_path / "taken"


def widths(sequence) -> list[float]:
    return [frame.fov.tangents[1] - frame.fov.tangents[0] for frame in sequence.frames]


# --- cameras ---


@pytest.mark.parametrize(
    ("form", "size", "edits", "camera", "scale"),
    [
        ("tum", (640, 480), {}, By.DEFAULT, By.DEFAULT),
        ("tum/rgbd_dataset_freiburg1_desk", (640, 480), {}, By.FORMAT, By.FORMAT),  # stated by TUM's documents
        ("tum", SIZE, {"calibration.txt": f"{FX} {FY} {CX} {CY}\n"}, By.FILE, By.FORMAT),  # ETH3D
        ("tartanair", (640, 480), {}, By.FORMAT, By.FORMAT),
        ("tartanair_v2", (640, 640), {}, By.FORMAT, By.FORMAT),
        ("seven_scenes", (640, 480), {}, By.DEFAULT, By.FORMAT),  # others have taken over its names
    ],
)
def test_numbers_of_a_data_set_are_for_its_own_size(form, size, edits, camera, scale, tmp_path):
    form, _, name = form.partition("/")
    folder = tmp_path / (name or "taken")
    folder.mkdir()
    FORMS[form].write(folder, taken(2, size))
    for name, text in edits.items():
        (folder / name).write_text(text)
    found = sequences.open(folder)
    assert fact(found, "intrinsics")[1] is camera
    if form == "tum":
        assert fact(found, "depth scale") == ("0.0002 m per unit", scale)
        assert edits or fact(found, "intrinsics")[0] == "525,525,319.5,239.5 px for 640x480"
    left, right, down, up = found.frames[0].fov.tangents
    if edits:
        assert (left, right, down, up) == pytest.approx(fov_of().tangents)
    elif form.startswith("tartanair"):  # 90 degrees across, evenly about the middle
        assert (left, right) == pytest.approx((-1, 1)) and -down == pytest.approx(up)


K = np.array([[FX, 0, CX], [0, FY, CY], [0, 0, 1]])


@pytest.mark.parametrize("key", ["intrinsics", "intrinsic_matrix", "K", "camera_matrix"])
@pytest.mark.parametrize("form", ["rows", "flat rows", "columns", "flat columns"])
def test_the_zeros_say_how_intrinsics_are_written(key, form, tmp_path):
    matrix = K.T if "columns" in form else K
    stated = {key: (matrix.ravel() if "flat" in form else matrix).tolist(), "depth_scale": 0.001}
    edited(tmp_path, "numbered", {"camera.json": json.dumps(stated)})
    assert sequences.open(tmp_path).frames[0].fov.tangents == pytest.approx(fov_of().tangents)


def test_where_the_first_pixel_has_its_middle(folder):
    """As a file says; without a principal point it is the middle of the picture."""
    stated = {"w": 64, "h": 48, "fl_x": 50}
    found = [camera_of("it", stated, centre) for centre in (0.0, 0.5)]
    assert [(one.cx, one.cy) for one in found] == [(31.5, 23.5), (32, 24)]
    for centre in (0.0, 0.5):
        said = {"intrinsics": [FX, FY, CX + centre, CY + centre], "centre": centre, "fov": None}
        edited(folder, "npz", {"*.npz": said})
        assert sequences.open(folder).frames[0].fov.tangents == pytest.approx(fov_of().tangents, abs=1e-12)


@pytest.mark.parametrize("turned", [False, True])
def test_a_projection_matrix_states_the_camera(turned, folder):
    """That of the frames' own intrinsics, as OpenGL has it, by rows or columns."""
    wide, high = SIZE
    matrix = np.diag([2 * FX / wide, 2 * FY / high, -1.002, 0])
    matrix[:3, 2], matrix[2, 3], matrix[3, 2] = (1 - (2 * CX + 1) / wide, (2 * CY + 1) / high - 1, -1.002), -0.2, -1
    text = ",".join(map(repr, (matrix.T if turned else matrix).ravel().tolist()))
    stated = SequenceOptions(projection=sequences.parse_projection(text), depth_scale=1e-3)
    fov = sequences.open(made(folder, "numbered"), stated).frames[0].fov
    assert np.allclose(fov.tangents, fov_of().tangents, atol=1e-9)
    with pytest.raises(InputError, match="--projection '1,2': projection is .*16 numbers"):
        sequences.parse_projection("1,2")
    with pytest.raises(InputError, match="--intrinsics and --projection both state the camera"):
        attrs.evolve(stated, intrinsics=parse_intrinsics("1,1,0,0"))


@pytest.mark.parametrize("form", ["scannet", "twelve_scenes"])
def test_depth_of_fewer_pixels_goes_through_both_cameras(form, folder):
    """Every second pixel: the nearest to the colour's ray, and none beyond the depth's border."""
    made(folder, form, 1, stride=2)
    found, true = sequences.open(folder).frames[0].depth_m, taken(1)[0].depth_m
    row, column = (np.rint(np.arange(count) / 2).astype(int) for count in true.shape)
    inside = (row < 12)[:, None] & (column < 18)
    expected = np.where(inside, true[::2, ::2][row.clip(0, 11)[:, None], column.clip(0, 17)], 0)
    assert np.abs(found - expected).max() <= 0.5e-3 + 1e-6 and inside.mean() > 0.9


@pytest.mark.parametrize("form", ["stray_scanner", "pictures"])
def test_depth_of_a_telephone_has_fewer_pixels_than_its_video(form, folder):
    """Each covers two by two of the colour's pixels."""
    if form == "pictures":
        edited(folder, form, {"*.depth.png": lambda depth: depth[::2, ::2]})
    else:
        made(folder, form, 1, stride=2)
    found = sequences.open(folder).frames[0].depth_m
    assert np.array_equal(found, np.repeat(np.repeat(found[::2, ::2], 2, 0), 2, 1)) and found.shape == (24, 36)


def test_colour_that_was_shrunk_to_its_depth_has_the_camera_of_the_depth(folder):
    """Its own file is still that of the larger pictures; without another it is refused."""
    larger = "1170 0 648 0\n0 1170 484 0\n0 0 1 0\n0 0 0 1\n"
    edited(folder, "scannet", {"intrinsic/intrinsic_color.txt": larger}, 1)
    assert widths(sequences.open(folder)) == pytest.approx([36 / FX])
    (folder / "intrinsic/intrinsic_depth.txt").write_text(larger)
    refused(folder, "its centre at 648,484, which is not the middle of pictures of 36x24")


def test_a_focus_that_breathes_is_taken_in_the_middle(folder):
    """Within 0.5 % of the width at the border, and beyond it each frame has its own."""
    sequence = sequences.open(made(folder, "stray_scanner", 3, focus=(1.0, 1.002, 1.004)))
    assert widths(sequence) == pytest.approx([36 / FX / 1.002] * 3)
    assert len({frame.fov for frame in sequence.frames}) == 1
    assert "differ from frame to frame, by up to" in sequence.notes[0]
    made(folder, "stray_scanner", 3, focus=(1.0, 1.1, 1.2))
    assert widths(sequences.open(folder)) == pytest.approx([36 / FX, 36 / FX / 1.1, 36 / FX / 1.2])
    (folder / "depth/000001.png").unlink()  # a frame that is left out takes its own along
    assert widths(sequences.open(folder)) == pytest.approx([36 / FX, 36 / FX / 1.2])


@pytest.mark.parametrize("key", ["depth_offset", "pixel_offset_x", "rolling_shutter", "z_near"])
def test_unknown_keys_that_change_the_geometry_are_named(key, tmp_path):
    for at, (form, edits) in enumerate(
        (
            ("nerfstudio", {"transforms.json": {key: 0.5}}),
            ("nerfstudio", {"transforms.json": lambda data: data["frames"][-1].update({key: 0.5})}),
            ("redwood", {"camera_intrinsic.json": {key: 0.5, "maker": "mine"}}),
            ("pictures", {"0.json": {key: 0.5}}),
        )
    ):
        (note,) = sequences.open(edited(tmp_path / str(at), form, edits)).notes
        assert f"{key} is not read" in note and "maker" not in note


# --- poses ---

MATRIX_FORMS = {
    "nested rows": lambda m: m.tolist(), "flat rows": lambda m: m.ravel().tolist(),
    "three rows": lambda m: m[:3].tolist(), "nested columns": lambda m: m.T.tolist(),
    "flat columns": lambda m: m.T.ravel().tolist(), "three columns": lambda m: m[:3].T.tolist(),
    "flat three columns": lambda m: m[:3].T.ravel().tolist(),
}  # fmt: skip


@pytest.mark.parametrize("form", MATRIX_FORMS)
def test_the_zeros_say_how_poses_are_written(form, tmp_path):
    """The first frame is at the origin, where they say nothing: the second decides for both.
    nerfstudio's applied_scale is taken out of positions, as its own depth is multiplied by it."""

    def change(data):
        origin = np.array(data["frames"][0]["transform_matrix"])[:3, 3].copy()
        for frame in data["frames"]:
            matrix = np.array(frame["transform_matrix"])
            matrix[:3, 3] = 0.25 * (matrix[:3, 3] - origin)
            frame["transform_matrix"] = MATRIX_FORMS[form](matrix)
        data["applied_scale"] = 0.25

    found = sequences.open(edited(tmp_path, "nerfstudio", {"transforms.json": change}))
    for one, expected in zip(found.frames, taken(2), strict=True):
        moved = expected.pose.position_m - taken(1)[0].pose.position_m
        assert one.pose.isclose(attrs.evolve(expected.pose, position_m=moved), 1e-9)
    assert ("columns" in form) == ("by columns" in fact(found, "camera pose")[0])


def test_what_a_file_says_of_its_poses_is_told(folder):
    value, by = fact(sequences.open(made(folder, "open3d_scaled")), "camera pose")
    assert by is By.FILE and value.endswith("by columns, their scale of 2.5 divided out")
    length = fact(sequences.open(made(folder.parent / "colmap", "colmap"), COLMAP), "length")
    assert length == ("1 m per unit of the model, whose own is any", By.DEFAULT)


# --- which frames there are ---


@pytest.mark.parametrize(
    ("form", "edits", "left", "note"),
    [
        ("nerfstudio", {"transforms.json": lambda data: data["frames"][1].pop("depth_file_path")}, [0, 2, 3], ""),
        ("seven_scenes", {"*1*.txt": "nan " * 4 + "\n" + "nan nan nan nan\n" * 3}, [0, 2, 3], "finite numbers"),
        ("scannet", {"pose/1.txt": "-inf -inf -inf -inf\n" * 4}, [0, 2, 3], "no depth, or no pose of finite numbers"),
        ("colmap", {"depth/0001.png": None}, [0, 2, 3], "no picture or no depth"),
        (
            "tum",
            {"groundtruth.txt": lambda text: "\n".join(text.splitlines()[:6])},
            [0, 1],
            "no pose at their instants",
        ),
        (
            "traced",
            {"trajectory.txt": lambda text: "\n".join(text.splitlines()[:6])},
            [0, 1, 2],
            "no pose at their ins",
        ),
    ],
)
def test_frames_that_lack_something_are_left_out_and_counted(form, edits, left, note, folder):
    sequence = sequences.open(edited(folder, form, edits, 4), FORMS[form].options)
    for frame, i in zip(sequence.frames, left, strict=True):
        assert frame.pose.isclose(taken(4)[i].pose, 1e-9)
    assert any(f"{4 - len(left)} frames were left out" in one and note in one for one in sequence.notes)


@pytest.mark.parametrize(("cameras", "left"), [("11221", [0, 3, 4]), ("12345", [0, 1, 2, 3, 4])])
def test_of_two_cameras_of_colmap_one_is_chosen_but_not_of_one_for_each_image(cameras, left, folder):
    """The last image stands first in the file."""
    number = iter(cameras)
    others = "".join(f"{n} PINHOLE 36 24 40 40 18 12\n" for n in range(2, 6))
    edits = {
        "sparse/0/cameras.txt": lambda text: text + others,
        "sparse/0/images.txt": lambda text: re.sub(r" \d+ (\d+\.png)", lambda one: f" {next(number)} {one[1]}", text),
    }
    sequence = sequences.open(edited(folder, "colmap", edits, 5), COLMAP)
    assert [frame.name for frame in sequence.frames] == [f"{n:04}.png" for n in left]
    said = "2 frames of other cameras than 1 were left out, as it has most images; --frames-camera reads another (1: 3 "
    assert [note[: len(said)] for note in sequence.notes] == [said] * (len(left) == 3)
    options = attrs.evolve(COLMAP, frames_camera="2")
    second = [f"{n:04}.png" for n in range(5) if cameras[::-1][n] == "2"] if len(left) == 3 else ["0003.png"]
    assert [frame.name for frame in sequences.open(folder, options).frames] == second
    words = "--frames-camera is 7; expected one of its cameras: 1: "
    refused(folder, words, options=attrs.evolve(options, frames_camera="7"))


@pytest.mark.parametrize("name", ["cam{}_{:04}", "{1:04}_{0}", "frame{1}.{0}"])
def test_of_a_rig_of_cameras_the_user_names_one(name, folder):
    """Else it is refused with their names: each of six frames was one camera's or the other's."""
    first = {"trajectory.txt": lambda text: "".join(text.splitlines(keepends=True)[:4])}
    edited(folder, "traced", first, 6)
    pictures = {}
    for side in ("rgb", "depth"):
        for i, file in enumerate(sorted((folder / side).iterdir())):
            pictures[side, i] = file.read_bytes()
            file.rename(file.with_name(f"{name.format(('left', 'right')[i % 2], i // 2)}{file.suffix}"))
    for wanted in (None, "t", "middle"):
        with pytest.raises(InputError, match=f"--frames-camera is {wanted or 'not given'}; .*: .*left.*, .*right"):
            sequences.open(folder, attrs.evolve(TRACED, frames_camera=wanted))
    found = sequences.open(folder, attrs.evolve(TRACED, frames_camera="right"))
    assert [frame.colour.tobytes() for frame in found.frames] == [
        np.asarray(Image.open(io.BytesIO(pictures["rgb", i]))).tobytes() for i in (1, 3, 5)
    ]


@pytest.mark.parametrize("seed", range(12))
def test_colour_goes_with_the_depth_of_its_number_or_is_refused(seed, folder):
    """Names of several writers; where each lacks a frame of the other, equal counts say nothing."""
    made(folder, "traced", 8)
    of_colour = ("{:06}", "frame-{}", "rgb8_{:03}")[seed % 3]
    of_depth = ("{}", "depth_{:05}", "raw16-{}")[seed // 3 % 3]
    for side, name in (("rgb", of_colour), ("depth", of_depth)):
        for i, file in enumerate(sorted((folder / side).iterdir())):
            file.rename(file.with_name(f"{name.format(i + 8)}{file.suffix}"))
    (folder / "trajectory.txt").write_text("".join(f"{100 + i / 30} 0.0{i + 1} 0 0 0 0 0 1\n" for i in range(8)))
    found = sequences.open(folder, TRACED)
    for frame, one in zip(found.frames, taken(8), strict=True):
        assert np.abs(frame.depth_m - one.depth_m).max() <= 1e-3
    here, there = np.random.default_rng(seed).choice(8, 2, replace=False) + 8
    (folder / f"rgb/{of_colour.format(here)}.png").unlink()
    (folder / f"depth/{of_depth.format(there)}.png").unlink()
    with pytest.raises(InputError, match=f"7 pictures in rgb, 7 in depth, without depth .*{there}"):
        sequences.open(folder, TRACED)


# --- clocks ---


def test_a_denser_trajectory_is_the_motion_between_the_frames(tmp_path):
    """Poses at 90 Hz between frames at 30; the file's own clock is told."""
    track = sequences.open(made(tmp_path, "tum", 3), AS_TUM).track
    assert (len(track), track.start_ns, track.end_ns) == (7, 0, taken(3)[-1].time_ns)
    assert track.epoch_ns == 1305031102_175304000
    assert track.pose(1).isclose(taken(3)[0].pose.towards(taken(3)[1].pose, 1 / 3), 1e-9)


@pytest.mark.parametrize(
    ("times", "seconds"),
    [
        ([0, 0.25, 0.5, 1], [0, 0.025, 0.05, 0.1]),
        ([0, 0.25, 0.5, 0.75], [0, 1 / 30, 2 / 30, 0.1]),
        ([0, 0, 0, 0], [0, 1 / 30, 2 / 30, 0.1]),
        ([0, 1, 2, 3], [0, 1 / 30, 2 / 30, 0.1]),
        ([7.0, 7.05, 7.1, 7.2], [0, 0.05, 0.1, 0.2]),
        ([0, 0.05, 0.1, 0.2], [0, 0.05, 0.1, 0.2]),
    ],
)
def test_time_that_is_a_share_is_no_clock(times, seconds, tmp_path):
    """From 0 to 1, or to a step before 1: of a recording at 30 Hz. Other times are seconds."""
    stamped = {
        "transforms.json": lambda data: [one.update(time=t) for one, t in zip(data["frames"], times, strict=True)]
    }
    found = sequences.open(edited(tmp_path, "nerfstudio", stamped, 4))
    assert [frame.time_ns * 1e-9 for frame in found.frames] == pytest.approx(seconds, abs=1e-8)
    assert fact(found, "frame clock")[1] is By.DEFAULT


@pytest.mark.parametrize("unit", [1e3, 1e-2])
def test_instants_that_may_be_in_another_unit_are_named(unit, folder):
    """Milliseconds in place of seconds make frames half a minute apart."""
    late = {"*.npz": lambda data: data.update(time_s=data["time_s"] * unit)}
    (note,) = sequences.open(edited(folder, "npz", late, 3)).notes
    assert note.startswith("Frames are ") and "--frames-rate" in note


@pytest.mark.parametrize("per_second", [10**3, 10**6, 10**9])
def test_whole_numbers_are_instants_of_the_trace_in_the_unit_that_fits(per_second, folder):
    made(folder, "traced", 4)
    for file in [*folder.glob("*/*.png")]:
        file.rename(file.with_name(f"{round(float(file.stem) * per_second)}.png"))
    found = sequences.open(folder, TRACED)
    assert len(found.frames) >= 3 and found.rate_hz == pytest.approx(30, rel=0.03)


def test_a_trace_beside_pictures_gives_the_motion_between_them_and_who_says_its_axes(folder):
    sequence = sequences.open(made(folder, "traced", 3), TRACED)
    assert len(sequence.track) == 5
    assert fact(sequence, "camera axes") == ("x right, y down, z forward, of world and camera", By.DEFAULT)
    assert fact(sequence, "frame clock") == ("pictures are named by the trace's clock, in s", By.FILE)
    stated = sequences.open(folder, attrs.evolve(TRACED, frames_rate_hz=10.0))
    assert stated.rate_hz == pytest.approx(10) and stated.frames[2].pose.isclose(taken(3)[2].pose, 1e-9)
    edited(folder, "traced", {"trajectory.txt": lambda text: "# axes: opencv\n" + text}, 3)
    again = sequences.open(folder, TRACED)
    assert fact(again, "camera axes")[1] is By.FILE
    assert again.frames[2].pose.isclose(sequence.frames[2].pose, 1e-12)
    # Where a folder holds pictures, the bag in it is their trace.
    (folder / "trajectory.txt").rename(folder / "trajectory.bag")
    assert 0 < readers.get("rosbag").fits(folder) < readers.get("traced").fits(folder)


# --- colour and depth ---


def test_floats_are_light_and_bytes_are_srgb(folder):
    assert fact(sequences.open(made(folder, "npz")), "encoding") == ("sRGB (bytes)", By.FORMAT)
    edited(folder, "npz", {"*.npz": lambda data: data.update(colour=data["colour"] / 255)})
    assert fact(sequences.open(folder), "encoding") == ("linear (float colour)", By.DEFAULT)


@pytest.mark.parametrize(
    ("form", "said"),
    [
        ("nerfstudio", {"transforms.json": {"integer_depth_scale": 0.002}}),
        ("nerfstudio", {"transforms.json": {"depth_unit_scale_factor": 0.002}}),
        ("nerfstudio", {"transforms.json": {"depth_scale": 0.002}}),
        ("redwood", {"camera_intrinsic.json": {"depth_scale": 500.0}}),  # Open3D has units per metre
    ],
)
def test_the_depth_scale_that_a_file_states_is_read(form, said, tmp_path):
    found = sequences.open(edited(tmp_path, form, said))
    assert np.allclose(found.frames[0].depth_m, 2 * taken(1)[0].depth_m, atol=2e-3)
    assert fact(found, "depth scale")[1] is By.FILE


@pytest.mark.parametrize("key", ["depth_path", "depth"])
def test_depth_files_by_other_names_are_read(key, tmp_path):
    def change(data):
        for frame in data["frames"]:
            frame[key] = frame.pop("depth_file_path")

    found = sequences.open(edited(tmp_path, "nerfstudio", {"transforms.json": change}))
    assert np.abs(found.frames[0].depth_m - taken(1)[0].depth_m).max() < 1e-3
    assert fact(found, "depth scale")[1] is By.DEFAULT


@pytest.mark.parametrize("dtype", [np.uint16, np.int16, np.int32, np.uint32])
def test_the_largest_integer_is_no_measurement(dtype, tmp_path):
    def change(data):
        depth = np.rint(data["depth_m"] * 1000).astype(dtype)
        depth[3:5, 4:9], depth[9, 9] = np.iinfo(dtype).max, np.iinfo(dtype).max - 1
        data.update(depth_m=depth, depth_scale=0.001)

    found = sequences.open(edited(tmp_path, "npz", {"frame-0.npz": change}, 1)).frames[0].depth_m
    assert (found[3:5, 4:9] == 0).all() and found[9, 9] > 30


def test_the_largest_of_sixteen_bits_is_none_in_a_picture_or_a_wider_type(tmp_path):
    """But where the wider type is used: 70 m in millimetres are measured."""
    assert is_largest(np.array([1, 65535, 65534], np.int32)).tolist() == [False, True, False]
    assert not is_largest(np.array([1, 65535, 70000], np.int64)).any()
    assert not is_largest(np.array([1.0, 65535.0])).any()
    edited(tmp_path, "numbered", {"depth/0.png": blotted(slice(5, 8), slice(6, 12), 65535)}, 1)
    found = sequences.open(tmp_path, MILLIMETRES).frames[0].depth_m
    assert (found[5:8, 6:12] == 0).all() and found.max() < 10
    far = sequences.open(tmp_path, attrs.evolve(MILLIMETRES, no_depth="far")).frames[0].depth_m
    assert np.isinf(far[5:8, 6:12]).all() and np.isinf(far).sum() == (found == 0).sum()


@pytest.mark.parametrize("most", [4095, 4000])
def test_a_pgm_keeps_its_values_and_its_largest_of_whole_bits_is_no_measurement(most, tmp_path):
    """4095 is not spread over 16 bits; a writer's own largest value, 4000, is a depth."""
    made(tmp_path, "numbered", 1)
    depth = np.array(Image.open(tmp_path / "depth" / "0.png"))
    depth[3, 4] = most
    (tmp_path / "depth" / "0.png").unlink()
    head = f"P5\n# made by hand\n36 24\n{most}\n".encode()
    (tmp_path / "depth" / "0.pgm").write_bytes(head + depth.astype(">u2").tobytes())
    sequence = sequences.open(tmp_path, MILLIMETRES)
    assert np.array_equal(np.rint(sequence.frames[0].depth_m * 1000), np.where(depth == 4095, 0, depth))
    (note,) = depth_notes(sequence) or [""]
    assert note.startswith("1 pixels") == (most == 4095) and ("of a PGM's" in note) == (most == 4095)


@pytest.mark.parametrize("no_depth", ["hole", "far"])
def test_no_depth_is_far_or_a_hole_and_what_is_transparent_has_none(no_depth, tmp_path):
    def transparent(colour: np.ndarray) -> np.ndarray:
        alpha = np.full(colour.shape[:2], 255, np.uint8)
        alpha[3, 4] = 0
        return np.dstack([colour, alpha])

    edited(tmp_path, "pictures", {"0.png": transparent}, 1)
    picture, depth = sequences.open(tmp_path, SequenceOptions(no_depth=no_depth)).frames[0].read()
    assert picture.shape == (24, 36, 3) and np.isnan(depth[3, 4]) and np.isnan(depth).sum() == 1
    assert np.isinf(depth[0, 0]) == (no_depth == "far") and (depth[0, 0] == 0) == (no_depth == "hole")
    assert (depth > 0).sum() == SIZE[0] * SIZE[1] - 1 - (no_depth == "hole")
