"""What of recorded frames is shown: the middle of them, to both eyes, live, and as a plan says."""

from __future__ import annotations

import csv
import html
from pathlib import Path

import attrs
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from recorded_folders import fov_of, seen_from, taken, write_npz
from replays import replayed

from hmdwarp.errors import InputError
from hmdwarp.geometry import Pose
from hmdwarp.run import LiveOptions, RunOptions, live
from hmdwarp.sources import sequences
from hmdwarp.sources.sequences.options import MASK

from .recorded import COUNT, SIZE

RATE_HZ, WALL_M = 30.0, 2.0


@pytest.fixture(scope="module")
def wall(tmp_path_factory):
    """A camera that stands still before a wall."""
    path = tmp_path_factory.mktemp("recorded") / "wall"
    path.mkdir()
    write_npz(
        path, [attrs.evolve(frame, depth_m=np.full_like(frame.depth_m, WALL_M)) for frame in taken(6, SIZE, 0, 0)]
    )
    return path


@pytest.mark.parametrize(("guard", "shown"), [("1.5", [40, 27]), ("1.25x1", [48, 40])])
def test_a_guard_shows_the_middle_of_what_was_recorded(run, folder, guard, shown):
    """Without latency each frame is shown for its own view: its middle pixels are the truth's."""
    summary = run(folder, latency=0.0, warp="none", guard=guard).summary
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
    smeared = run(folder, warp=warp, fill=fill).summary
    assert "hidden" not in smeared and smeared["quality"]["psnr_db"]["mean"] < 30
    masked(folder, (40, 40))
    with pytest.raises(InputError, match=r"hidden.png: 40x40 pixels; expected 60x40"):
        run(folder, warp=warp)


def test_a_right_eye_sees_the_wall_from_beside_the_camera(run, wall):
    """It lacks the strip of the wall that the camera did not see: as wide as it sits beside it."""
    eye_distance_mm = 150.0
    result = run(wall, warp="iterative", fill="none", eye_distance=eye_distance_mm)
    left, right = fov_of(SIZE).tangents[:2]
    strip = eye_distance_mm / 1e3 / WALL_M / (right - left)
    found = result.summary["second_eye"]
    assert found["camera_hole_share"] == 0
    assert found["hole_share"] == pytest.approx(strip, abs=1 / SIZE[0])  # whole columns of pixels
    assert any("Nothing was recorded where the right eye is" in note for note in result.summary["notes"])
    rows = result.rows
    assert {row["eye"] for row in rows} == {0, 1}
    assert all(row["psnr_db"] is None for row in rows if row["eye"] == 1)
    assert all(row["total_ms"] > 0 for row in rows)


def test_a_right_eye_that_was_recorded_is_measured_from_the_left_eyes_frames(run, tmp_path):
    """It lacks a strip at its border, black without a fill; the left one a pixel without depth."""
    folder, beside_m = tmp_path / "both", 0.15
    (folder / "right").mkdir(parents=True)
    left = taken(COUNT, SIZE, step_m=0, step_deg=0)
    write_npz(folder, left)
    write_npz(folder / "right", [seen_from(one.pose @ Pose((beside_m, 0, 0)), one.time_ns, SIZE) for one in left])
    result = run(folder, warp="iterative", fill="none", eye_distance=1e3 * beside_m)
    found = result.summary["second_eye"]
    assert found["camera_psnr_db"] > found["psnr_db"] + 10  # it stands still
    filled = run(folder, warp="iterative", fill="pyramid", eye_distance=1e3 * beside_m).summary
    assert filled["second_eye"]["psnr_db"] > found["psnr_db"] + 3
    assert any("from the left eye's frames alone" in note for note in filled["notes"])
    with pytest.raises(InputError, match="has a right eye 150 mm beside; expected that, or 0"):
        run(folder, eye_distance=63.0)


def test_a_right_eye_of_other_instants_is_refused(tmp_path):
    (tmp_path / "right").mkdir()
    write_npz(tmp_path, taken(COUNT))
    write_npz(tmp_path / "right", taken(COUNT - 1))
    with pytest.raises(InputError, match="frames of other instants"):
        sequences.open(tmp_path)


def test_live_plays_the_recording_forth_and_back(folder, tmp_path):
    """The camera's own head leads; two seconds are five times its length."""
    out = tmp_path / "live"
    result = live(
        LiveOptions.of({"frames": folder, "source": "offscreen", "latency": 100.0, "pictures": 60, "out": out})
    )
    summary = result.summary
    assert (summary["scene"], summary["headset"], summary["trace"]) == ("walk-past", "camera", "walk-past")
    assert any("take the place of a renderer" in note for note in summary["notes"])
    frames = taken(COUNT, SIZE)
    with (out / "frames.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["eye"] for row in rows} == {"0", "1"}
    drawn = [
        Pose([float(row[f"drawn_{axis}_m"]) for axis in "xyz"], [float(row[f"drawn_q{axis}"]) for axis in "xyzw"])
        for row in rows
        if row["eye"] == "0"
    ]
    numbers = [next(n for n, frame in enumerate(frames) if frame.pose.isclose(pose, 1e-9)) for pose in drawn]
    assert set(np.diff(numbers)) <= {-1, 0, 1} and {0, COUNT - 1} <= set(numbers)
    # From drawing to showing: the latency, at most a refresh of waiting, and two to the display.
    ages = [float(row["age_ms"]) for row in rows]
    assert min(ages) >= 100 and max(ages) <= 100 + 3e3 / RATE_HZ + 1e-3


def test_live_shows_one_eye_in_the_flat_view(folder, tmp_path):
    said = {"frames": folder, "source": "offscreen", "view": "flat", "latency": 0.0, "pictures": 4, "guard": "1.5"}
    summary = live(LiveOptions.of({**said, "out": tmp_path / "live", "trace": "look-around"})).summary
    assert summary["size"] == [40, 27] and summary["rendered"]["size"] == list(SIZE)


def test_pages_say_folder_camera_and_eyes_in_place_of_a_scene(folder, tmp_path, gpu):
    said = {"frames": folder, "latency": 100.0, "metrics_every": 3, "workers": 0, "images": 0, "against": ""}
    for name, more, eyes, time in (
        ("one", {}, "one, the camera's", "warp to lens, the camera's eye"),
        ("both", {"eye_distance": 63.0}, "both, the right one 63 mm from the camera", "warp to lens, both eyes"),
    ):
        out = tmp_path / name
        result = replayed(RunOptions.of({**said, **more, "out": out}), True, gpu)
        page = html.unescape((out / "report.html").read_text(encoding="utf-8")).replace("<wbr>", "")
        assert f"recorded frames <b>{folder} (12, folder)</b>" in page
        assert "camera <b>60×40, 48.5 × 31.9 degrees</b>" in page
        assert f"eyes <b>{eyes}</b>" in page and time in page and "reading the recorded frame" in page
        assert "scene <b>" not in page and "what a renderer without any delay" not in page
        assert result.summary["recorded"]["folder"] == str(folder)
