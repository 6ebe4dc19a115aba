"""hmdwarp warp: frames as PNG, JPEG and EXR files, and results in each form."""

from __future__ import annotations

import json
import sys
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from recorded_folders import CX, CY, FX, FY, HAS_EXR, SIZE, taken, write_exrs, write_npz, write_pictures

from hmdwarp.colour import srgb8_from_linear
from hmdwarp.errors import InputError
from hmdwarp.sources.sequences import read_colour, read_depth, read_frame

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
