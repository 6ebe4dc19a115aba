"""Replays of recorded frames: what is drawn, what is shown, what is the truth, what is refused."""

from __future__ import annotations

import json
import tracemalloc
from contextlib import closing
from pathlib import Path

import attrs
import numpy as np
import pytest
from recorded_folders import taken, write_npz
from replays import rows_of

from hmdwarp.colour import linear_from_srgb
from hmdwarp.errors import InputError, PlanError
from hmdwarp.geometry import Fov, Hidden, Pose, inverse_depth_from_metres
from hmdwarp.gpu import download
from hmdwarp.image import usable_fills, usable_warps
from hmdwarp.options import options_of
from hmdwarp.pipeline.recorded_renderer import RecordedRenderer
from hmdwarp.pipeline.source import nothing
from hmdwarp.poses import load_trace
from hmdwarp.run import RunOptions, set_up_replay
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences import SequenceOptions
from hmdwarp.sources.server import Target

from .recorded import COUNT, LATE_MS, SIZE, options


def test_without_latency_the_frame_is_the_truth(run):
    """Every frame is shown at its own instant, for its own pose: nothing is left to warp."""
    result = run(latency=0.0, warp="none", fill="none")
    assert result.summary["frames"] == COUNT
    assert result.summary["quality"]["psnr_db"]["mean"] == 100  # identical pictures
    assert result.summary["truth_offset"] == {
        name: {"median": 0.0, "most": 0.0} for name in ("time_ms", "turn_deg", "move_m")
    }


def test_a_late_frame_is_the_one_taken_then_with_its_exact_pose(run, tmp_path):
    result = run(page=True, images=2, against="none", video=True)
    frames, rows = taken(COUNT, SIZE), rows_of(tmp_path / "out")
    assert len(rows) == COUNT - 3 and {row["eye"] for row in rows} == {"0"}
    for number, row in enumerate(rows):
        drawn, shown = (
            Pose([float(row[f"{what}_{axis}_m"]) for axis in "xyz"], [float(row[f"{what}_q{axis}"]) for axis in "xyzw"])
            for what in ("drawn", "shown")
        )
        assert drawn.isclose(frames[number].pose, 1e-9) and shown.isclose(frames[number + 3].pose, 1e-9)
        assert (row["drawn_origin"], row["pose_origin"]) == ("measured", "measured")
        assert float(row["age_ms"]) == pytest.approx(LATE_MS, abs=1e-3)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["eyes"], summary["scene"], summary["trace"], summary["headset"]) == (
        1, "walk-past", "walk-past", "camera",
    )  # fmt: skip
    assert summary["size"] == [60, 40] and summary["rendered"]["pixels"] == 1
    # 6 cm and 3 degrees: 2 pixels or more everywhere, which a warp by exact depth undoes.
    late, warped = summary["against"][0]["quality"], summary["quality"]
    assert warped["psnr_db"]["mean"] > late["psnr_db"]["mean"] + 6
    assert any("the recorded frame of the shown instant itself" in note for note in summary["notes"])
    assert any("One eye is shown, the camera's" in note for note in summary["notes"])
    names = sorted(path.name for path in (tmp_path / "out" / "images").iterdir())
    assert names and all(name.endswith("-camera.png") for name in names)
    page = (tmp_path / "out" / "report.html").read_text(encoding="utf-8").replace("<wbr>", "")
    assert "One eye is shown" in page and "left eye" not in page
    assert len(result.rows) == len(rows)


def test_colour_without_depth_stays_for_warps_that_read_colour_alone(run):
    """Pixel (0, 0) has no depth: a late picture shows it, a warp by depth leaves a hole there."""
    assert run(latency=0.0, warp="rotation").summary["quality"]["hole_share"]["mean"] == 0
    by_depth = run(latency=0.0, warp="iterative", fill="none").summary["quality"]["hole_share"]
    assert by_depth["mean"] == pytest.approx(1 / (60 * 40))


@pytest.mark.parametrize("warp", usable_warps())
def test_every_warp_of_one_picture_runs(warp, run):
    assert run(warp=warp, seconds=0.1).summary["frames"] == 3


@pytest.mark.parametrize("fill", usable_fills())
def test_every_fill_of_one_picture_runs(fill, run):
    run(warp="forward", fill=fill, seconds=0.05)


def test_older_frames_help_a_warp_of_several(run, folder):
    run(warp="multi:eye=own,frames=1,spacing=30", seconds=0.1)
    with pytest.raises(InputError, match="recorded frames have one eye.*multi:eye=own"):
        set_up_replay(options(folder, warp="multi"))


def test_a_quicker_display_is_told_how_far_its_truth_is(run, tmp_path):
    """Between frames the nearest is up to half a step away: 17 ms, 1 cm and half a degree."""
    offset = run(rate=90.0).summary["truth_offset"]
    assert 1000 / 90 - 0.1 < offset["time_ms"]["most"] <= 1000 / 60 + 0.1
    assert 0 < offset["turn_deg"]["most"] <= 0.51 and 0 < offset["move_m"]["most"] <= 0.0101
    newest = {round(float(row["drawn_ns"])) for row in rows_of(tmp_path / "out")}
    assert newest <= {frame.time_ns for frame in taken(COUNT)}


def test_a_slower_server_sends_fewer_of_them(run):
    frames = run(server_rate=10.0).summary["link"]["frames"]
    assert frames["drawn"] == 4  # at 0, 100, 200 and 300 of 367 ms


def test_another_head_begins_where_the_camera_does(run, tmp_path):
    result = run(trace="walk", rate=30.0)
    rows, trace, start = rows_of(tmp_path / "out"), load_trace("walk").track, taken(1)[0].pose
    assert result.summary["trace"] == "walk"
    shown_ns = int(float(rows[0]["shown_ns"]))
    step = trace.at(trace.start_ns + shown_ns).pose.relative_to(trace.pose(0))
    expected = start @ step
    assert [float(rows[0][f"shown_{axis}_m"]) for axis in "xyz"] == pytest.approx(expected.position_m, abs=1e-6)
    assert any("That is another view than the one shown" in note for note in result.summary["notes"])


def test_frames_are_taken_over_as_they_are(gpu, folder):
    """Light by its table bit for bit, inverse depth within what dividing in float32 is off by.

    That is 2.5 units. A crop in whole pixels is the same.
    """
    sequence = sequences.open(folder)
    frame, size = sequence.frames[3], sequence.frames[3].size
    light, inverse = linear_from_srgb(frame.colour).astype(np.float16), inverse_depth_from_metres(frame.depth_m)
    inner = sequence.cropped(4).frames[3]
    with closing(RecordedRenderer(gpu, nothing("recorded", ""), sequence)) as renderer:
        whole = renderer.draw(frame.view, size, time_ns=frame.time_ns)
        part = renderer.draw(inner.view, inner.size, time_ns=frame.time_ns)
        for image, cut in ((whole, np.s_[:, :]), (part, np.s_[4:-4, 4:-4])):
            colour, depth = download(image.colour), download(image.inverse_depth)
            assert np.array_equal(colour[..., :3], light[cut]) and (colour[..., 3] == 1).all()
            assert depth == pytest.approx(np.where(np.isnan(inverse), -1, inverse)[cut], rel=3 * 2**-23)
        tracemalloc.start()
        renderer.draw(frame.view, size, Target(whole.colour, whole.inverse_depth), time_ns=frame.time_ns)
        assert tracemalloc.get_traced_memory()[1] < 2 * size[0] * size[1]  # colour alone has three times as much
        tracemalloc.stop()


@pytest.mark.parametrize(("size", "hides"), [((30, 20), False), ((23, 17), True), ((97, 13), False)])
def test_another_size_is_the_mean_of_light_and_one_depth(size, hides, gpu, folder):
    """By float64: pixels whose centre lies in the new one, or, of finer pixels, around its centre.

    Rounding to halves is off by 2^-11, or by half of the least of them; float32 by 2^-24 for each
    of at most 15 pixels. Depth is of one pixel, within what dividing is off by.
    """
    sequence = sequences.open(folder)
    polygon = ((-0.2, -0.1), (0.1, 0.3), (0.4, -0.2), (0.1, -0.25))
    frame = sequence.frames[3]
    frame = attrs.evolve(frame, hidden=Hidden((polygon,), frame.fov) if hides else None)
    light, inverse = linear_from_srgb(frame.colour).astype(np.float64), inverse_depth_from_metres(frame.depth_m)
    part = Fov.from_tangents(np.array([0.83, 0.61, 0.55, 0.97]) * frame.fov.tangents)
    with closing(RecordedRenderer(gpu, nothing("", ""), attrs.evolve(sequence, frames=(frame,)))) as renderer:
        for fov in (frame.fov, part):
            view = attrs.evolve(frame.view, fov=fov)
            drawn = renderer.draw(view, size)
            colour, depth = download(drawn.colour), download(drawn.inverse_depth)
            rays = view.rays(size)[::-1] @ np.diag([1, -1, 1])
            places = [_places(frame, rays[0, :, 0], 0), _places(frame, rays[:, 0, 1], 2)]
            across, down = (_means(at, count) for at, count in zip(places, frame.size, strict=True))
            seen = view.seen(size)
            assert seen.all() != hides
            mean = np.einsum("yr,rcl,xc->yxl", down, light, across) * seen[..., None]
            assert colour[..., :3] == pytest.approx(mean, rel=2**-11 + 15 * 2**-24, abs=2**-25)
            assert np.array_equal(colour[..., 3], seen)
            column, row = (at.astype(int) for at in places)
            expected = np.where(seen & ~np.isnan(inverse[row][:, column]), inverse[row][:, column], -1)
            assert depth == pytest.approx(expected, rel=3 * 2**-23)


def _places(frame, tangents, side):
    """Return where tangents to the right, or down, lie in pixels of a frame, but for rounding."""
    low, high = frame.fov.tangents[side : side + 2] if side == 0 else -frame.fov.tangents[:1:-1]
    return ((tangents - low) / (high - low) * frame.size[side // 2]).round(6)


def _means(places, count):
    """Return (n, count) weights of the pixels of which each place has the mean."""
    reach = max(abs(places[1] - places[0]), 1) / 2
    away = np.arange(count) + 0.5 - places[:, None]
    inside = (away > -reach + 1e-6) & (away <= reach + 1e-6)
    return inside / inside.sum(axis=1, keepdims=True)


def framed(folder: Path, rim: tuple[int, int, int, int]) -> Path:
    """Frames whose outermost rows and columns (top, bottom, left, right) are a noisy white."""
    folder.mkdir()
    frames, rng = taken(COUNT, SIZE), np.random.default_rng(5)
    top, bottom, left, right = rim
    for frame in frames:
        inside = np.zeros(frame.depth_m.shape, bool)
        inside[top : 40 - bottom, left : 60 - right] = True
        frame.colour[~inside] = rng.integers(250, 256, (np.count_nonzero(~inside), 1))
    write_npz(folder, frames)
    return folder


def test_a_rim_without_a_picture_is_told_and_left_out_where_asked(run, tmp_path):
    folder = framed(tmp_path / "framed", (1, 1, 2, 3))
    whole = run(folder).summary
    (told,) = [note for note in whole["notes"] if "--crop" in note]
    assert "frame-0.npz and frame-11.npz hold one colour, up to 3 on a side" in told and "by --crop 4" in told
    inner = run(folder, crop=4).summary
    assert inner["size"] == [52, 32] and not any("--crop" in note for note in inner["notes"])
    assert "The 4 outermost pixels of each picture are left out." in inner["notes"]
    assert inner["quality"]["psnr_db"]["mean"] > whole["quality"]["psnr_db"]["mean"] + 3


@pytest.mark.parametrize(
    "rim", [(0, 0, 0, 0), (2, 2, 2, 0), (12, 12, 20, 20)], ids=["none", "three sides", "background"]
)
def test_a_plausible_picture_is_no_rim(rim, run, tmp_path):
    assert not any("--crop" in note for note in run(framed(tmp_path / "framed", rim)).summary["notes"])


@pytest.mark.parametrize(
    ("said", "told"),
    [
        ({"warp": "layered"}, "layer 'peeled'"),
        ({"warp": "backward"}, "geometry"),
        ({"strategy": "points"}, "layer 'points'"),
        ({"fill": "wide"}, "layer 'wide'"),
        ({"effects": "rigid_motion"}, "layer 'ids'"),
        ({"effects": "soft_motion"}, "layer 'velocity'"),
        ({"effects": "planar_reflections"}, "layer 'reflection'"),
    ],
)
def test_layers_that_were_not_recorded_are_refused_by_the_plan(said, told, folder):
    with pytest.raises(PlanError) as caught:
        set_up_replay(options(folder, **said))
    assert told in str(caught.value)
    assert "recorded frames hold colour and depth of one eye, and no scene" in str(caught.value)


STATED = {"layout": "tum", "intrinsics": "1,1,1,1", "depth_scale": 0.001, "frames_rate": 25.0, "crop": 4}
STATED |= {
    "no_depth": "far",
    "frames_axes": "openxr",
    "frames_camera": "left",
    "frames_topics": "depth=/depth",
    "hidden": "mask.png",
}
STATED["projection"] = "1,0,0,0,0,1,0,0,0,0,-1,-0.2,0,0,-1,0"


@pytest.mark.parametrize("name", [option.name for option in options_of(SequenceOptions)])
def test_options_of_frames_are_refused_without_frames(name):
    with pytest.raises(InputError, match=f"--{name.replace('_', '-')}: .* it is for --frames"):
        RunOptions.of({"trace": "walk", name: STATED[name]})


def test_recordings_that_cannot_be_shown_are_refused(folder, tmp_path):
    with pytest.raises(InputError, match="its 12 frames last 0.367 s.*none is left to show.*--frames-rate"):
        set_up_replay(options(folder, latency=500.0))
    with pytest.raises(InputError, match="no TRACE"):
        RunOptions.of({})
    write_npz(tmp_path, taken(1))
    with pytest.raises(InputError, match="one frame; expected two or more"):
        set_up_replay(options(tmp_path))
    other = attrs.evolve(taken(2)[1], colour=taken(2)[1].colour)
    with np.load(tmp_path / "frame-0.npz") as data:
        facts = dict(data)
    fov = facts["fov"] * 0.9
    np.savez(tmp_path / "frame-1.npz", **{**facts, "fov": fov, "time_s": other.time_ns * 1e-9})
    with pytest.raises(InputError, match="frame-0.npz and frame-1.npz have different fields of view"):
        set_up_replay(options(tmp_path))
