"""Replays of recorded frames: what is drawn and shown, what is the truth, what is refused."""

from __future__ import annotations

import html
import json
import tracemalloc
from contextlib import closing
from pathlib import Path

import attrs
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from recorded_folders import taken, write_npz
from replays import replayed, rows_of

from hmdwarp.base import InputError, PlanError, linear_from_srgb, options_of
from hmdwarp.geometry import Fov, Hidden, Pose, inverse_depth_from_metres
from hmdwarp.gpu import download
from hmdwarp.image import usable_fills, usable_warps
from hmdwarp.pipeline import PipelineOptions
from hmdwarp.pipeline.recorded_source import RecordedRenderer, RecordingSource
from hmdwarp.pipeline.source import nothing
from hmdwarp.poses import load_trace
from hmdwarp.run import LiveOptions, ReplayResult, RunOptions, live, set_up_replay
from hmdwarp.sources import sequences
from hmdwarp.sources.repairs import parse_repairs
from hmdwarp.sources.sequences import SequenceOptions
from hmdwarp.sources.sequences.options import MASK
from hmdwarp.sources.server import Target

# How recorded frames are replayed if nothing is said: three frames of 30 Hz late.
SIZE, COUNT, LATE_MS = (60, 40), 12, 100.0


def options(folder: Path, out: Path | str = "nowhere", **said: object) -> RunOptions:
    usual = {"latency": LATE_MS, "against": "", "metrics_every": 3, "workers": 0, "images": 0}
    return RunOptions.of({**usual, "frames": folder, "out": Path(out), **said})


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Twelve frames at 30 Hz; from one to the next the camera moves 2 cm and turns 1 degree."""
    path = tmp_path_factory.mktemp("recorded") / "walk-past"
    path.mkdir()
    write_npz(path, taken(COUNT, SIZE))
    return path


def pose_of(row: dict[str, str], what: str) -> Pose:
    """A pose of a row of frames.csv: "shown" or "drawn"."""
    return Pose([float(row[f"{what}_{x}_m"]) for x in "xyz"], [float(row[f"{what}_q{x}"]) for x in "xyzw"])


@pytest.fixture
def run(folder, tmp_path, gpu):
    """run(folder=..., page=False, **said): a replay into tmp_path / "out"."""

    def call(folder: Path = folder, page: bool = False, **said: object) -> ReplayResult:
        return replayed(options(folder, tmp_path / "out", force=True, **said), page, gpu)

    return call


def test_a_late_frame_is_the_one_taken_then_with_its_exact_pose(run, tmp_path):
    result = run(images=2, against="none", video=True)
    frames, rows = taken(COUNT, SIZE), rows_of(tmp_path / "out")
    assert len(rows) == COUNT - 3 and {row["eye"] for row in rows} == {"0"}
    for number, row in enumerate(rows):
        assert pose_of(row, "drawn").isclose(frames[number].pose, 1e-9)
        assert pose_of(row, "shown").isclose(frames[number + 3].pose, 1e-9)
        assert (row["drawn_origin"], row["pose_origin"]) == ("measured", "measured")
        assert float(row["age_ms"]) == pytest.approx(LATE_MS, abs=1e-3)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    facts = {"eyes": 1, "scene": "walk-past", "trace": "walk-past", "headset": "camera", "size": [60, 40]}
    assert {name: summary[name] for name in facts} == facts and summary["rendered"]["pixels"] == 1
    # 6 cm and 3 degrees: 2 pixels or more everywhere, which a warp by exact depth undoes.
    late, warped = summary["against"][0]["quality"], summary["quality"]
    assert warped["psnr_db"]["mean"] > late["psnr_db"]["mean"] + 6
    assert any("the recorded frame of the shown instant itself" in note for note in summary["notes"])
    assert any("One eye is shown, the camera's" in note for note in summary["notes"])
    names = sorted(path.name for path in (tmp_path / "out" / "images").iterdir())
    assert names and all(name.endswith("-camera.png") for name in names)
    assert len(result.rows) == len(rows)


def test_colour_without_depth_stays_for_warps_that_read_colour_alone(run):
    """Pixel (0, 0) has no depth: a late picture shows it, a warp by depth leaves a hole there."""
    assert run(latency=0.0, warp="rotation").summary["quality"]["hole_share"]["mean"] == 0
    by_depth = run(latency=0.0, warp="iterative", fill="none").summary["quality"]["hole_share"]
    assert by_depth["mean"] == pytest.approx(1 / (60 * 40))


@pytest.mark.parametrize(
    "passes", [*({"warp": warp} for warp in usable_warps()), *({"fill": fill} for fill in usable_fills())], ids=str
)
def test_every_warp_and_fill_of_one_picture_runs(passes, run):
    assert run(**{"warp": "forward", **passes}, seconds=0.1).summary["frames"] == 3


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


def test_another_head_begins_where_the_camera_does(run, tmp_path):
    summary, row, trace = run(trace="walk", rate=30.0).summary, rows_of(tmp_path / "out")[0], load_trace("walk").track
    step = trace.at(trace.start_ns + int(float(row["shown_ns"]))).pose.relative_to(trace.pose(0))
    expected = taken(1)[0].pose @ step
    assert pose_of(row, "shown").position_m == pytest.approx(expected.position_m, abs=1e-6)
    assert summary["trace"] == "walk"
    assert any("That is another view than the one shown" in note for note in summary["notes"])


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


STATED = {
    "layout": "tum", "intrinsics": "1,1,1,1", "depth_scale": 0.001, "frames_rate": 25.0, "crop": 4, "no_depth": "far",
    "frames_axes": "openxr", "frames_camera": "left", "frames_topics": "depth=/depth", "hidden": "mask.png",
    "projection": "1,0,0,0,0,1,0,0,0,0,-1,-0.2,0,0,-1,0",
}  # fmt: skip


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
    with np.load(tmp_path / "frame-0.npz") as data:
        facts = dict(data)
    np.savez(tmp_path / "frame-1.npz", **{**facts, "fov": facts["fov"] * 0.9, "time_s": taken(2)[1].time_ns * 1e-9})
    with pytest.raises(InputError, match="frame-0.npz and frame-1.npz have different fields of view"):
        set_up_replay(options(tmp_path))


RATE_HZ, WALL_M = 30.0, 2.0


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    """A camera that stands still before a wall."""
    path = tmp_path_factory.mktemp("recorded")
    frames = taken(6, SIZE, 0, 0)
    write_npz(path, [attrs.evolve(frame, depth_m=np.full_like(frame.depth_m, WALL_M)) for frame in frames])
    return path


@pytest.mark.parametrize(("guard", "shown"), [("1.5", [40, 27]), ("1.25x1", [48, 40])])
def test_a_guard_shows_the_middle_of_what_was_recorded(run, folder, guard, shown):
    """Without latency each frame is shown for its own view: its middle pixels are the truth's."""
    summary = run(folder, latency=0.0, warp="none", guard=guard).summary
    assert summary["frames"] == COUNT
    assert [*summary["truth_offset"].values()] == [{"median": 0.0, "most": 0.0}] * 3  # time, turn and place
    assert summary["size"] == shown and summary["rendered"]["size"] == list(SIZE)
    assert summary["quality"]["psnr_db"]["mean"] == 100  # identical pictures
    assert f"the rest is a guard band of {guard}" in summary["notes"][0]


def test_the_rest_of_the_recording_is_a_guard_band(run, folder):
    """The camera turns by 3 degrees in 100 ms: less than the band of 1.5 holds, at least 7."""
    bare, guarded = (
        run(folder, warp="rotation", fill="none", guard=guard).summary["quality"]["hole_share"]["mean"]
        for guard in ("1", "1.5")
    )
    assert bare > 0.04 and guarded == 0


def masked(folder: Path, size: tuple[int, int] = SIZE) -> NDArray[np.bool_]:
    """Write hidden.png beside the frames; return what is seen: all but a band and two corners."""
    x, y = np.meshgrid(np.arange(size[0]), np.arange(size[1]))
    seen = (x >= 4) & (x + y >= 20) & (x - y < size[0] - 10)
    Image.fromarray(np.uint8(255 * seen)).save(folder / MASK)
    return seen


@pytest.mark.parametrize("chain", ["rotation/pyramid", "iterative/stretch+constant", "forward/interpolate+pyramid"])
def test_what_a_mask_hides_of_recorded_frames_is_no_picture(run, tmp_path, chain):
    """Its black is neither warped into view nor filled from, nor counted."""
    folder, (warp, fill) = tmp_path / "masked", chain.split("/")
    folder.mkdir()
    seen = masked(folder)
    # A white wall, black where it is not seen.
    frames = [
        attrs.evolve(frame, colour=np.uint8(255 * seen)[..., None].repeat(3, axis=2), depth_m=np.full(seen.shape, 2.0))
        for frame in taken(6, SIZE)
    ]
    write_npz(folder, frames)
    summary = run(folder, warp=warp, fill=fill).summary
    assert summary["hidden"]["share"] == pytest.approx(1 - seen.mean(), abs=0.002)
    assert summary["quality"]["psnr_db"]["mean"] > 60 and summary["quality"]["hole_share"]["mean"] > 0
    (folder / MASK).rename(tmp_path / "elsewhere.png")
    assert run(folder, warp=warp, fill=fill, hidden=tmp_path / "elsewhere.png").summary["hidden"]
    smeared = run(folder, warp=warp, fill=fill).summary  # without it
    assert "hidden" not in smeared and smeared["quality"]["psnr_db"]["mean"] < 30
    masked(folder, (40, 40))
    with pytest.raises(InputError, match=r"hidden.png: 40x40 pixels; expected 60x40"):
        run(folder, warp=warp)


def test_a_right_eye_beside_the_camera_has_times_and_no_truth(run, wall):
    rows = run(wall, warp="iterative", fill="none", eye_distance=150.0).rows
    assert {row["eye"] for row in rows} == {0, 1}
    assert all(row["psnr_db"] is None for row in rows if row["eye"] == 1)
    assert all(row["total_ms"] > 0 for row in rows)


def test_live_plays_the_recording_forth_and_back(folder, tmp_path):
    """The camera's own head leads; two seconds are five times its length."""
    out = tmp_path / "live"
    said = {"frames": folder, "source": "offscreen", "latency": 100.0, "pictures": 60, "out": out}
    summary = live(LiveOptions.of(said)).summary
    assert (summary["scene"], summary["headset"], summary["trace"]) == ("walk-past", "camera", "walk-past")
    assert any("take the place of a renderer" in note for note in summary["notes"])
    frames = taken(COUNT, SIZE)
    rows = rows_of(out)
    assert {row["eye"] for row in rows} == {"0", "1"}
    drawn = [pose_of(row, "drawn") for row in rows if row["eye"] == "0"]
    numbers = [next(n for n, frame in enumerate(frames) if frame.pose.isclose(pose, 1e-9)) for pose in drawn]
    assert set(np.diff(numbers)) <= {-1, 0, 1} and {0, COUNT - 1} <= set(numbers)
    # From drawing to showing: the latency, at most a refresh of waiting, and two to the display.
    ages = [float(row["age_ms"]) for row in rows]
    assert min(ages) >= 100 and max(ages) <= 100 + 3e3 / RATE_HZ + 1e-3


def test_pages_say_folder_camera_and_eyes_in_place_of_a_scene(folder, tmp_path, gpu):
    for name, more, eyes in (("one", {}, "one, the"), ("both", {"eye_distance": 63.0}, "both, the right one 63 mm")):
        result = replayed(options(folder, tmp_path / name, **more), True, gpu)
        page = html.unescape((tmp_path / name / "report.html").read_text(encoding="utf-8")).replace("<wbr>", "")
        assert f"recorded frames <b>{folder} (12, folder)</b>" in page and "scene <b>" not in page
        assert "camera <b>60×40, 48.5 × 31.9 degrees</b>" in page and f"eyes <b>{eyes}" in page
        assert ("One eye is shown" in page) == (name == "one")
        assert result.summary["recorded"]["folder"] == str(folder)


@pytest.fixture(scope="module")
def gaps(tmp_path_factory):
    """Eight frames of a wall; the camera saw no depth in a quarter of it."""
    path = tmp_path_factory.mktemp("recorded")
    frames = taken(8, SIZE)
    for frame in frames:
        frame.depth_m[10:30, 15:45] = 0
    write_npz(path, frames)
    return path


def test_late_frames_are_repaired_and_the_truth_is_not(run, gaps):
    usual = {"latency": 67.0, "warp": "iterative", "fill": "none", "metrics_every": 2}
    plain, mended = (run(gaps, repair=repair, **usual).summary for repair in ("none", "edges+complete"))
    holes, psnr = ([one["quality"][name]["mean"] for one in (plain, mended)] for name in ("hole_share", "psnr_db"))
    # The gap is a quarter of the picture; repaired, what is left is what the camera has turned to.
    assert holes[0] > 0.25 and holes[1] < 0.1 and psnr[1] > psnr[0] + 3
    told = "The depth of late frames is mended by edges+complete"
    assert [any(told in note for note in one["notes"]) for one in (plain, mended)] == [False, True]


def test_the_server_gives_repaired_frames_and_truth_as_it_was_recorded(gaps, gpu):
    from hmdwarp.gpu import download

    sequence = sequences.open(gaps).repaired(parse_repairs("complete"))
    server = RecordingSource(sequence).renderer(gpu, PipelineOptions())
    late = server.draw_frame([sequence.frames[0].view], 10**9, SIZE).eyes[0]
    inverse, colour = download(late.inverse_depth), download(late.colour)
    truth = server.draw(late.view, SIZE, time_ns=10**9)
    assert (inverse > 0).all() and (download(truth.inverse_depth)[10:30, 15:45] == -1).all()
    assert np.array_equal(download(truth.colour), colour)  # a repair changes no colour
    server.close()


def test_another_head_keeps_its_jumps_as_far_as_the_recording_lasts(folder):
    loaded = load_trace("walk")
    jumped = attrs.evolve(loaded, track=loaded.track.evolve(jumps=[3, len(loaded.track) - 2]))
    assert RecordingSource(sequences.open(folder)).head(jumped).track.jumps == (3,)
