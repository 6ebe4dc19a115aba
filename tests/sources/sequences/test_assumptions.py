"""Facts of recordings: each is an entry with who says so, and what files say is read."""

from __future__ import annotations

import json
from pathlib import Path

import attrs
import numpy as np
import pytest
from PIL import Image
from published_folders import PUBLISHED, Form
from recorded_folders import (
    AS_TUM,
    CX,
    CY,
    FX,
    FY,
    HAS_EXR,
    LAYOUTS,
    MILLIMETRES,
    SIZE,
    STATED,
    fov_of,
    taken,
    write_icl_nuim,
    write_nerfstudio,
    write_npz,
    write_numbered,
    write_pictures,
    write_redwood,
    write_tum,
)
from ros_bags import BAGS, HAS_ROSBAGS

from hmdwarp.errors import InputError
from hmdwarp.poses.assumptions import Assumption, By
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import FACTS, Sequence, SequenceOptions, is_largest, parse_intrinsics, readers

DEFAULTS = SequenceOptions()
FORMS = {name: Form(*facts) for name, facts in LAYOUTS.items()} | PUBLISHED | BAGS


def fact(sequence: Sequence, what: str) -> Assumption:
    (found,) = [assumption for assumption in sequence.assumptions if assumption.what == what]
    return found


@pytest.mark.parametrize("reader", list(readers), ids=lambda reader: reader.name)
def test_every_layout_says_what_it_assumes(reader):
    assert [assume.what for assume in reader.assumes if assume.what in FACTS] == list(FACTS)
    assert all(assume.value and isinstance(assume.by, By) for assume in reader.assumes)


@pytest.mark.parametrize("name", FORMS)
def test_every_recording_says_who_states_each_fact(name, tmp_path):
    """Each fact is one entry; what an option states is the user's, and the others are not."""
    if name == "exr" and not HAS_EXR:
        pytest.skip("OpenEXR is not installed (pip install '.[exr]')")
    if name in BAGS and not HAS_ROSBAGS:
        pytest.skip("rosbags is not installed (pip install '.[bags]')")
    write, options = FORMS[name].write, FORMS[name].options
    write(tmp_path, taken(2))
    found = sequences.open(tmp_path, options)
    assert set(FACTS) <= {assumption.what for assumption in found.assumptions}
    assert len({assumption.what for assumption in found.assumptions}) == len(found.assumptions)
    by = {assumption.what: assumption.by for assumption in found.assumptions}
    assert (by["intrinsics"] is By.USER) == (options.intrinsics is not None)
    assert (by["depth scale"] is By.USER) == (options.depth_scale is not None)
    assert (by["frame clock"] is By.USER) == (options.frames_rate_hz is not None) and by["no depth"] is not By.USER
    stated = attrs.evolve(options, frames_rate_hz=12.0, no_depth="far")
    by = {assumption.what: assumption.by for assumption in sequences.open(tmp_path, stated).assumptions}
    assert by["no depth"] is By.USER and (
        by["frame clock"] is By.USER or "rate" not in fact(found, "frame clock").option
    )


@pytest.mark.parametrize("write", [write_tum, write_icl_nuim], ids=["tum", "icl_nuim"])
def test_numbers_of_a_layout_are_for_its_own_pictures(write, tmp_path):
    """At another size each number that nothing states is requested by its option, at once."""
    write(tmp_path, taken(2))
    for options, words in (
        (DEFAULTS, ("36x24", "is for 640x480", "--intrinsics FX,FY,CX,CY --depth-scale METRES", "camera.json")),
        (attrs.evolve(AS_TUM, depth_scale=None), ("36x24", "give --depth-scale METRES")),
        (attrs.evolve(AS_TUM, intrinsics=None), ("36x24", "give --intrinsics FX,FY,CX,CY")),
    ):
        with pytest.raises(InputError) as caught:
            sequences.open(tmp_path, options)
        assert all(word in str(caught.value) for word in words), str(caught.value)


def test_the_default_camera_of_redwood_is_for_its_own_pictures(tmp_path):
    write_redwood(tmp_path, taken(2))
    (tmp_path / "camera_intrinsic.json").unlink()
    with pytest.raises(InputError, match="640x480 pixels, its pictures have 36x24: give .* --intrinsics FX,FY,CX,CY"):
        sequences.open(tmp_path)
    assert fact(sequences.open(tmp_path, STATED), "intrinsics").by is By.USER


@pytest.mark.parametrize(("folder", "by"), [("mine", By.DEFAULT), ("rgbd_dataset_freiburg1_desk", By.FORMAT)])
def test_numbers_of_the_right_size_are_still_only_assumed(folder, by, tmp_path):
    """Those of TUM's own recordings are stated by its documents."""
    write_tum(tmp_path / folder, taken(2, (640, 480)))
    found = sequences.open(tmp_path / folder)
    assert (fact(found, "intrinsics").value, fact(found, "intrinsics").by) == ("525,525,319.5,239.5 px for 640x480", by)
    assert (fact(found, "depth scale").value, fact(found, "depth scale").by) == ("0.0002 m per unit", by)


def test_eth3d_states_its_camera(tmp_path):
    write_tum(tmp_path, taken(2))
    (tmp_path / "calibration.txt").write_text(f"{FX} {FY} {CX} {CY}\n")
    found = sequences.open(tmp_path)
    assert found.frames[0].fov.tangents == pytest.approx(fov_of().tangents)
    assert fact(found, "intrinsics").by is By.FILE and fact(found, "depth scale").by is By.FORMAT


def rewritten(folder: Path, change, name: str = "transforms.json") -> Path:
    """Write two frames of nerfstudio, and change the data of its file."""
    folder.mkdir(exist_ok=True)
    write_nerfstudio(folder, taken(2))
    data = json.loads((folder / name).read_text())
    change(data)
    (folder / name).write_text(json.dumps(data))
    return folder


def depth_of(folder: Path) -> np.ndarray:
    return sequences.open(folder).frames[0].depth_m


@pytest.mark.parametrize("key", ["integer_depth_scale", "depth_unit_scale_factor", "depth_scale"])
def test_the_depth_scale_in_transforms_is_read(key, tmp_path):
    found = sequences.open(rewritten(tmp_path, lambda data: data.update({key: 0.002})))
    assert np.allclose(found.frames[0].depth_m, 2 * taken(1)[0].depth_m, atol=2e-3)
    assert fact(found, "depth scale").by is By.FILE


def test_two_depth_scales_that_differ_are_refused(tmp_path):
    rewritten(tmp_path, lambda data: data.update(integer_depth_scale=0.002, depth_unit_scale_factor=0.001))
    with pytest.raises(InputError, match=r"0.001 and integer_depth_scale 0.002 differ.*--depth-scale"):
        sequences.open(tmp_path)
    assert sequences.open(tmp_path, SequenceOptions(depth_scale=0.001)).frames


@pytest.mark.parametrize("key", ["depth_path", "depth"])
def test_depth_files_by_other_names_are_read(key, tmp_path):
    def change(data):
        for frame in data["frames"]:
            frame[key] = frame.pop("depth_file_path")

    folder = rewritten(tmp_path, change)
    assert np.abs(depth_of(folder) - taken(1)[0].depth_m).max() < 1e-3
    assert fact(sequences.open(folder), "depth scale").by is By.DEFAULT


def test_a_depth_key_that_is_not_read_is_named(tmp_path):
    def change(data):
        for frame in data["frames"]:
            frame["depth_map_name"] = frame.pop("depth_file_path")

    rewritten(tmp_path, change)
    with pytest.raises(InputError, match="depth_map_name is not read, depth_file_path or depth_path is"):
        sequences.open(tmp_path)


MATRIX_FORMS = {
    "nested rows": lambda m: m.tolist(), "flat rows": lambda m: m.ravel().tolist(),
    "three rows": lambda m: m[:3].tolist(), "nested columns": lambda m: m.T.tolist(),
    "flat columns": lambda m: m.T.ravel().tolist(), "three columns": lambda m: m[:3].T.tolist(),
    "flat three columns": lambda m: m[:3].T.ravel().tolist(),
}  # fmt: skip


@pytest.mark.parametrize("form", MATRIX_FORMS)
def test_the_zeros_say_how_poses_are_written(form, tmp_path):
    """The first frame is at the origin, where they say nothing: the second decides for both."""

    def change(data):
        origin = np.array(data["frames"][0]["transform_matrix"])[:3, 3].copy()
        for frame in data["frames"]:
            matrix = np.array(frame["transform_matrix"])
            matrix[:3, 3] -= origin
            frame["transform_matrix"] = MATRIX_FORMS[form](matrix)

    found = sequences.open(rewritten(tmp_path, change))
    for one, expected in zip(found.frames, taken(2), strict=True):
        moved = expected.pose.position_m - taken(1)[0].pose.position_m
        assert one.pose.isclose(attrs.evolve(expected.pose, position_m=moved), 1e-9)
    assert ("columns" in form) == ("by columns" in fact(found, "camera pose").value)


def test_matrices_in_both_ways_are_refused(tmp_path):
    def change(data):
        data["frames"][1]["transform_matrix"] = np.array(data["frames"][1]["transform_matrix"]).T.tolist()

    rewritten(tmp_path, change)
    with pytest.raises(InputError, match="matrix 0 is written by rows and matrix 1 by columns"):
        sequences.open(tmp_path)


def test_a_trajectory_by_columns_is_read(tmp_path):
    write_redwood(tmp_path, taken(3))
    lines = (tmp_path / "trajectory.log").read_text().splitlines()
    for at in range(0, len(lines), 5):
        matrix = np.array([line.split() for line in lines[at + 1 : at + 5]])
        lines[at + 1 : at + 5] = [" ".join(row) for row in matrix.T]
    (tmp_path / "trajectory.log").write_text("\n".join(lines))
    for one, expected in zip(sequences.open(tmp_path).frames, taken(3), strict=True):
        assert one.pose.isclose(expected.pose, 1e-9)


K = np.array([[FX, 0, CX], [0, FY, CY], [0, 0, 1]])


@pytest.mark.parametrize("key", ["intrinsics", "intrinsic_matrix", "K", "camera_matrix"])
@pytest.mark.parametrize("form", ["rows", "flat rows", "columns", "flat columns"])
def test_the_zeros_say_how_intrinsics_are_written(key, form, tmp_path):
    write_numbered(tmp_path, taken(1))
    matrix = K.T if "columns" in form else K
    stated = {key: (matrix.ravel() if "flat" in form else matrix).tolist(), "depth_scale": 0.001}
    (tmp_path / "camera.json").write_text(json.dumps(stated))
    assert sequences.open(tmp_path).frames[0].fov.tangents == pytest.approx(fov_of().tangents)


def test_a_matrix_with_skew_is_refused(tmp_path):
    write_numbered(tmp_path, taken(1))
    skewed = K + [[0, 0.5, 0], [0, 0, 0], [0, 0, 0]]
    (tmp_path / "camera.json").write_text(json.dumps({"K": skewed.tolist(), "depth_scale": 0.001}))
    with pytest.raises(InputError, match=r"camera.json: K has a skew of 0.5"):
        sequences.open(tmp_path)


@pytest.mark.parametrize(
    ("times", "seconds", "by"),
    [
        ([0, 0.25, 0.5, 1], [0, 0.025, 0.05, 0.1], By.DEFAULT),
        ([0, 0.25, 0.5, 0.75], [0, 1 / 30, 2 / 30, 0.1], By.DEFAULT),
        ([0, 0, 0, 0], [0, 1 / 30, 2 / 30, 0.1], By.DEFAULT),
        ([0, 1, 2, 3], [0, 1 / 30, 2 / 30, 0.1], By.DEFAULT),
        ([7.0, 7.05, 7.1, 7.2], [0, 0.05, 0.1, 0.2], By.DEFAULT),
        ([0, 0.05, 0.1, 0.2], [0, 0.05, 0.1, 0.2], By.DEFAULT),
    ],
)
def test_time_that_is_a_share_is_no_clock(times, seconds, by, tmp_path):
    """From 0 to 1, or to a step before 1: of a recording at 30 Hz. Other times are seconds."""
    write_nerfstudio(tmp_path, taken(4))
    file = tmp_path / "transforms.json"
    data = json.loads(file.read_text())
    for frame, time in zip(data["frames"], times, strict=True):
        frame["time"] = time
    file.write_text(json.dumps(data))
    found = sequences.open(tmp_path)
    assert [frame.time_ns * 1e-9 for frame in found.frames] == pytest.approx(seconds, abs=1e-8)
    assert fact(found, "frame clock").by is by


@pytest.mark.parametrize("key", ["depth_offset", "pixel_offset_x", "rolling_shutter", "z_near"])
def test_unknown_keys_that_change_the_geometry_are_named(key, tmp_path):
    for change in (lambda data: data.update({key: 0.5}), lambda data: data["frames"][-1].update({key: 0.5})):
        (note,) = sequences.open(rewritten(tmp_path / "nerf", change)).notes
        assert f"{key} is not read" in note
    write_redwood(tmp_path / "redwood", taken(2))
    file = tmp_path / "redwood" / "camera_intrinsic.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), key: 0.5, "maker": "mine"}))
    (note,) = sequences.open(tmp_path / "redwood").notes
    assert f"{key} is not read" in note and "maker" not in note
    (tmp_path / "pictures").mkdir()
    write_pictures(tmp_path / "pictures", taken(1))
    file = tmp_path / "pictures" / "0.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), key: 0.5}))
    (note,) = sequences.open(tmp_path / "pictures").notes
    assert f"{key} is not read" in note


def test_other_cameras_in_transforms_are_refused(tmp_path):
    rewritten(tmp_path, lambda data: data.update(is_fisheye=True))
    with pytest.raises(InputError, match="is_fisheye is true"):
        sequences.open(tmp_path)


def test_depth_scale_of_open3d_is_units_per_metre(tmp_path):
    write_redwood(tmp_path, taken(2))
    file = tmp_path / "camera_intrinsic.json"
    file.write_text(json.dumps({**json.loads(file.read_text()), "depth_scale": 500.0}))
    found = sequences.open(tmp_path)
    assert np.allclose(found.frames[0].depth_m, 2 * taken(1)[0].depth_m, atol=2e-3)
    assert fact(found, "depth scale").by is By.FILE


@pytest.mark.parametrize("dtype", [np.uint16, np.int16, np.int32, np.uint32])
def test_the_largest_integer_is_no_measurement(dtype, tmp_path):
    write_npz(tmp_path, taken(1))
    with np.load(tmp_path / "frame-0.npz") as data:
        content = dict(data)
    depth = np.rint(content["depth_m"] * 1000).astype(dtype)
    depth[3:5, 4:9] = np.iinfo(dtype).max
    depth[9, 9] = np.iinfo(dtype).max - 1
    np.savez(tmp_path / "frame-0.npz", **{**content, "depth_m": depth, "depth_scale": 0.001})
    found = sequences.open(tmp_path).frames[0].depth_m
    assert (found[3:5, 4:9] == 0).all() and found[9, 9] > 30


def test_the_largest_of_sixteen_bits_is_none_in_a_wider_type():
    """Nor is it, where the type is used: 70 m in millimetres are measured."""
    assert is_largest(np.array([1, 65535, 65534], np.int32)).tolist() == [False, True, False]
    assert not is_largest(np.array([1, 65535, 70000], np.int64)).any()
    assert not is_largest(np.array([1.0, 65535.0])).any()


def test_the_largest_value_of_a_sixteen_bit_picture_is_no_measurement(tmp_path):
    write_numbered(tmp_path, taken(1))
    path = tmp_path / "depth" / "0.png"
    depth = np.array(Image.open(path))
    depth[5:8, 6:12] = 65535
    Image.fromarray(depth).save(path)
    found = sequences.open(tmp_path, MILLIMETRES).frames[0].depth_m
    assert (found[5:8, 6:12] == 0).all() and found.max() < 10
    far = sequences.open(tmp_path, attrs.evolve(MILLIMETRES, no_depth="far")).frames[0].depth_m
    assert np.isinf(far[5:8, 6:12]).all() and np.isinf(far).sum() == (found == 0).sum()


def test_no_depth_is_far_or_a_hole(tmp_path):
    with pytest.raises(InputError, match="--no-depth 'sky': expected hole or far"):
        SequenceOptions(no_depth="sky")
    write_pictures(tmp_path, taken(1))
    colour = np.array(Image.open(tmp_path / "0.png").convert("RGBA"))
    colour[3, 4, 3] = 0  # hidden pixels stay holes
    Image.fromarray(colour).save(tmp_path / "0.png")
    depth = sequences.open(tmp_path, SequenceOptions(no_depth="far")).frames[0].depth_m
    assert np.isinf(depth[0, 0]) and np.isnan(depth[3, 4]) and np.isfinite(depth).sum() == SIZE[0] * SIZE[1] - 2


def test_an_option_is_the_users(tmp_path):
    write_npz(tmp_path, taken(2))
    stated = SequenceOptions(intrinsics=parse_intrinsics("40,42,17.3,11.1"), depth_scale=1.0, frames_rate_hz=10)
    found = sequences.open(tmp_path, stated)
    assert {
        assumption.by
        for assumption in found.assumptions
        if assumption.what in ("intrinsics", "depth scale", "frame clock")
    } == {By.USER}
