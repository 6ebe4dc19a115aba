"""Whole replays.

What they write, that every choice in the registries runs, and that each option does what it says.
"""

from __future__ import annotations

import itertools
import json
import math
import re
from pathlib import Path

import numpy as np
import pytest
from made import counting_made
from replays import contents, rows_of, run, small, suited

from hmdwarp.base import HmdwarpError, InputError, __version__
from hmdwarp.client.fills import fills
from hmdwarp.poses import Origin, load_trace, synthesise, write_synthetic
from hmdwarp.report import FRAME_COLUMNS, validate_summary, write_text
from hmdwarp.run import set_up_replay

QUALITY_AT = ("psnr_db", "ssim", "flip", "hole_share", "border_share")


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    """One second of everything: 60 refreshes, both warps, video, pictures."""
    out = tmp_path_factory.mktemp("full") / "made" / "here"
    result = run(
        out, trace="walk", seconds=1.0, fill="interpolate", lens="radial", headset="rift-dk1", against="none", images=3,
        video=True, command="hmdwarp replay walk", workers=1, page=True,
    )  # fmt: skip
    return out, result


def test_writes_what_design_says_and_nothing_else(full):
    out, _ = full
    # Three of the measured refreshes, a third of the run apart.
    measured = sorted({int(row["frame"]) for row in rows_of(out) if row["psnr_db"]})
    chosen = [measured[at] for at in (0, 4, 8)]
    pictures = {f"images/frame-{number:06d}-{eye}.png" for number in chosen for eye in ("left", "right")}
    assert set(contents(out)) == {"summary.json", "frames.csv", "report.html", "replay.mp4"} | pictures


def test_a_run_that_ends_earlier_shows_the_same(tmp_path):
    """And its frames weigh the same: of those that never arrive no pictures are drawn."""
    ends = {name: run(tmp_path / name, trace="walk", seconds=seconds) for name, seconds in (("a", 0.1), ("b", 0.4))}
    short, long = (rows_of(tmp_path / name) for name in ends)
    assert 0 < len(short) < len(long)
    for row, same in zip(short, long, strict=False):
        assert [row[name] for name in QUALITY_AT] == [same[name] for name in QUALITY_AT]
    weights = {result.summary["link"]["frame_bytes"] for result in ends.values()}
    assert len(weights) == 1 and weights != {0}


def test_summary_keeps_to_the_schema(full):
    out, result = full
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    validate_summary(summary)
    assert summary == json.loads(json.dumps(result.summary))
    asked = {
        "trace": "walk", "scene": "planes", "effects": [], "latency_ms": 200.0, "warp": "forward",
        "fill": "interpolate", "lens": "radial", "headset": "rift-dk1", "size": [96, 80], "frames": 60,
        "hmdwarp": __version__,
    }  # fmt: skip
    assert {key: summary[key] for key in asked} == asked
    assert summary["against"][0]["warp"] == "none"
    assert set(summary["against"][0]["quality"]) == set(summary["quality"])


def test_a_row_per_frame_and_eye(full):
    out, _ = full
    rows = rows_of(out)
    assert tuple(rows[0]) == FRAME_COLUMNS
    assert [(int(row["frame"]), int(row["eye"])) for row in rows] == list(itertools.product(range(60), (0, 1)))
    track = load_trace("walk").track
    for row in rows:
        assert int(row["shown_ns"]) - int(row["drawn_ns"]) == pytest.approx(float(row["age_ms"]) * 1e6, abs=0.5)
        assert float(row["time_s"]) == pytest.approx((int(row["shown_ns"]) - track.start_ns) * 1e-9)
        assert row["pose_origin"] == Origin(track.at(int(row["shown_ns"])).origin).name.lower()
        stages = [float(row[f"{stage}_ms"]) for stage in ("warp", "fill", "effects", "lens")]
        assert float(row["total_ms"]) == pytest.approx(sum(stages))
        assert stages[0] > 0 and stages[1] > 0 and stages[2] == 0 and stages[3] > 0
        assert len({row[name] == "" for name in QUALITY_AT}) == 1
    # One of every five, the first of all at the first, and at no fixed place.
    measured = [int(row["frame"]) for row in rows[::2] if row["psnr_db"]]
    assert [number // 5 for number in measured] == list(range(12)) and measured[0] == 0
    assert {number % 5 for number in measured} == {0, 1, 2, 3, 4}
    # Flicker needs the refresh before, which the first one has not.
    assert {int(row["frame"]) for row in rows if row["flicker"]} == set(measured[1:])


def test_video_has_every_refresh(full):
    import av

    out, _ = full
    with av.open(str(out / "replay.mp4")) as video:
        stream = video.streams.video[0]
        frames = [frame.to_ndarray(format="rgb24") for frame in video.decode(stream)]
        assert (stream.width, stream.height, float(stream.average_rate)) == (192, 80, 60.0)
    assert len(frames) == 60
    assert np.std(frames[0]) > 10


@pytest.mark.parametrize(
    ("warp", "fill", "lens"),
    [(warp, fills.names()[i % len(fills.names())], ("none", "radial")[i // 2 % 2]) for i, warp in enumerate(suited())],
)
def test_every_warp_fill_and_lens_runs(warp, fill, lens, gpu, tmp_path):
    """Every two of them compile, draw and cost what they must in tests/client/test_plan.py."""
    result = run(tmp_path, gpu=gpu, warp=warp, fill=fill, lens=lens, headset="rift-dk1", seconds=0.1)
    validate_summary(result.summary)
    assert (result.summary["warp"], result.summary["fill"], result.summary["lens"]) == (warp, fill, lens)
    assert result.summary["frames"] == 6
    # Of six refreshes: a GPU's timer has ticks, and one pass of so few pixels may fall between two.
    for stage, runs in (("warp_ms", True), ("fill_ms", fill != "none"), ("lens_ms", lens != "none")):
        assert (sum(row[stage] for row in result.rows) > 0) == runs, stage
    assert all(math.isfinite(result.summary["quality"][name]["mean"]) for name in QUALITY_AT)


# --- options


def test_start_and_seconds_choose_the_part(tmp_path):
    rows = run(tmp_path, start_s=3.0, seconds=0.25).rows
    assert (rows[0]["time_s"], rows[-1]["time_s"]) == pytest.approx((3.0, 3.0 + 14 / 60))


def test_without_a_rate_and_a_size_the_headset_decides(tmp_path):
    text = Path("hmdwarp/headsets/flat-90.toml")
    source = (Path(__file__).resolve().parents[2] / text).read_text(encoding="utf-8")
    mine, small_eyes = tmp_path / "mine.toml", re.sub(r"eye_size_px = .*", "eye_size_px = [48, 40]", source)
    mine.write_text(small_eyes.replace('name = "flat-90"', 'name = "mine"'), encoding="utf-8")
    summary = run(tmp_path / "out", headset=str(mine), size=None, rate_hz=None, seconds=0.1).summary
    expected = {"headset": "mine", "size": [48, 40], "rate_hz": 90.0, "frames": 9}
    assert {name: summary[name] for name in expected} == expected


def test_a_guard_of_one_axis_takes_the_border_away_where_the_head_turns(tmp_path):
    """A head that turns to the left looks beyond the sides, and beyond the corners a little higher.

    30 degrees a second for 200 ms are 6 degrees: tan(51) = 1.23 across, and 1 / (cos(6) - sin(6)) =
    1.12 up and down in the corners. However high the picture, its sides stay.
    """
    turning = tmp_path / "turning.csv"
    with turning.open("w") as stream:
        write_synthetic(synthesise("rotate", speed=30, seconds=2), stream)
    usual = {"trace": str(turning), "warp": "rotation", "start_s": 0.5}
    higher = run(tmp_path / "higher", **usual, guard=(1.05, 1.5)).summary
    wider = run(tmp_path / "wider", **usual, guard=(1.3, 1.15)).summary
    assert higher["quality"]["border_share"]["mean"] > 0.05
    assert wider["quality"]["border_share"]["mean"] == 0
    assert (higher["guard"], wider["guard"]) == ("1.05x1.5", "1.3x1.15")
    # The picture is 96x80 for 90 degrees: 15 pixels more (14.4, rounded up) on either side, 6 above
    # and below.
    assert wider["rendered"]["size"] == [126, 92]
    assert wider["rendered"]["pixels"] == pytest.approx(126 * 92 / (96 * 80), abs=1e-4)
    degrees = [2 * math.degrees(math.atan(factor)) for factor in (126 / 96, 1.15)]
    assert wider["rendered"]["fov_deg"] == pytest.approx(degrees, abs=0.01)


def test_against_compares_with_another_warp(tmp_path):
    result = run(tmp_path / "a", warp="rotation", against="none,forward+interpolate", metrics_every=3)
    pairs = [("none", "none"), ("forward", "interpolate")]
    assert [(summary["warp"], summary["fill"]) for summary in result.against] == pairs
    alone, filled = (
        run(tmp_path / warp, warp=warp, fill=fill, metrics_every=3).summary["quality"] for warp, fill in pairs
    )
    for against in (result.against, result.summary["against"]):
        assert [summary["quality"] for summary in against] == [alone, filled]
    assert all(summary["time_ms"]["warp"]["median"] > 0 for summary in result.against)
    # The same instants, so the difference of the means is the mean of the differences.
    mine, other = result.summary["quality"], alone
    for name, entry in result.summary["against"][0]["difference"].items():
        assert entry["mean"] == pytest.approx(mine[name]["mean"] - other[name]["mean"], abs=1e-9)
        assert entry["interval"][0] <= entry["mean"] <= entry["interval"][1]
        assert mine[name]["interval"][0] <= mine[name]["mean"] <= mine[name]["interval"][1]


@pytest.mark.parametrize("against", ["", "rotation"])
def test_without_a_different_warp_there_is_no_comparison(against, tmp_path):
    result = run(tmp_path, warp="rotation", against=against, seconds=0.1)
    assert result.against == [] and "against" not in result.summary


@pytest.mark.parametrize("images", [0, 1, 4, 1000])
def test_about_as_many_pictures_as_asked_for(images, tmp_path):
    run(tmp_path, images=images, metrics_every=2)  # 15 measured refreshes
    kept = {path.stem.split("-")[1] for path in (tmp_path / "images").glob("*.png")}
    assert len(kept) == {0: 0, 1: 1, 4: 4, 1000: 15}[images]


def test_a_second_run_replaces_the_first_and_touches_nothing_else(tmp_path):
    run(tmp_path, images=4, metrics_every=2, video=True)
    write_text(tmp_path / "notes.txt", "mine")
    write_text(tmp_path / "images" / "mine.png", "mine")
    run(tmp_path, images=1, metrics_every=2)
    pictures = {"images/frame-000000-left.png", "images/frame-000000-right.png"}
    mine = {"notes.txt", "images/mine.png"}
    assert set(contents(tmp_path)) == {"summary.json", "frames.csv", "report.html"} | pictures | mine


def test_trace_options_reach_the_reader(tmp_path):
    from hmdwarp.poses import TraceOptions

    rows = "".join(f"{i} 0 0 {0.001 * i:.4f} 0 0 0 1\n" for i in range(100))
    path = tmp_path / "head.txt"
    path.write_text(rows, encoding="utf-8")
    result = run(
        tmp_path / "out", trace=str(path), seconds=0.2,
        trace_options=TraceOptions(format="tum", rate=50.0, scale=0.5, axes="ros"),
    )  # fmt: skip
    assert result.rows[0]["linear_speed_m_s"] == pytest.approx(0.001 * 0.5 * 50, rel=1e-6)
    axes = "ros (world=-y,z,x head=-y,z,x), as --axes says"
    assert result.summary["trace_axes"] == axes


# --- frames and memory


def test_a_long_run_takes_no_more_than_a_short_one(tmp_path):
    """10 s against 2 s: as many textures and buffers ever made; test_refreshes.py counts frames."""
    # The first run of a process makes what is probed once, such as what GPU timers tell.
    run(tmp_path / "first", seconds=0.1, size=(16, 12))
    counts = []
    for seconds in (2.0, 10.0):
        asked = {"trace": "walk", "seconds": seconds, "size": (16, 12), "rate_hz": 20.0, "metrics_every": 10}
        with counting_made() as made:
            assert run(tmp_path / "out", **asked).summary["frames"] == 20 * seconds
        counts.append(dict(made))
    assert counts[0] == counts[1]


def test_failing_in_the_middle_leaves_the_earlier_results(tmp_path, monkeypatch):
    from hmdwarp.run import replay

    run(tmp_path, images=1)
    before = contents(tmp_path)

    def stop(done: int, total: int) -> None:
        if done == 7:
            raise HmdwarpError("stopped")

    with pytest.raises(HmdwarpError, match="stopped"):
        replay(small(tmp_path, images=3, video=True, workers=1), stop)
    assert contents(tmp_path) == before
    assert sorted(p.name for p in tmp_path.iterdir()) == ["frames.csv", "images", "report.html", "summary.json"]


def test_the_summary_says_what_the_client_must_hold(tmp_path, gpu):
    fill = "interpolate+model:share=0.5,texture=0.5,light=off"
    (model,) = run(tmp_path / "out", gpu=gpu, fill=fill, seconds=0.1).summary["client_models"]
    assert (model["share"], model["texture"], model["triangles"]) == (0.5, 0.5, 10)  # few enough to keep all of them
    assert "client_models" not in run(tmp_path / "none", gpu=gpu, seconds=0.1).summary


def long_trace(path: Path, seconds: float) -> Path:
    """A head at rest whose poses are 50 s apart."""
    instants = np.arange(0.0, seconds + 50, 50)
    path.write_text("time_s,px,py,pz,qx,qy,qz,qw\n" + "".join(f"{at:.0f},0,0,0,0,0,0,1\n" for at in instants))
    return path


def test_more_than_a_day_at_more_than_1_hz_asks_for_seconds(tmp_path):
    trace = long_trace(tmp_path / "week.csv", 7 * 86_400)
    with pytest.raises(InputError, match=r"7\.0 days.*--seconds"):
        set_up_replay(small(trace=str(trace), seconds=None))
    for allowed in ({"seconds": 0.5}, {"seconds": None, "rate_hz": 1.0, "latency_ms": 1000.0}):
        with set_up_replay(small(trace=str(trace), **allowed)) as setup:
            assert setup.schedule.count >= 30
