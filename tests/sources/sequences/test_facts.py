"""How recordings are read: cameras, units, axes, clocks, which frames, and who says each.

`facts.txt` has it, case by case. After an intended change look at what differs, then write it:

    HMDWARP_GOLDEN=write .venv/bin/python -m pytest tests/sources/sequences/test_facts.py
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Callable
from pathlib import Path

import attrs
import numpy as np
import pytest
from recorded_folders import AS_TUM, CX, CY, FX, FY, MILLIMETRES, SIZE, fov_of, taken, write_npz
from ros_bags import FORMS, HAS_ROSBAGS, write_ros1, write_ros2

from hmdwarp.base import InputError
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import SequenceOptions, about_sky, about_unit, depth_notes, parse_intrinsics
from hmdwarp.sources.sequences.frame_files import camera_of

from .folders import blotted, edited, fact, made, refused

GOLDEN = Path(__file__).with_name("facts.txt")
TRACED, COLMAP, NONE = FORMS["traced"].options, FORMS["colmap"].options, SequenceOptions()
LARGER = "1170 0 648 0\n0 1170 484 0\n0 0 1 0\n0 0 0 1\n"  # intrinsics of the pictures before they were shrunk


@pytest.fixture
def folder(tmp_path):
    """A folder whose parent belongs to the same test."""
    return tmp_path / "taken"


def first_lines(count: int) -> Callable[[str], str]:
    return lambda text: "\n".join(text.splitlines()[:count])


def of_size(form: str, size: tuple[int, int], name: str = "") -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        (folder / name).mkdir(parents=True)
        FORMS[form].write(folder / name, taken(2, size))
        return folder / name

    return write


def changed(form: str, edits: dict, count: int = 2) -> Callable[[Path], Path]:
    return lambda folder: edited(folder, form, edits, count)


def timed(*times: float) -> Callable[[Path], Path]:
    def stamp(data: dict) -> None:
        for one, time in zip(data["frames"], times, strict=True):
            one["time"] = time

    return changed("nerfstudio", {"transforms.json": stamp}, len(times))


def named_by(per_second: int) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        made(folder, "traced", 4)
        for file in [*folder.glob("*/*.png")]:
            file.rename(file.with_name(f"{round(float(file.stem) * per_second)}.png"))
        return folder

    return write


def of_cameras(numbers: str) -> Callable[[Path], Path]:
    """COLMAP's images, each of a camera; the last image stands first in the file."""
    number = iter(numbers)
    others = "".join(f"{n} PINHOLE 36 24 40 40 18 12\n" for n in range(2, 6))
    edits = {
        "sparse/0/cameras.txt": lambda text: text + others,
        "sparse/0/images.txt": lambda text: re.sub(r" \d+ (\d+\.png)", lambda one: f" {next(number)} {one[1]}", text),
    }
    return changed("colmap", edits, len(numbers))


def of_a_rig(folder: Path) -> Path:
    """Each of six frames is the left camera's, or the right one's."""
    edited(folder, "traced", {"trajectory.txt": lambda text: "".join(text.splitlines(keepends=True)[:4])}, 6)
    for side in ("rgb", "depth"):
        for i, file in enumerate(sorted((folder / side).iterdir())):
            file.rename(file.with_name(f"cam{('left', 'right')[i % 2]}_{i // 2:04}{file.suffix}"))
    return folder


def deep(change: Callable[[np.ndarray], np.ndarray], count: int = 3) -> Callable[[Path], Path]:
    def write(folder: Path) -> Path:
        folder.mkdir(parents=True)
        write_npz(folder, [attrs.evolve(one, depth_m=change(one.depth_m.copy())) for one in taken(count, (96, 72))])
        return folder

    return write


def bag(write: Callable[..., None], **how: object) -> Callable[[Path], Path]:
    def made_of(folder: Path) -> Path:
        folder.mkdir(parents=True)
        write(folder, taken(2), **how)
        return folder

    return made_of


def sky_above(depth: np.ndarray) -> np.ndarray:
    depth[:30], depth[12:48, 36:42] = 0, 3  # a tower before it
    return depth


def largest(data: dict) -> None:
    depth = np.rint(data["depth_m"] * 1000).astype(np.int16)
    depth[3:5, 4:9], depth[9, 9] = 32767, 32766
    data.update(depth_m=depth, depth_scale=0.001)


def transparent(colour: np.ndarray) -> np.ndarray:
    alpha = np.full(colour.shape[:2], 255, np.uint8)
    alpha[3, 4] = 0
    return np.dstack([colour, alpha])


PART = slice(5, 8), slice(6, 12)
MIDDLE = np.pad(np.ones((1, 1), np.uint16), 1)  # of nine pixels
LACKS_DEPTH = {"transforms.json": lambda data: data["frames"][1].pop("depth_file_path")}
# What writes a folder, and with which options it is read.
CASES: dict[str, tuple[Callable[[Path], Path], SequenceOptions]] = {
    "tum": (of_size("tum", (640, 480)), NONE),
    "tum, of a camera that its documents state": (of_size("tum", (640, 480), "rgbd_dataset_freiburg1_desk"), NONE),
    "tum of ETH3D": (changed("tum", {"calibration.txt": f"{FX} {FY} {CX} {CY}\n"}), NONE),
    "tartanair": (of_size("tartanair", (640, 480)), NONE),
    "tartanair_v2": (of_size("tartanair_v2", (640, 640)), NONE),
    "seven_scenes": (of_size("seven_scenes", (640, 480)), NONE),
    "depth of a telephone": (lambda folder: made(folder, "stray_scanner", 1, stride=2), NONE),
    "depth of half the pixels": (changed("pictures", {"*.depth.png": lambda depth: depth[::2, ::2]}), NONE),
    "depth of more pixels": (changed("pictures", {"*.depth.png": lambda depth: np.kron(depth, MIDDLE)}), NONE),
    "colour shrunk to its depth": (changed("scannet", {"intrinsic/intrinsic_color.txt": LARGER}), NONE),
    "a focus that breathes": (lambda folder: made(folder, "stray_scanner", 3, focus=(1, 1.002, 1.004)), NONE),
    "a focus that moves": (lambda folder: made(folder, "stray_scanner", 3, focus=(1.0, 1.1, 1.2)), NONE),
    "a key of geometry": (changed("nerfstudio", {"transforms.json": {"rolling_shutter": 0.5}}), NONE),
    "a key of a frame": (changed("pictures", {"0.json": {"depth_offset": 0.5}}), NONE),
    "a key of no geometry": (changed("redwood", {"camera_intrinsic.json": {"z_near": 1, "maker": "mine"}}), NONE),
    "by columns, with a scale": (lambda folder: made(folder, "open3d_scaled"), NONE),
    "colmap": (lambda folder: made(folder, "colmap"), COLMAP),
    "nerfstudio, one without depth": (changed("nerfstudio", LACKS_DEPTH, 4), NONE),
    "seven_scenes, one pose of nan": (
        changed("seven_scenes", {"*1*.txt": "nan nan nan nan\n" * 4}, 4),
        FORMS["seven_scenes"].options,
    ),
    "scannet, one pose of inf": (changed("scannet", {"pose/1.txt": "-inf -inf -inf -inf\n" * 4}, 4), NONE),
    "colmap, one without a picture": (changed("colmap", {"depth/0001.png": None}, 4), COLMAP),
    "tum, few poses": (changed("tum", {"groundtruth.txt": first_lines(6)}, 4), AS_TUM),
    "traced, few poses": (changed("traced", {"trajectory.txt": first_lines(6)}, 4), TRACED),
    "colmap of two cameras": (of_cameras("11221"), COLMAP),
    "colmap of a camera each": (of_cameras("12345"), COLMAP),
    "colmap of two cameras, the other": (of_cameras("11221"), attrs.evolve(COLMAP, frames_camera="2")),
    "the right one of a rig": (of_a_rig, attrs.evolve(TRACED, frames_camera="right")),
    "a denser trajectory": (lambda folder: made(folder, "tum", 3), AS_TUM),
    "times that are shares": (timed(0, 0.25, 0.5, 1), NONE),
    "times that are even shares": (timed(0, 0.25, 0.5, 0.75), NONE),
    "times that are one": (timed(0, 0, 0, 0), NONE),
    "times that count": (timed(0, 1, 2, 3), NONE),
    "times that are seconds": (timed(7.0, 7.05, 7.1, 7.2), NONE),
    "times in ms": (changed("npz", {"*.npz": lambda data: data.update(time_s=data["time_s"] * 1e3)}, 3), NONE),
    "times too close": (changed("npz", {"*.npz": lambda data: data.update(time_s=data["time_s"] * 1e-2)}, 3), NONE),
    **{f"pictures named by 1/{10**k} s": (named_by(10**k), TRACED) for k in (3, 6, 9)},
    "a trace beside pictures": (lambda folder: made(folder, "traced", 3), TRACED),
    "at a rate that the user says": (
        lambda folder: made(folder, "traced", 3),
        attrs.evolve(TRACED, frames_rate_hz=10.0),
    ),
    "axes that the trace says": (changed("traced", {"trajectory.txt": lambda text: "# axes: opencv\n" + text}), TRACED),
    "bytes": (lambda folder: made(folder, "npz"), NONE),
    "floats": (changed("npz", {"*.npz": lambda data: data.update(colour=data["colour"] / 255)}), NONE),
    "integer_depth_scale": (changed("nerfstudio", {"transforms.json": {"integer_depth_scale": 0.002}}), NONE),
    "depth_unit_scale_factor": (changed("nerfstudio", {"transforms.json": {"depth_unit_scale_factor": 0.002}}), NONE),
    "units per metre": (changed("redwood", {"camera_intrinsic.json": {"depth_scale": 500.0}}), NONE),
    "the largest integer": (changed("npz", {"frame-0.npz": largest}, 1), NONE),
    "the largest of 16 bits": (changed("numbered", {"depth/0.png": blotted(*PART, 65535)}), MILLIMETRES),
    "the same, far": (
        changed("numbered", {"depth/0.png": blotted(*PART, 65535)}),
        attrs.evolve(MILLIMETRES, no_depth="far"),
    ),
    "many of 12 bits": (
        changed("numbered", {f"depth/{n}.png": blotted(*PART, 4095) for n in range(5)}, 5),
        MILLIMETRES,
    ),
    "transparent": (changed("pictures", {"0.png": transparent}, 1), NONE),
    "transparent, far": (changed("pictures", {"0.png": transparent}, 1), SequenceOptions(no_depth="far")),
    "an axis beside the middle": (of_size("numbered", (320, 240)), MILLIMETRES),
    "sky above": (deep(sky_above), NONE),
    "sky above, far": (deep(sky_above), SequenceOptions(no_depth="far")),
    "depth in mm": (deep(lambda depth: depth * 1000), NONE),
    "depth in cm": (deep(lambda depth: depth * 100), NONE),
    "depth in mm, said so": (deep(lambda depth: depth * 1000), SequenceOptions(depth_scale=0.001)),
    **{f"depth of {value} alone": (deep(lambda z, v=value: np.full_like(z, v)), NONE) for value in (0.0, np.nan, -2.0)},
    "ros1": (bag(write_ros1), NONE),
    "ros2": (bag(write_ros2), NONE),
    "ros2 by odometry": (bag(write_ros2, motion="odometry"), NONE),
}


def told(folder: Path, options: SequenceOptions) -> str:
    """How a folder was read, in words."""
    found = sequences.open(folder, options)
    lines = [f"{len(found.frames)} frames of {found.layout} at {found.rate_hz:.4g} Hz, {len(found.track)} poses"]
    for frame in found.frames:
        colour, depth = frame.read()
        place = " ".join(
            f"{x:.4f}" for x in (*frame.pose.position_m, *frame.pose.orientation_xyzw, *frame.fov.tangents)
        )
        near = depth[np.isfinite(depth) & (depth > 0)]
        counts = f"{np.isnan(depth).sum()} nan {np.isinf(depth).sum()} inf {(depth <= 0).sum()} none"
        light = f"{colour.mean():.0f}" if colour.dtype == np.uint8 else f"{colour.mean():.2f}"
        depths = f"{counts}, {near.sum() / max(near.size, 1):.2f} m"
        lines.append(f"{frame.name} {frame.time_ns / 1e6:.2f} ms: {place}; {depths}, light {light}")
    lines += [f"{one.what}: {one.value} ({one.by.value})" for one in found.assumptions]
    lines += [f"note: {note}" for note in (*found.notes, *depth_notes(found))]
    return "\n".join(lines).replace("-0.0000", "0.0000")


def cases_in(text: str) -> dict[str, str]:
    return {part.partition("\n")[0]: part.partition("\n")[2].strip() for part in text.split("# ")[1:]}


@pytest.mark.parametrize("case", CASES)
def test_a_recording_is_read_as_it_was(case, folder):
    if case.startswith("ros") and not HAS_ROSBAGS:
        pytest.skip("rosbags is not installed (pip install '.[bags]')")
    write, options = CASES[case]
    found = told(write(folder), options).replace(str(folder.parent), "")
    golden = cases_in(GOLDEN.read_text(encoding="utf-8")) if GOLDEN.exists() else {}
    if os.environ.get("HMDWARP_GOLDEN") == "write":
        there = {name: golden.get(name, "") for name in CASES} | {case: found}
        GOLDEN.write_text("\n\n".join(f"# {name}\n{text}" for name, text in there.items()) + "\n", encoding="utf-8")
    else:
        assert found == golden[case]


def test_every_case_is_in_the_file():
    assert [*cases_in(GOLDEN.read_text(encoding="utf-8"))] == [*CASES]


def test_of_several_cameras_a_user_names_one_that_is_there(folder):
    larger = {f"intrinsic/intrinsic_{side}.txt": LARGER for side in ("color", "depth")}
    edited(folder.parent / "scannet", "scannet", larger)
    refused(folder.parent / "scannet", "its centre at 648,484, which is not the middle of pictures of 36x24")
    of_cameras("11221")(folder.parent / "colmap")
    words = "--frames-camera is 7; expected one of its cameras: 1: "
    refused(folder.parent / "colmap", words, options=attrs.evolve(COLMAP, frames_camera="7"))
    for wanted in (None, "t", "middle"):
        with pytest.raises(InputError, match=f"--frames-camera is {wanted or 'not given'}; .*: .*left.*, .*right"):
            sequences.open(of_a_rig(folder) if wanted is None else folder, attrs.evolve(TRACED, frames_camera=wanted))


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


def test_what_a_frame_says_is_stronger_than_what_all_share(tmp_path):
    edited(tmp_path, "pictures", {"1.json": {"intrinsics": [2 * FX, FY, CX, CY]}})
    shared, own = (frame.fov.tangents for frame in sequences.open(tmp_path).frames)
    assert np.ptp(own[:2]) == pytest.approx(np.ptp(shared[:2]) / 2)


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


@pytest.mark.parametrize(("most", "no_depth"), [(4095, 65535), (10_000, 10_000)])
def test_a_pgm_states_its_largest_level_which_with_all_bits_set_is_no_depth(most, no_depth, tmp_path):
    levels = np.arange(most + 1, dtype=">u2")
    (tmp_path / "a.pgm").write_bytes(b"P5\n%d 1\n%d\n" % (most + 1, most) + levels.tobytes())
    assert sequences.read_depth(tmp_path / "a.pgm").tolist() == [[*range(most), no_depth]]


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


def noisy(size=(160, 120)) -> np.ndarray:
    """Depth of a floor and of a wall with noise, in metres."""
    return 2 + np.random.default_rng(3).random(size[::-1]).astype(np.float32)


def sky_over(depth: np.ndarray) -> np.ndarray:
    depth[:50] = 0
    depth[20:80, 60:70] = 3  # a tower before it
    return depth


def blot(rows: slice, columns: slice, value: float = 0):
    return lambda depth: (blotted(rows, columns, value)(depth), depth)[1]


EVERY = slice(None)
# With whether they are sky.
MADE = {
    "sky above": (sky_over, True),
    "sky at one side": (blot(slice(10, 80), slice(0, 40), np.nan), True),
    "holes inside": (blot(slice(30, 80), slice(40, 100)), False),
    "a rim": (lambda depth: np.pad(depth[8:-8, 8:-12], ((8, 8), (8, 12))), False),
    "noise": (lambda depth: np.where(np.random.default_rng(5).random(depth.shape) < 0.3, 0, depth), False),
    "nothing": (blot(EVERY, EVERY), False),
    "all of it": (lambda depth: depth, False),
}


@pytest.mark.parametrize("made", MADE)
def test_sky_without_depth_is_noticed_and_holes_of_a_depth_camera_are_no_sky(made):
    change, is_sky = MADE[made]
    notes = about_sky([noisy(), change(noisy())])
    assert ["--no-depth far" in note for note in notes] == [True] * is_sky


@pytest.mark.parametrize("near", [0.05, 0.1, 0.3])
@pytest.mark.parametrize("far", [10.0, 1000.0, np.inf])
@pytest.mark.parametrize("buffer", ["standard", "signed", "reversed"])
def test_values_of_a_depth_buffer_are_noted(near, far, buffer):
    """Of a room from 1 to 9 m, at planes that engines use."""
    metres = np.linspace(1, 9, 120 * 90).reshape(90, 120)
    clip = (1 - near / metres) / (1 - near / far)
    values = {"standard": clip, "signed": 2 * clip - 1, "reversed": 1 - clip}[buffer]
    said = about_unit([values], 0.05, "{:g}")
    crowded = np.median(values) > 0.9 or np.median(values) < 0.05
    assert len(said) == crowded and all("values of a depth buffer, not metres" in note for note in said)
    assert all(("DepthLayer(0, 1, far, near)" in note) == (buffer == "reversed") for note in said)
    assert crowded or near == 0.3  # 1 - 0.3 m / 5 m, and twice that less 1: a table in front of the eye
    assert about_unit([values], 0.0, "{:g}") == []


@pytest.mark.parametrize(("dtype", "said"), [(np.float32, True), (np.uint16, False)])
def test_metres_that_a_scale_for_millimetres_shrinks_are_noted(dtype, said):
    """A room from 1 to 9 m in floats; the same integers are what a scale is for."""
    raw = np.linspace(1, 9, 108).astype(dtype)
    (note,) = about_unit([raw * 0.001], 0.05, "--depth-scale {:g}", [raw])
    assert ("up to 9 in the file: if that is metres already, --depth-scale 1" in note) == said


@pytest.mark.parametrize("depth", [np.ones((9, 12)), np.linspace(0.2, 1, 108), np.linspace(0.3, 4, 108)])
def test_metres_near_the_eye_are_no_depth_buffer(depth):
    assert about_unit([depth], 0.05, "{:g}") == []
