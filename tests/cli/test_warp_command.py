"""hmdwarp warp: somebody's RGB-D frame in a file, to another pose, into a file."""

from __future__ import annotations

import io
import json
import math
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from hmdwarp.image import usable_fills, usable_warps

FOV = [-math.atan(0.5), math.atan(0.5), -math.atan(0.4), math.atan(0.4)]
POSE = {"fov": FOV, "position_m": [0.0, 0.0, 0.0], "orientation_xyzw": [0.0, 0.0, 0.0, 1.0]}


def arrays(**changes: object) -> dict[str, object]:
    rng = np.random.default_rng(4)
    whole = {"colour": rng.integers(0, 256, (8, 10, 3), dtype=np.uint8), "depth_m": np.full((8, 10), 2.0), **POSE}
    whole.update(changes)
    return {name: value for name, value in whole.items() if value is not None}


def write_frame(path: Path, **changes: object) -> Path:
    np.savez(path, **arrays(**changes))
    return path


def write_pose(path: Path, **changes: object) -> Path:
    path.write_text(
        json.dumps({name: value for name, value in {**POSE, **changes}.items() if value is not None}), encoding="utf-8"
    )
    return path


@pytest.fixture
def warp(command, tmp_path):
    """warp(frame changes, pose changes, *options) with files in tmp_path."""

    def call(frame: dict | None = None, pose: dict | None = None, *options: object, out: str = "out.npz"):
        write_frame(tmp_path / "frame.npz", **(frame or {}))
        write_pose(tmp_path / "pose.json", **(pose or {}))
        return command(
            "warp", tmp_path / "frame.npz", "--to", tmp_path / "pose.json", "--out", tmp_path / out, *options
        )

    return call


def test_a_quaternion_that_is_no_rotation_is_refused_in_both_inputs(warp):
    """As in a trace: 0.01 off is rounding, a length of 2 is a mistake."""
    long = {"orientation_xyzw": [0, 0, 0, 2]}
    warp(long).refused("frame.npz: orientation_xyzw has length 2; expected 1 within 0.01", "divide it")
    warp(None, long).refused("pose.json: orientation_xyzw has length 2; expected 1 within 0.01", "divide it")


def test_the_same_pose_gives_the_same_picture(warp, tmp_path):
    done = warp().done()
    assert "out.npz" in done.out and "0.00 % holes" in done.out
    with np.load(tmp_path / "out.npz", allow_pickle=False) as data:
        assert set(data) == {"colour", "coverage", "depth_m", "encoding", "time_ms", *POSE}
        from hmdwarp.colour import srgb8_from_linear

        assert np.array_equal(srgb8_from_linear(data["colour"]), arrays()["colour"])
        assert (data["coverage"] == 1).all()
        assert json.loads(str(data["time_ms"]))["warp"] > 0


def test_the_input_is_never_overwritten(command, tmp_path):
    write_frame(tmp_path / "frame.npz")
    write_pose(tmp_path / "pose.json")
    before = (tmp_path / "frame.npz").read_bytes()
    frame = tmp_path / "frame.npz"
    command("warp", frame, "--to", tmp_path / "pose.json", "--out", frame, "--force").refused("is the input itself")
    assert frame.read_bytes() == before


def test_a_picture_of_nothing_is_remarked_on(warp):
    """Millimetres for metres: the frame was drawn more than a kilometre away."""
    assert "check depth_m and position_m" in warp({"position_m": [1600.0, 0.0, 0.0]}).done().out
    assert "check" not in warp(None, None, "--force").done().out


def test_a_step_to_the_right_moves_the_picture_left(warp, tmp_path):
    """1 m wide at 1 m, 10 pixels: a pixel is 0.2 m on the plane 2 m away, so 0.4 m are 2 pixels."""
    warp(None, {"position_m": [0.4, 0.0, 0.0]}, "--fill", "none", out="out.png").done()
    picture = np.asarray(Image.open(tmp_path / "out.png"))
    assert picture.shape == (8, 10, 4)
    assert np.array_equal(picture[:, :8, :3], arrays()["colour"][:, 2:])
    assert (picture[:, :8, 3] == 255).all() and (picture[:, 8:, 3] == 0).all()


def test_integer_depth_needs_its_unit(warp, tmp_path):
    """By the option or by a key of the frame; the option is stronger."""
    millimetres = np.full((8, 10), 2000, np.uint16)
    warp({"depth_m": millimetres}).refused("depth_m is uint16, of unknown unit", "depth_scale")
    step, pictures = {"position_m": [0.4, 0.0, 0.0]}, []
    for frame, options in (
        ({}, []),
        ({"depth_m": millimetres}, ["--depth-scale", "0.001"]),
        ({"depth_m": millimetres, "depth_scale": 0.001}, []),
        ({"depth_m": millimetres, "depth_scale": 5.0}, ["--depth-scale", "0.001"]),
    ):
        warp(frame, step, *options, "--force", out="out.png").done()
        pictures.append((tmp_path / "out.png").read_bytes())
    assert pictures == pictures[:1] * 4
    warp({"depth_scale": [1, 2]}).refused("frame.npz: depth_scale")


def test_float_colour_says_its_encoding(warp, tmp_path):
    """By the option or by a key of the frame; the option is stronger."""
    colour = arrays()["colour"] / 255
    warp({"colour": colour * 255}).refused("linear light has 1 for white")
    for frame, options in (
        ({"colour": colour, "encoding": "srgb"}, []),
        ({"colour": colour, "encoding": "linear"}, ["--encoding", "srgb"]),
    ):
        warp(frame, None, *options, "--force", out="out.png").done()
        assert np.array_equal(np.asarray(Image.open(tmp_path / "out.png"))[..., :3], arrays()["colour"])


def test_help_names_what_can_work_on_one_frame(command):
    text = " ".join(command("warp", "--help").done().out.split())
    assert f" {', '.join(usable_warps())}. " in text
    assert f" {', '.join(usable_fills())}, or several with +. " in text


def test_a_result_is_not_overwritten(warp, tmp_path):
    (tmp_path / "out.npz").write_bytes(b"precious")
    warp().refused("out.npz exists already", "--force")
    assert (tmp_path / "out.npz").read_bytes() == b"precious"
    warp(None, None, "--force").done()
    assert len(np.load(tmp_path / "out.npz")) == 8


def test_size_and_names_are_taken(warp, tmp_path):
    warp(None, None, "--warp", "rotation", "--fill", "interpolate", "--size", "21x17").done()
    assert np.load(tmp_path / "out.npz")["colour"].shape == (17, 21, 3)


@pytest.mark.parametrize(
    ("frame", "pose", "options", "told"),
    [
        ({"depth_m": None}, {}, [], "no depth_m"), ({"colour": None, "fov": None}, {}, [], "no colour, fov"),
        ({"colour": np.zeros((8, 10))}, {}, [], "(8, 10)"),
        ({"depth_m": np.full((8, 10), "far")}, {}, [], "depth_m is <U3"),
        ({"colour": np.array([{}], dtype=object)}, {}, [], "frame.npz"),
        ({"fov": [1, 2, 3]}, {}, [], "frame.npz: fov"), ({"fov": ["a", "b", "c", "d"]}, {}, [], "frame.npz"),
        ({"position_m": [0, np.nan, 0]}, {}, [], "frame.npz"),
        ({"orientation_xyzw": [0, 0, 0, 0]}, {}, [], "frame.npz"), ({}, {"fov": None}, [], "no fov"),
        ({}, {"fov": [0.5, -0.5, -0.4, 0.4]}, [], "no field of view"),
        ({}, {"fov": [-1.6, 1.6, -1, 1]}, [], "no field of view"), ({}, {"fov": {"left": 1}}, [], "pose.json"),
        ({}, {"position_m": [1, 2]}, [], "pose.json"), ({}, {"position_m": "here"}, [], "pose.json"),
        ({}, {"orientation_xyzw": [1, 0, 0, [0]]}, [], "pose.json"),
        ({}, {"position_m": [10**400, 0, 0]}, [], "pose.json"), ({}, {}, ["--warp", "backward"], "geometry"),
        ({}, {}, ["--warp", "bakward"], "did you mean 'backward'?"),
        ({}, {}, ["--fill", "interpolation"], "did you mean 'interpolate'?"), ({}, {}, ["--size", "0x4"], "'0x4'"),
        ({}, {}, ["--size", "99999x4"], "99999x4"),
    ],
)  # fmt: skip
def test_inputs_that_do_not_fit_are_refused(frame, pose, options, told, warp, tmp_path):
    warp(frame, pose, *options).refused(told)
    assert not (tmp_path / "out.npz").exists()


@pytest.mark.parametrize("out", ["out.gif", "out", "missing/out.npz"])
def test_where_it_cannot_be_written(out, warp, tmp_path):
    warp(out=out).refused(out)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["frame.npz", "pose.json"]


def test_files_of_other_kinds(command, tmp_path):
    frame, pose = write_frame(tmp_path / "frame.npz"), write_pose(tmp_path / "pose.json")
    whole = frame.read_bytes()
    array = np.zeros(3)
    file = io.BytesIO()
    np.save(file, array)
    others = {
        "missing.npz": None,
        "empty.npz": b"",
        "cut.npz": whole[: len(whole) // 2],
        "text.npz": b"hello",
        "tail.npz": whole[200:],
        "array.npz": file.getvalue(),
        "pickle.npz": b"\x80\x04N.",
        "zip.npz": zip_bytes({"readme.txt": b"hello"}),
        "odd.npz": zip_bytes({"colour": b"no array"}),
        "lying.npz": zip_bytes({f"{name}.npy": b"no array" for name in arrays()}),
    }
    for name, data in others.items():
        path = tmp_path / name
        if data is not None:
            path.write_bytes(data)
        done = command("warp", path, "--to", pose, "--out", tmp_path / "o.npz")
        done.refused(str(path))
        assert "allow_pickle" not in done.err and "unsafe" not in done.err
    command("warp", tmp_path, "--to", pose, "--out", tmp_path / "o.npz").refused(str(tmp_path))
    for name, data in {
        "missing.json": None,
        "empty.json": b"",
        "half.json": b'{"fov": [1',
        "list.json": b"[]",
        "bytes.json": b"\xff\xfe{}",
        "number.json": b"1" * 6000,
        "deep.json": b"[" * 100_000,
    }.items():
        path = tmp_path / name
        if data is not None:
            path.write_bytes(data)
        command("warp", frame, "--to", path, "--out", tmp_path / "o.npz").refused(str(path))
    assert not (tmp_path / "o.npz").exists()


def zip_bytes(members: dict[str, bytes]) -> bytes:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        for name, data in members.items():
            archive.writestr(name, data)
    return file.getvalue()


def test_depth_is_repaired_where_asked_for(warp, tmp_path):
    """A gap is a hole; repaired it is seen, opaque in a picture, and its confidence in an array."""
    depth = np.full((8, 10), 2.0)
    depth[2:5, 3:6] = 0
    assert "11.25 % holes" in warp({"depth_m": depth}, None, "--fill", "none").done().out
    options = ("--fill", "none", "--repair", "edges+complete:colour=0.1", "--force")
    done = warp({"depth_m": depth}, None, *options).done()
    assert "0.00 % holes" in done.out and "repair" in done.out
    with np.load(tmp_path / "out.npz", allow_pickle=False) as data:
        assert np.array_equal(data["coverage"] < 1, depth == 0) and (data["coverage"] > 0).all()
    warp({"depth_m": depth}, None, *options, out="out.png").done()
    assert (np.asarray(Image.open(tmp_path / "out.png"))[..., 3] == 255).all()
    warp(None, None, "--force", "--repair", "compleet").refused("unknown repair 'compleet'", "did you mean 'complete'")
    warp(None, None, "--force", "--repair", "complete:least=7").refused("least is 7: expected 0 to 1")


def test_depth_in_millimetres_is_noted_once(warp, tmp_path):
    """Metres by the key of an .npz file; from an .npy file beside a picture nothing says so."""
    done = warp({"depth_m": np.full((8, 10), 2000.0)}, {"position_m": [0.05, 0, 0]}).done()
    assert done.out.count("The nearest surface is 2000 m away") == 1 and not done.err
    assert "--depth-scale 0.001 takes it as millimetres: 2 m" in done.out and "Assumed" not in done.out
    done = warp({"depth_m": np.full((8, 10), 2000.0)}, {"position_m": [0.05, 0, 0]}, "--depth-scale", 0.001, "--force")
    assert "note:" not in done.done().out


@pytest.fixture
def warp_picture(command, tmp_path):
    """Warps a picture with its depth, a PNG and an NPY file, and what a.json says of it."""
    Image.fromarray(arrays()["colour"]).save(tmp_path / "a.png")
    np.save(tmp_path / "a.depth.npy", np.full((8, 10), 2.0))
    where = ("--to", write_pose(tmp_path / "to.json"), "--out", tmp_path / "o.png")
    return lambda: command("warp", tmp_path / "a.png", *where)


def test_what_nothing_states_of_a_picture_is_noted(warp_picture, tmp_path):
    write_pose(tmp_path / "a.json", depth_offset=0.5)
    done = warp_picture().done()
    assert "note: Assumed (not stated in the files): depth scale 1 m per unit (override with --depth-scale)" in done.out
    assert "depth_offset is not read" in done.out


def test_float_colour_of_no_stated_encoding_is_noted(warp, tmp_path):
    light = {"colour": np.full((8, 10, 3), 0.5, np.float32)}
    assert "Assumed (not stated in the files): encoding linear (float colour)" in warp(light).done().out
    assert "Assumed" not in warp(light, None, "--encoding", "srgb", "--force").done().out
    assert "Assumed" not in warp({**light, "encoding": "srgb"}, None, "--force").done().out
    assert np.load(tmp_path / "out.npz")["encoding"] == "linear"  # a frame for the next warp, without a note


def test_what_a_file_has_is_listed_beside_what_it_lacks(warp_picture, tmp_path):
    (tmp_path / "a.json").write_text('{"intrinsics": [9, 9, 4, 4], "position_m": [0, 0, 0], "orientation_wxyz": []}')
    warp_picture().refused(
        "no orientation_xyzw in it; found intrinsics, position_m, orientation_wxyz; expected fov or intrinsics"
    )


def test_no_depth_is_far_where_it_is_stated(warp, tmp_path):
    depth = np.full((8, 10), 2000, np.uint16)
    depth[:3] = 0
    depth[3, 3] = 65535
    frame = {"depth_m": depth, "depth_scale": 0.001}
    done = warp(frame, None, "--fill", "none").done()
    assert "--no-depth far" in done.out and "1 pixels (1.2 %) of its depth are 65535" in done.out
    assert np.load(tmp_path / "out.npz")["coverage"].sum() == 49
    done = warp(frame, None, "--fill", "none", "--no-depth", "far", "--force").done()
    assert "--no-depth" not in done.out and np.load(tmp_path / "out.npz")["coverage"].all()
    warp(frame, None, "--no-depth", "sky", "--force").refused("--no-depth 'sky': expected hole or far")
    warp(frame, None, "--no-depth", "far", "--depth-scale", -1, "--force").refused("depth_scale is -1")
    warp({"depth_m": depth}, None, "--no-depth", "far", "--force").refused("of unknown unit")
