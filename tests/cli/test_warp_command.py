"""hmdwarp warp: somebody's RGB-D frame in a file, to another pose, into a file."""

from __future__ import annotations

import json
import math
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

FOV = [-math.atan(0.5), math.atan(0.5), -math.atan(0.4), math.atan(0.4)]
POSE = {"fov": FOV, "position_m": [0.0, 0.0, 0.0], "orientation_xyzw": [0.0, 0.0, 0.0, 1.0]}


RAW = {"depth_m": np.full((8, 10), 2000, np.uint16)}  # millimetres
GAPS = {"depth_m": np.where(np.indices((8, 10))[0] < 3, 0, 2000).astype(np.uint16), "depth_scale": 0.001}
GAPS["depth_m"][3, 3] = 65535
HOLE = {"depth_m": np.where((np.indices((8, 10)) // 3 == 1).all(axis=0), 0, 2.0)}  # of 9 pixels
LIGHT, LONG = {"colour": np.full((8, 10, 3), 0.5, np.float32)}, {"orientation_xyzw": [0, 0, 0, 2]}


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


def test_a_step_to_the_right_moves_the_picture_left(warp, tmp_path):
    """1 m wide at 1 m, 10 pixels: a pixel is 0.2 m on the plane 2 m away, so 0.4 m are 2 pixels."""
    warp(None, {"position_m": [0.4, 0.0, 0.0]}, "--fill", "none", out="out.png").done()
    picture = np.asarray(Image.open(tmp_path / "out.png"))
    assert picture.shape == (8, 10, 4)
    assert np.array_equal(picture[:, :8, :3], arrays()["colour"][:, 2:])
    assert (picture[:, :8, 3] == 255).all() and (picture[:, 8:, 3] == 0).all()


def test_a_result_is_not_overwritten(warp, tmp_path):
    (tmp_path / "out.npz").write_bytes(b"precious")
    warp().refused("out.npz exists already", "--force")
    assert (tmp_path / "out.npz").read_bytes() == b"precious"
    warp(None, None, "--force").done()
    assert len(np.load(tmp_path / "out.npz")) == 8


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
        (LONG, {}, [], "frame.npz: orientation_xyzw has length 2; expected 1 within 0.01"),
        ({}, LONG, [], "pose.json: orientation_xyzw has length 2; expected 1 within 0.01"),
        (RAW, {}, [], "depth_m is uint16, of unknown unit"),
        ({"depth_scale": [1, 2]}, {}, [], "frame.npz: depth_scale"),
        (RAW, {}, ["--no-depth", "far"], "of unknown unit"), (GAPS, {}, ["--no-depth", "sky"], "expected hole or far"),
        (GAPS, {}, ["--no-depth", "far", "--depth-scale", -1], "depth_scale is -1"),
        ({"colour": np.full((8, 10, 3), 200.0)}, {}, [], "linear light has 1 for white"),
        ({}, {}, ["--repair", "compleet"], "unknown repair 'compleet': did you mean 'complete'"),
        ({}, {}, ["--repair", "complete:least=7"], "least is 7: expected 0 to 1"),
    ],
)  # fmt: skip
def test_inputs_that_do_not_fit_are_refused(frame, pose, options, told, warp, tmp_path):
    warp(frame, pose, *options).refused(told)
    assert not (tmp_path / "out.npz").exists()


MILLIMETRES = "--depth-scale 0.001 takes it as millimetres: 2 m"
TOLD = {
    "a frame": ({}, {}, [], ["0.00 % holes"], ["check", "note:", "Assumed"]),
    "nothing is seen": ({"position_m": [1600.0, 0, 0]}, {}, [], ["check depth_m and position_m"], []),
    "millimetres": (
        *({"depth_m": np.full((8, 10), 2000.0)}, {"position_m": [0.05, 0, 0]}, []),
        *(["The nearest surface is 2000 m away", MILLIMETRES], ["Assumed"]),
    ),
    "their scale": (
        *({"depth_m": np.full((8, 10), 2000.0)}, {"position_m": [0.05, 0, 0]}, ["--depth-scale", 0.001]),
        *([], ["note:"]),
    ),
    "light": (LIGHT, {}, [], ["Assumed (not stated in the files): encoding linear (float colour)"], []),
    "sRGB by the option": (LIGHT, {}, ["--encoding", "srgb"], [], ["Assumed"]),
    "sRGB by the frame": ({**LIGHT, "encoding": "srgb"}, {}, [], [], ["Assumed"]),
    "a hole": (HOLE, {}, ["--fill", "none"], ["11.25 % holes"], []),
    "a repaired one": (HOLE, {}, ["--fill", "none", "--repair", "edges+complete:colour=0.1"], ["0.00 %", "repair"], []),
    "no depth": (*(GAPS, {}, ["--fill", "none"], ["--no-depth far", "1 pixels (1.2 %) of its depth are 65535"], []),),
    "far": (GAPS, {}, ["--fill", "none", "--no-depth", "far"], ["0.00 % holes"], ["--no-depth"]),
    "names and size": ({}, {}, ["--warp", "rotation", "--fill", "interpolate", "--size", "21x17"], [], []),
}


@pytest.mark.parametrize("name", TOLD)
def test_what_is_done_and_noted_is_told(name, warp, tmp_path):
    frame, pose, options, told, untold = TOLD[name]
    done = warp(frame, pose, *options).done()
    assert all(done.out.count(text) == 1 for text in told) and not done.err, done
    assert not any(text in done.out for text in untold), done
    with np.load(tmp_path / "out.npz", allow_pickle=False) as data:
        holes = {"a hole": 9, "no depth": 31, "nothing is seen": 80}.get(name, 0)
        assert (data["coverage"] == 0).sum() == holes
        assert data["colour"].shape == ((17, 21, 3) if "size" in name else (8, 10, 3))
        assert data["encoding"] == "linear"  # a frame for the next warp
        if name == "a repaired one":
            assert np.array_equal(data["coverage"] < 1, HOLE["depth_m"] == 0)


STEP = {"position_m": [0.4, 0, 0]}
BYTES = arrays()["colour"] / 255


@pytest.mark.parametrize(
    ("frame", "options"),
    [
        (RAW, ["--depth-scale", "0.001"]),
        (RAW | {"depth_scale": 0.001}, []),
        (RAW | {"depth_scale": 5.0}, ["--depth-scale", "0.001"]),
        ({"colour": BYTES, "encoding": "srgb"}, []),
        ({"colour": BYTES, "encoding": "linear"}, ["--encoding", "srgb"]),
    ],
)
def test_an_option_is_stronger_than_a_key_of_the_frame(frame, options, warp, tmp_path):
    pictures = []
    for how in (({}, STEP), (frame, STEP, *options)):
        warp(*how, "--force", out="out.png").done()
        pictures.append((tmp_path / "out.png").read_bytes())
    assert pictures[0] == pictures[1]


@pytest.mark.parametrize("name", ["frame.npz", "pose.json"])
@pytest.mark.parametrize(
    "data", [None, b"", b"hello", b"\x80\x04N.", b"[]", b"\xff\xfe{}", b"1" * 6000, b"[" * 100_000]
)
def test_files_of_other_kinds(name, data, command, tmp_path):
    write_frame(tmp_path / "frame.npz"), write_pose(tmp_path / "pose.json")
    (tmp_path / name).unlink()
    if data is not None:
        (tmp_path / name).write_bytes(data)
    done = command("warp", tmp_path / "frame.npz", "--to", tmp_path / "pose.json", "--out", tmp_path / "o.npz")
    done.refused(str(tmp_path / name))
    assert "allow_pickle" not in done.err and "unsafe" not in done.err and not (tmp_path / "o.npz").exists()


def test_archives_of_other_things(command, tmp_path):
    whole, pose = write_frame(tmp_path / "frame.npz").read_bytes(), write_pose(tmp_path / "pose.json")
    for members in ({"readme.txt": b"hello"}, {f"{name}.npy": b"no array" for name in arrays()}):
        with zipfile.ZipFile(tmp_path / f"{len(members)}.npz", "w") as archive:
            for name, data in members.items():
                archive.writestr(name, data)
    (tmp_path / "cut.npz").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "tail.npz").write_bytes(whole[200:])
    for path in sorted(tmp_path.glob("*[!e].npz")):
        command("warp", path, "--to", pose, "--out", tmp_path / "o.npz").refused(str(path))


@pytest.mark.parametrize("out", ["out.gif", "out", "missing/out.npz"])
def test_where_it_cannot_be_written(out, warp, tmp_path):
    warp(out=out).refused(out)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["frame.npz", "pose.json"]


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


def test_what_a_file_has_is_listed_beside_what_it_lacks(warp_picture, tmp_path):
    (tmp_path / "a.json").write_text('{"intrinsics": [9, 9, 4, 4], "position_m": [0, 0, 0], "orientation_wxyz": []}')
    warp_picture().refused(
        "no orientation_xyzw in it; found intrinsics, position_m, orientation_wxyz; expected fov or intrinsics"
    )
