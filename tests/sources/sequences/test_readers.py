"""Recorded sequences: every layout gives the same frames, in OpenXR's axes, metres and sRGB."""

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
    HAS_EXR,
    LAYOUTS,
    MILLIMETRES,
    REAL,
    REAL_CAMERAS,
    SIZE,
    fov_of,
    taken,
    write_nerfstudio,
    write_npz,
    write_numbered,
    write_pictures,
    write_redwood,
    write_tum,
)
from ros_bags import BAGS, HAS_ROSBAGS

from hmdwarp import WarpMap
from hmdwarp.errors import InputError, UnknownNameError
from hmdwarp.poses import Origin
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import RecordedFrame, Sequence, SequenceOptions, depth_notes, parse_intrinsics, readers
from hmdwarp.sources.sequences.camera import camera_of

DEPTH_WITHIN_M = 0.5e-3 + 1e-6  # Half a step of 16 bits in millimetres, the coarsest unit


FORMS = {name: Form(*facts) for name, facts in LAYOUTS.items()} | PUBLISHED | BAGS


@pytest.fixture(params=FORMS)
def layout(request):
    if request.param == "exr" and not HAS_EXR:
        pytest.skip("OpenEXR is not installed (pip install '.[exr]')")
    if request.param in BAGS and not HAS_ROSBAGS:
        pytest.skip("rosbags is not installed (pip install '.[bags]')")
    return FORMS[request.param]


@pytest.fixture
def folder(tmp_path):
    """A folder whose parent belongs to the same test."""
    (tmp_path / "taken").mkdir()
    return tmp_path / "taken"


def test_every_reader_is_tried():
    assert {form.reader for form in FORMS.values()} == set(readers.names())


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
        assert found.time_ns == one.time_ns
        at = sequence.track.at(found.time_ns)
        assert at.origin is Origin.MEASURED and at.pose.isclose(found.pose, 0)
        assert found.size == SIZE
        colour, depth_m = found.read()
        assert colour.dtype == np.uint8
        assert np.abs(colour.astype(int) - one.colour).max() <= layout.colour_within
        assert depth_m.dtype == np.float32 and np.abs(depth_m - one.depth_m).max() <= DEPTH_WITHIN_M
        assert depth_m[0, 0] == 0


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
    assert inner.notes[-1] == "The 3 outermost pixels of each picture are left out." and inner.notes[:-1] == whole.notes


def test_a_crop_leaves_some_pixels(tmp_path):
    write_npz(tmp_path, taken(2))
    most = (min(SIZE) - 1) // 2
    assert min(sequences.open(tmp_path, SequenceOptions(crop=most)).frames[0].size) in (1, 2)
    with pytest.raises(InputError, match=f"--crop {most + 1}: .* has {SIZE[0]}x{SIZE[1]} pixels; expected to leave"):
        sequences.open(tmp_path, SequenceOptions(crop=most + 1))
    with pytest.raises(InputError, match="--crop -1 px: expected a whole number of at least 0"):
        SequenceOptions(crop=-1)


def agreeing(first: RecordedFrame, second: RecordedFrame) -> float:
    """Share of the first's pixels seen in the second that have the same depth there, within 2 %.

    By the warp map, in pixels from the bottom left. What the second hides by something nearer is
    left out.
    """
    (wide, high), depths = first.size, [np.flipud(frame.depth_m).astype(float) for frame in (first, second)]
    y, x = np.nonzero(depths[0] > 0)
    warp = WarpMap.between(first.view, first.size, second.view, second.size)
    pixels, inverse, _ = warp.apply(np.stack([x + 0.5, y + 0.5], axis=1), 1 / depths[0][y, x])
    inside = (pixels >= 0).all(axis=1) & (pixels < (wide, high)).all(axis=1)
    column, row = pixels[inside].astype(int).T
    nearer = depths[1][row, column] * inverse[inside]
    return float((np.abs(nearer[nearer > 0.98] - 1) < 0.02).mean())


@pytest.mark.parametrize("name", REAL_CAMERAS)
def test_real_frames_agree_with_each_other(name):
    """A share that only the right axes, unit and inverse give: the wrong inverse gives 2 to 6 %."""
    if not (REAL / name).is_dir():
        pytest.skip(f"no real frames: {REAL / name} is absent (they are not shipped)")
    intrinsics, scale, share = REAL_CAMERAS[name]
    sequence = sequences.open(REAL / name, SequenceOptions(intrinsics=parse_intrinsics(intrinsics), depth_scale=scale))
    assert len(sequence.frames) == 5
    first, second = sequence.frames[3:]
    assert agreeing(first, second) > share


def test_without_a_principal_point_it_is_the_middle_of_the_picture():
    stated = {"w": 64, "h": 48, "fl_x": 50}
    found = [camera_of("it", stated, centre) for centre in (0.0, 0.5)]
    assert [(one.cx, one.cy) for one in found] == [(31.5, 23.5), (32, 24)]


def opened(folder: Path, write, options: SequenceOptions | None = None, count: int = 2) -> Sequence:
    folder.mkdir(exist_ok=True)
    write(folder, taken(count))
    return sequences.open(folder, options)


def refused(folder: Path, *words: str, options: SequenceOptions | None = None) -> None:
    with pytest.raises(InputError) as caught:
        for frame in sequences.open(folder, options).frames:
            frame.read()
    for word in words:
        assert word in str(caught.value), str(caught.value)


@pytest.mark.parametrize(
    ("lens", "named"),
    [
        ({"k1": 0.05}, "k1 is 0.05"),
        ({"p2": -0.001}, "p2 is -0.001"),
        ({"camera_model": "OPENCV_FISHEYE"}, "camera model OPENCV_FISHEYE"),
        ({"distortion": [0, 0, 0.1]}, "distortion[2] is 0.1"),
    ],
)
def test_lens_distortion_is_refused_by_its_name(lens, named, tmp_path):
    opened(tmp_path / "nerf", write_nerfstudio)
    file = tmp_path / "nerf" / "transforms.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | lens))
    refused(tmp_path / "nerf", named, "undistort")
    opened(tmp_path / "numbered", write_numbered, MILLIMETRES)
    (tmp_path / "numbered" / "camera.json").write_text(
        json.dumps({"intrinsics": [40, 40, 18, 12], "depth_scale": 0.001, **lens})
    )
    refused(tmp_path / "numbered", named, "undistort")


def test_missing_facts_are_requested_by_option(tmp_path):
    write_numbered(tmp_path, taken(2))
    refused(tmp_path, "--intrinsics FX,FY,CX,CY", "camera.json")
    refused(tmp_path, "--depth-scale", options=attrs.evolve(MILLIMETRES, depth_scale=None))
    (tmp_path / "camera.json").write_text(json.dumps({"intrinsics": [40, 42, 17.3, 11.1], "depth_scale": 0.001}))
    found = sequences.open(tmp_path)
    assert [*found] == [found[0], found[-1]] == [*found.frames] and len(found) == 2
    assert "2 frames" in repr(found)


def test_a_denser_trajectory_is_the_motion_between_the_frames(tmp_path):
    """Poses at 90 Hz between frames at 30; the file's own clock is told."""
    track = opened(tmp_path, write_tum, AS_TUM, count=3).track
    assert (len(track), track.start_ns, track.end_ns) == (7, 0, taken(3)[-1].time_ns)
    assert track.epoch_ns == 1305031102_175304000
    assert track.pose(1).isclose(taken(3)[0].pose.towards(taken(3)[1].pose, 1 / 3), 1e-9)


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


def test_a_folder_of_no_layout_is_refused_with_its_content(tmp_path):
    refused(tmp_path, "an empty folder", "no layout")
    (tmp_path / "notes.txt").write_text("nothing", encoding="utf-8")
    refused(tmp_path / "notes.txt", "a file", "no layout")
    (tmp_path / "rgb").mkdir()
    refused(tmp_path, "holds notes.txt, rgb/)", "no layout")


def test_files_that_do_not_fit_are_named(tmp_path):
    refused(tmp_path / "nothing", "no such file or folder")
    refused(tmp_path, "no layout", "tum", "nerfstudio", "redwood", "list layouts")
    with pytest.raises(UnknownNameError, match="did you mean 'tum'"):
        sequences.open(tmp_path, SequenceOptions(layout="tun"))

    folder = tmp_path / "numbered"
    opened(folder, write_numbered, MILLIMETRES)
    Image.fromarray(np.zeros((24, 36), np.uint8)).save(folder / "depth" / "0.png")
    refused(folder, "0.png", "8 bits a channel", options=MILLIMETRES)
    (folder / "depth" / "0.png").write_bytes(b"GIF nonsense")
    refused(folder, "0.png", "not a picture", options=MILLIMETRES)
    lines = (folder / "pose.txt").read_text().splitlines()
    (folder / "pose.txt").write_text(f"# a comment\n{lines[0]}\n1 2 3\n")
    refused(folder, "pose.txt, line 3", "expected 7 finite numbers", options=MILLIMETRES)
    (folder / "pose.txt").write_text(lines[0])
    refused(folder, "1 poses for 2 pictures", options=MILLIMETRES)

    folder = tmp_path / "redwood"
    opened(folder, write_redwood)
    camera = {"width": 640, "height": 480, "intrinsic_matrix": [525, 0, 0, 0, 525, 0, 320, 240, 1]}
    (folder / "camera_intrinsic.json").write_text(json.dumps(camera))
    refused(folder, "640x480", "36x24")
    text = (folder / "trajectory.log").read_text().splitlines()
    (folder / "trajectory.log").write_text("\n".join([text[0], "2 0 0 0", *text[2:]]))
    refused(folder, "trajectory.log, line 1", "does more than turn", options=MILLIMETRES)

    folder = tmp_path / "tum"
    opened(folder, write_tum, AS_TUM)
    (folder / "depth.txt").write_text("1305031102.2 depth/0.png\n1305031102.3\n")
    refused(folder, "depth.txt, line 2", "expected seconds")
    (folder / "depth.txt").write_text("5.0 depth/0.png\n")
    refused(folder, "the clocks are 1.30503e+09 s apart", options=AS_TUM)

    folder = tmp_path / "npz"
    opened(folder, write_npz)
    with np.load(folder / "frame-1.npz") as data:
        np.savez(folder / "frame-1.npz", **{name: value for name, value in data.items() if name != "time_s"})
    refused(folder, "frame-1.npz: no time_s")


def test_frames_without_depth_or_pose_are_left_out_with_a_note(tmp_path):
    opened(tmp_path / "nerf", write_nerfstudio, count=3)
    file = tmp_path / "nerf" / "transforms.json"
    data = json.loads(file.read_text())
    del data["frames"][1]["depth_file_path"]
    file.write_text(json.dumps(data))
    sequence = sequences.open(file)
    assert len(sequence.frames) == 2 and "1 frames were left out" in sequence.notes[0]

    opened(tmp_path / "tum", write_tum, AS_TUM, count=3)
    (tmp_path / "tum" / "groundtruth.txt").write_text(
        "\n".join((tmp_path / "tum" / "groundtruth.txt").read_text().splitlines()[:6]) + "\n"
    )
    sequence = sequences.open(tmp_path / "tum", AS_TUM)
    assert len(sequence.frames) == 2 and any("no pose at their instants" in note for note in sequence.notes)


def test_depth_of_a_telephone_is_taken_to_the_pixels_of_its_colour(tmp_path):
    """Half the pixels on each axis, of the same shape; another shape is refused."""
    write_pictures(tmp_path, taken(2))
    for i in range(2):
        depth = np.asarray(Image.open(tmp_path / f"{i}.depth.png"))
        Image.fromarray(depth[::2, ::2]).save(tmp_path / f"{i}.depth.png")
    found = sequences.open(tmp_path).frames[0].depth_m
    assert np.array_equal(found, np.repeat(np.repeat(found[::2, ::2], 2, 0), 2, 1))
    Image.fromarray(depth[:, ::2]).save(tmp_path / "0.depth.png")
    refused(tmp_path, "0.depth.png", "of another shape")


def test_no_depth_where_colour_is_transparent(tmp_path):
    write_pictures(tmp_path, taken(1))
    colour = np.asarray(Image.open(tmp_path / "0.png").convert("RGBA")).copy()
    colour[3, 4, 3] = 0
    Image.fromarray(colour).save(tmp_path / "0.png")
    picture, depth = sequences.open(tmp_path).frames[0].read()
    assert picture.shape == (24, 36, 3) and np.isnan(depth[3, 4]) and np.isnan(depth).sum() == 1


@pytest.mark.parametrize("most", [4095, 4000])
def test_a_pgm_keeps_its_values_and_its_largest_of_whole_bits_is_no_measurement(most, tmp_path):
    """4095 is not spread over 16 bits; a writer's own largest value, 4000, is a depth."""
    write_numbered(tmp_path, taken(1))
    depth = np.array(Image.open(tmp_path / "depth" / "0.png"))
    depth[3, 4] = most
    (tmp_path / "depth" / "0.png").unlink()
    head = f"P5\n# made by hand\n36 24\n{most}\n".encode()
    (tmp_path / "depth" / "0.pgm").write_bytes(head + depth.astype(">u2").tobytes())
    sequence = sequences.open(tmp_path, MILLIMETRES)
    found = sequence.frames[0].depth_m
    assert np.array_equal(np.rint(found * 1000), np.where(depth == 4095, 0, depth))
    (note,) = depth_notes(sequence) or [""]
    assert note.startswith("1 pixels") == (most == 4095) and ("of a PGM's" in note) == (most == 4095)


def test_scaled_positions_are_metres_again(tmp_path):
    """nerfstudio's applied_scale is taken out, as its own depth is multiplied by it."""
    write_nerfstudio(tmp_path, taken(2))
    file = tmp_path / "transforms.json"
    data = json.loads(file.read_text())
    for frame in data["frames"]:
        for row in frame["transform_matrix"][:3]:
            row[3] *= 0.25
    file.write_text(json.dumps({**data, "applied_scale": 0.25}))
    assert sequences.open(tmp_path).frames[1].pose.isclose(taken(2)[1].pose, 1e-9)


def test_an_npz_file_may_say_where_its_first_pixel_has_its_middle(tmp_path):
    views = []
    for at, centre in enumerate((0.0, 0.5)):
        stated = {"intrinsics": [40, 42, 17.3 + centre, 11.1 + centre], "centre": centre}
        views.append(sequences.open(written_npz(tmp_path / str(at), **stated)).frames[0].fov)
    assert views[0].tangents == pytest.approx(views[1].tangents, abs=1e-12)


def written_npz(folder: Path, times: tuple[float, ...] = (0.0, 0.1), **stated: object) -> Path:
    """A folder of .npz files that state this too."""
    folder.mkdir(parents=True)
    facts = {"position_m": [0, 1.6, 0], "orientation_xyzw": [0, 0, 0, 1.0], **stated}
    facts |= {} if "intrinsics" in stated else {"fov": [-0.5, 0.5, -0.4, 0.4]}
    pictures = {"colour": np.full((24, 36, 3), 0.5), "depth_m": np.full((24, 36), 2)}
    for number, time_s in enumerate(times):
        np.savez(folder / f"{number}.npz", **{"depth_scale": 1.0, "time_s": time_s, **pictures, **facts})
    return folder


@pytest.mark.parametrize(
    "stated", [{"depth_scale": scale} for scale in (0.0, -0.001, np.nan, 1000.0)] + [{"encoding": "rec709"}]
)
def test_a_folder_says_nothing_that_would_be_read_as_something_else(stated, tmp_path):
    """A scale of 0 was metres, one of 1000 units a metre kilometres, an unknown encoding light."""
    written_npz(tmp_path / "npz", **stated)
    refused(tmp_path / "npz", "0.npz: ", next(iter(stated)))
    if "depth_scale" in stated:
        write_numbered(tmp_path, taken(2))
        (tmp_path / "camera.json").write_text(json.dumps({"intrinsics": [40, 42, 17.3, 11.1], **stated}))
        refused(tmp_path, "camera.json: depth_scale is", options=attrs.evolve(MILLIMETRES, depth_scale=None))


@pytest.mark.parametrize("unit", [1e9, 1e-6])
def test_instants_in_another_unit_are_refused(unit, tmp_path):
    """Nanoseconds in place of seconds were frames a year apart."""
    folder = written_npz(tmp_path / "npz", tuple(unit * (number / 30) for number in range(3)))
    refused(folder, "s apart", "unit")
    assert len(sequences.open(folder, SequenceOptions(frames_rate_hz=30)).frames) == 3


@pytest.mark.parametrize("unit", [1e3, 1e-2])
def test_instants_that_may_be_in_another_unit_are_named(unit, tmp_path):
    """Milliseconds in place of seconds make frames half a minute apart."""
    (note,) = sequences.open(written_npz(tmp_path / "npz", tuple(unit * number / 30 for number in range(3)))).notes
    assert note.startswith("Frames are ") and "--frames-rate" in note
