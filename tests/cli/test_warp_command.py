"""hmdwarp warp: somebody's RGB-D frame in files, to another pose, into a file of any form."""

from __future__ import annotations

import json
import math
import sys
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from recorded_folders import CX, CY, FX, FY, HAS_EXR, SIZE, taken, write_exrs, write_npz, write_pictures

from hmdwarp.base import InputError, srgb8_from_linear
from hmdwarp.sources.sequences import read_colour, read_depth, read_frame

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
        from hmdwarp.base import srgb8_from_linear

        assert np.array_equal(srgb8_from_linear(data["colour"]), arrays()["colour"])
        assert (data["coverage"] == 1).all()
        assert json.loads(str(data["time_ms"]))["warp"] > 0
    told = json.loads(warp(None, None, "--json", "--force").done().out)
    assert told["hole_share"] == 0 < told["time_ms"]["warp"] and told["notes"] == [] and "out.npz" in told["out"]


def test_a_step_to_the_right_moves_the_picture_left(warp, tmp_path):
    """1 m wide at 1 m, 10 pixels: a pixel is 0.2 m on the plane 2 m away, so 0.4 m are 2 pixels."""
    warp(None, {"position_m": [0.4, 0.0, 0.0]}, "--fill", "none", out="out.png").done()
    picture = np.asarray(Image.open(tmp_path / "out.png"))
    assert picture.shape == (8, 10, 4)
    assert np.array_equal(picture[:, :8, :3], arrays()["colour"][:, 2:])
    assert (picture[:, :8, 3] == 255).all() and (picture[:, 8:, 3] == 0).all()


def test_a_result_is_overwritten_on_request_and_the_input_never(warp, tmp_path):
    (tmp_path / "out.npz").write_bytes(b"precious")
    warp().refused("out.npz exists already", "--force")
    assert (tmp_path / "out.npz").read_bytes() == b"precious"
    warp(None, None, "--force", out="frame.npz").refused("is the input itself")
    read_frame(tmp_path / "frame.npz")  # it is whole
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
            warp(frame, pose, *options, out="out.png").done()
            assert (picture(tmp_path / "out.png")[..., 3] == 255).all()


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


NEEDS_EXR = pytest.mark.skipif(not HAS_EXR, reason="OpenEXR is not installed (pip install '.[exr]')")
CAMERA = {"intrinsics": [FX, FY, CX, CY], "depth_scale": 0.001}


@pytest.fixture
def folder(tmp_path):
    """Two frames in each form, each with its own JSON, and the second's view as the one to show."""
    write_pictures(tmp_path, taken(2))
    for i in range(2):
        own = tmp_path / f"{i}.json"
        own.write_text(json.dumps({**json.loads(own.read_text()), **CAMERA}))
    write_npz(tmp_path, taken(2))
    return tmp_path


def picture(path: Path) -> np.ndarray:
    return np.asarray(Image.open(path))


def test_a_picture_with_depth_and_camera_is_the_same_as_an_npz(command, folder):
    """To half a millimetre of depth, a thousandth of a pixel here: bytes off by 1 at most."""
    to = ("--to", folder / "1.json")
    command("warp", folder / "frame-0.npz", *to, "--out", folder / "npz.png").done()
    command("warp", folder / "0.png", *to, "--out", folder / "beside.png").done()
    (folder / "elsewhere").mkdir()
    (folder / "0.depth.png").rename(folder / "elsewhere" / "z.png")
    (folder / "0.json").rename(folder / "elsewhere" / "camera.json")
    named = ("--depth", folder / "elsewhere" / "z.png", "--camera", folder / "elsewhere" / "camera.json")
    command("warp", folder / "0.png", *named, *to, "--out", folder / "named.png").done()
    assert np.array_equal(picture(folder / "beside.png"), picture(folder / "named.png"))
    off = np.abs(picture(folder / "npz.png").astype(int) - picture(folder / "beside.png"))
    assert picture(folder / "npz.png").shape == (*SIZE[::-1], 4) and off.max() <= 1


def test_a_jpeg_is_read_and_written(command, folder):
    """Its eight-pixel blocks cost this smooth picture a few steps of 256."""
    Image.fromarray(taken(1)[0].colour).save(folder / "0.jpg", quality=98, subsampling=0)
    command("warp", folder / "0.jpg", "--to", folder / "1.json", "--out", folder / "out.jpg").done()
    command("warp", folder / "0.png", "--to", folder / "1.json", "--out", folder / "out.png").done()
    jpeg, png = picture(folder / "out.jpg"), picture(folder / "out.png")
    assert jpeg.shape == (*SIZE[::-1], 3)
    assert np.median(np.abs(jpeg.astype(int) - png[..., :3])) <= 4


def test_a_written_npz_is_a_frame_again(command, folder):
    command("warp", folder / "0.png", "--to", folder / "1.json", "--out", folder / "one.npz", "--fill", "none").done()
    frame = read_frame(folder / "one.npz")
    known = np.isfinite(frame.depth_m)
    assert frame.view.pose.isclose(taken(2)[1].pose) and 0 < known.mean() < 1
    command("warp", folder / "one.npz", "--to", folder / "1.json", "--out", folder / "two.npz", "--fill", "none").done()
    with np.load(folder / "one.npz") as one, np.load(folder / "two.npz") as two:
        assert np.array_equal(one["coverage"] > 0, two["coverage"] > 0)
        assert np.array_equal(srgb8_from_linear(one["colour"]), srgb8_from_linear(two["colour"]))


@NEEDS_EXR
def test_exr_holds_light_and_depth_in_one_file(command, folder):
    """Read as the .npz is; written with A and Z. Half floats keep 11 bits: within 1 of 256."""
    write_exrs(folder, taken(2))
    command("warp", folder / "frame-0.npz", "--to", folder / "1.json", "--out", folder / "npz.npz").done()
    done = command("warp", folder / "0.exr", "--to", folder / "1.json", "--out", folder / "out.exr").done()
    assert "out.exr" in done.out
    (folder / "out.json").write_text((folder / "1.json").read_text())
    frame = read_frame(folder / "out.exr")
    with np.load(folder / "npz.npz") as data:
        off = srgb8_from_linear(frame.colour[..., :3]).astype(int) - srgb8_from_linear(data["colour"])
        assert np.abs(off).max() <= 1
        assert np.allclose(frame.depth_m, data["depth_m"], rtol=1e-5, equal_nan=True)
        assert np.array_equal(frame.colour[..., 3] > 0, data["coverage"] > 0)


@NEEDS_EXR
def test_exr_as_renderers_write_it(tmp_path):
    """Layers by name, 1e10 for the sky, a data window within the picture."""
    import OpenEXR

    shape, inner = (4, 6), (2, 3)
    channels = {f"View.Combined.{name}": np.full(inner, 0.25, np.float32) for name in "RGB"}
    channels |= {"View.Combined.A": np.full(inner, 0.5, np.float32), "View.Depth.Z": np.full(inner, 2.0, np.float32)}
    channels["View.Depth.Z"][0, 0] = 1e10
    windows = {"dataWindow": ((2, 1), (4, 2)), "displayWindow": ((0, 0), (5, 3))}
    OpenEXR.File(windows, channels).write(str(tmp_path / "0.exr"))
    (tmp_path / "0.json").write_text(json.dumps({**CAMERA, "position_m": [0, 0, 0], "orientation_xyzw": [0, 0, 0, 1]}))
    frame = read_frame(tmp_path / "0.exr")
    assert frame.colour.shape == (*shape, 4) and frame.depth_m[1, 2] == np.inf and frame.depth_m[2, 4] == 2
    assert (frame.colour[1:3, 2:5] == (0.5, 0.5, 0.5, 0.5)).all()  # divided by its alpha
    frame.colour[1:3, 2:5] = 0
    assert (frame.colour == 0).all()


@NEEDS_EXR
@pytest.mark.parametrize("before", ["", "ViewLayer."])
@pytest.mark.parametrize("own", ["", "right."])
@pytest.mark.parametrize("depth", ["Depth.{}Z", "Depth.{}V", "depth.{}Z"])
def test_passes_of_an_exr_are_taken_by_name(before, own, depth, tmp_path):
    """Depth is what is called so, of the view of the colour."""
    import OpenEXR

    views, file = {"multiView": ["left", "right"]}, str(tmp_path / "a.exr")
    combined = "" if before == "" else f"{before}Combined."
    channels = {f"{combined}{own}{name}": np.full((3, 4), 0.25, np.float32) for name in "RGB"}
    others = ("Normal.Z", "Position.Z", "Mist.V", "Denoising Depth.Z", "UV.V")
    channels |= {f"{before}{name}": np.ones((3, 4), np.float32) for name in others}
    for view, said in ((own, None), ("" if own else "right.", "of another"), (None, r"Normal\.Z.*expected depth")):
        there = {} if view is None else {f"{before}{depth.format(view)}": np.full((3, 4), 2.5, np.float32)}
        OpenEXR.File(views, channels | there).write(file)
        with pytest.raises(InputError, match=said) if said else nullcontext():
            assert (read_depth(tmp_path / "a.exr") == 2.5).all() and (read_colour(tmp_path / "a.exr") == 0.25).all()


def test_exr_without_its_package_says_how_to_get_it(command, folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "OpenEXR", None)
    (folder / "0.exr").write_bytes(b"v/1\x01")
    to = ("--to", folder / "1.json", "--out")
    for frame, out in (("0.exr", "out.png"), ("0.png", "out.exr")):
        done = command("warp", folder / frame, *to, folder / out)
        assert done.status == 3 and "pip install '.[exr]'" in done.err


def test_missing_inputs_are_named(command, folder):
    to = ("--to", folder / "1.json", "--out", folder / "out.png")
    frame = folder / "0.png"
    (folder / "0.depth.png").rename(folder / "z.png")
    command("warp", frame, *to).refused("no depth beside it", "--depth", "0.depth.png")
    command("warp", frame, "--depth", folder / "nowhere.png", *to).refused("nowhere.png: no such file")
    command("warp", frame, "--depth", frame, *to).refused("8 bits a channel")
    depth, own = ("--depth", folder / "z.png"), folder / "0.json"
    whole = json.loads(own.read_text())
    for change, *told in (
        ({"intrinsics": None}, "no fov", "0.json"),
        ({"intrinsics": [1, 2, 3]}, "expected 4 numbers"),
        ({"intrinsics": [FX, -FY, CX, CY]}, "fy is -42", "above 0"),
        ({"depth_scale": None}, "unknown unit", "depth_scale"),
        ({"k3": 0.1}, "k3 is 0.1", "undistort"),
        ({"width": 640, "height": 480}, "640x480", "36x24"),
    ):
        own.write_text(json.dumps({name: value for name, value in {**whole, **change}.items() if value is not None}))
        command("warp", frame, *depth, *to).refused(*told)
    own.unlink()
    command("warp", frame, *depth, *to).refused("0.json", "--camera", "intrinsics")
    command("warp", folder / "frame-0.npz", *depth, *to).refused("leave out --depth")
    command("warp", folder / "1.json", *to).refused("1.json", ".exr")
