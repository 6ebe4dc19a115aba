"""What a page reports: written as a live run's results, replayed, and refused where it is wrong."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import needs
import numpy as np
import pytest
from commands import hmdwarp
from PIL import Image
from serving import Serving

from hmdwarp.errors import InputError
from hmdwarp.headsets import load_headset
from hmdwarp.run import ServeOptions
from hmdwarp.run.browser_log import COLUMNS, MOST_TEXT, BrowserLogs
from hmdwarp.web import STEPS

from .browser import CANTED, Browser, entered, wear
from .looks import CLOCK, enter_vr_at_once, look_after, pictures_of

DISPLAY = {
    "browser": "a browser", "renderer": "a GPU", "codec": "av1", "trace": "walk", "width": 120, "height": 130,
    "rendered_width": 150, "rendered_height": 162,
    "views": [[x, 0, 0, 0, 0, 0, 1, -0.7, 0.7, -0.7, 0.7] for x in (-0.034, 0.034)],
    "rate_hz": 90, "latency_ms": 100, "guard": 1.25, "chains": ["iterative", "mesh:grid=64", "rotation"],
}  # fmt: skip

KNOWN_MS = 120  # of a head's motion, that the predictor knows
REFRESH_MS, LATENCY_MS = 16, 100  # whole in ns; between two refreshes, so that no rounding of theirs matters


def rows(count: int = 200, **changed) -> np.ndarray:
    """Refreshes of a head that stands; each frame is shown three times, from 100 ms on."""
    table = np.zeros((count, len(COLUMNS)))
    columns = {name: table[:, k] for k, name in enumerate(COLUMNS)}
    frame = np.arange(count) // 3
    columns["shown_ms"][:] = 1000 + np.arange(count) * 1000 / 90
    columns["asked_ms"][:] = 900 + 3 * frame * 1000 / 90
    columns["frame"][:] = frame
    columns["warp_ms"][:], columns["render_ms"][:], columns["round_ms"][:] = 2, 5, 60
    columns["shown_qw"][:] = columns["drawn_qw"][:] = 1
    for name, value in changed.items():
        columns[name][-1] = value
    return table


@pytest.fixture
def logs(tmp_path):
    said: list[str] = []
    with_logs = BrowserLogs(tmp_path / "out", "room", said.append)
    with_logs.said = said
    yield with_logs
    with_logs.close()


def test_a_session_is_written_as_a_live_run(logs, tmp_path):
    log = logs.begin()
    log.take(json.dumps(DISPLAY))
    log.take(rows().tobytes())
    for _ in range(400):
        log.sent(12.0, 10.0, 10_000)
    later = rows()
    later[:, :2] += 5000  # nothing for 2.8 s
    log.take(later.tobytes())
    log.close()
    folder = tmp_path / "out" / "session-0001"
    assert logs.said == [f"a browser's session, 400 refreshes: {folder}"]
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert (summary["frames"], summary["warp"], summary["size"]) == (400, "iterative", [120, 130])
    assert summary["time_ms"]["warp"]["median"] == 2 and summary["live"]["source"] == "browser"
    assert 100 <= summary["live"]["age_ms"]["median"] <= 123 and summary["live"]["missed"] == 250
    parts = summary["link"]["response_ms"]
    assert (parts["render_ms"], parts["round_trip_ms"]) == (5, 55) and parts["total_ms"] == pytest.approx(104)
    assert summary["link"]["codec"] == "av1"
    assert summary["link"]["mbit_s"] == pytest.approx(400 * 0.08 / summary["live"]["seconds"])
    assert summary["link"]["server"] == {"took_ms": 12, "drawing_ms": 10, "own_ms": 2, "own_share": 0.2}
    assert len((folder / "delays.csv").read_text(encoding="utf-8").split()) == 1 + 2 * 67
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "Frame age at display" in page and "2.0 ms, 20.0% of drawing and coding" in page


ROW = {"chain": "iterative", "fill": "none", "warp_ms": [2, 3], "total_ms": [3, 4]}
ROW |= {"square": [9.0], "means": [[7] * 192]}
BENCH = {"clock": "gpu", "how": "a timer", "seconds": 2, "instants_ms": [500.0], "rows": [ROW]}


def bench(**changed) -> str:
    return json.dumps({"bench": DISPLAY | BENCH | changed})


def test_a_bench_is_kept_beside_the_sessions(logs, tmp_path):
    log = logs.begin()
    log.take(bench())
    log.close()
    data = json.loads((tmp_path / "out" / "bench-0001" / "bench.json").read_text(encoding="utf-8"))
    (row,) = data["rows"]
    assert (row["warp"], row["fill"], row["clock"]) == ("iterative:seed=rotation,steps=5", "none", "gpu")
    assert row["time_ms"]["warp"]["median"] == 2.5 and row["time_ms"]["fill"]["median"] == 1
    assert row["quality"]["psnr_db"]["mean"] == pytest.approx(20 * np.log10(255 / 3))


def later(**changed) -> bytes:
    """Return a message of the refreshes after the first 50, the last of which is changed."""
    return rows(**changed)[50:].tobytes()


WRONG = {
    "no JSON": "{",
    "deep JSON": "[" * MOST_TEXT,
    "other keys": json.dumps({"browser": "x"}),
    "a list": "[]",
    "not a number": json.dumps(DISPLAY | {"rate_hz": "90"}),
    "no finite number": json.dumps(DISPLAY | {"rate_hz": float("nan")}),
    "a size that is huge": json.dumps(DISPLAY | {"width": 1e9}),
    "an empty view": json.dumps(DISPLAY | {"views": [[0, 0, 0, 0, 0, 0, 1, 0.7, 0.7, -0.7, 0.7]]}),
    "a view of no numbers": json.dumps(DISPLAY | {"views": [["x"] * 11]}),
    "a view that is turned by nothing": json.dumps(DISPLAY | {"views": [[0] * 7 + [-0.7, 0.7, -0.7, 0.7]]}),
    "an eye that is NaN": json.dumps(DISPLAY | {"views": [[float("nan"), 0, 0, 0, 0, 0, 1, -0.7, 0.7, -0.7, 0.7]]}),
    "eyes that look past each other": json.dumps(
        DISPLAY | {"views": [[0, 0, 0, 0, turn, 0, 0.6, -0.7, 0.7, -0.7, 0.7] for turn in (-0.8, 0.8)]}
    ),
    "three eyes": json.dumps(DISPLAY | {"views": DISPLAY["views"][:1] * 3}),
    "letters of a terminal": json.dumps(DISPLAY | {"browser": "\x1b[2J"}),
    "a codec that is none": json.dumps(DISPLAY | {"codec": ["av1"]}),
    "a chain that is none": json.dumps(DISPLAY | {"chains": ["../../etc"]}),
    "a list of lists": json.dumps(DISPLAY | {"chains": [[]]}),
    "long": json.dumps(DISPLAY | {"browser": "x" * MOST_TEXT}),
    "a bench of nothing": json.dumps({"bench": {}}),
    "a bench that is a list": json.dumps({"bench": [[]]}),
    "a long bench": json.dumps({"bench": "x" * 70_000}),
    "a bench at no instants": bench(instants_ms=5),
    "a bench at many instants": bench(instants_ms=[1.0] * 17),
    "a bench of another clock": bench(clock=["gpu"]),
    "a bench of no rows": bench(rows=[]),
    "a bench of many rows": bench(rows=[ROW] * 7),
    "a bench of another chain": bench(rows=[ROW | {"chain": ["iterative"]}]),
    "a bench's time that is none": bench(rows=[ROW | {"warp_ms": [True, 3]}]),
    "a bench's time that is NaN": bench(rows=[ROW | {"total_ms": [3, float("nan")]}]),
    "a bench's times too few": bench(rows=[ROW | {"total_ms": [3]}]),
    "a bench's error that is huge": bench(rows=[ROW | {"square": [1e300]}]),
    "a bench's picture too small": bench(rows=[ROW | {"means": [[7] * 191]}]),
    "a bench's picture that is none": bench(rows=[ROW | {"means": 7}]),
    "half a row": later()[:-3],
    "no row": b"",
    "NaN": later(shown_x_m=np.nan),
    "far": later(shown_x_m=1e300),
    "no unit quaternion": later(drawn_qw=2),
    "another chain": later(chain=3),
    "half a chain": later(chain=0.5),
    "the future": later(asked_ms=1e8),
    "back in time": later(shown_ms=1),
    "negative": later(warp_ms=-1),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_no_page_says_is_refused_and_what_came_before_stays(logs, tmp_path, monkeypatch, wrong):
    monkeypatch.setattr("hmdwarp.run.browser_log.render_live_report", lambda *_, **__: "no page")
    log = logs.begin()
    log.take(json.dumps(DISPLAY))
    log.take(rows()[:50].tobytes())
    log.take(WRONG[wrong])
    log.take(rows()[50:].tobytes())  # it has no say any more
    log.close()
    refused, written = logs.said
    assert refused.startswith("a browser's report is not taken") and refused.isprintable() and len(refused) < 400
    assert "50 refreshes" in written
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["session-0001"]


def test_refreshes_of_no_display_and_too_few_leave_nothing(logs, tmp_path):
    first, second = logs.begin(), logs.begin()
    first.take(rows().tobytes())
    second.take(json.dumps(DISPLAY))
    second.take(rows()[:1].tobytes())
    second.close()
    assert not (tmp_path / "out").exists() or not list((tmp_path / "out").iterdir())


def test_reports_come_by_the_door():
    with pytest.raises(InputError, match="--web"):
        ServeOptions(out="out")


def _rows(folder: Path) -> list[dict[str, str]]:
    with (folder / "frames.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


# How old a frame has been in a page's session, how long that goes on, and its first frame. A page
# that stands still for too long on a busy machine is cut, and begins another session.
NOTES = """{
  const { report } = hmdwarp.session, { add } = report;
  let { socket } = report.feed;
  Object.assign(globalThis, { oldest: hmdwarp.session.time(), first: hmdwarp.session.time(), latest: 0, begun: 0 });
  report.add = function (now, frame, ...rest) {
    if (report.told === null) globalThis.oldest = 0;
    const isNew = report.told === null || socket !== report.feed.socket;
    if (isNew) Object.assign(globalThis, { first: now, begun: frame.number });
    socket = report.feed.socket;
    Object.assign(globalThis, { oldest: Math.max(oldest, now - frame.time), latest: now });
    return add.call(this, now, frame, ...rest);
  };
}"""
# Whether it is enough: a replay begins once the frame with the longest delay is there.
ENOUGH = "hmdwarp.session.shown.number > begun + 30 && latest - first > 1.5 * oldest"


def _refreshes(folder: Path) -> list[dict[str, str]]:
    return [row for row in _rows(folder) if row["eye"] == "0"]


@needs.programs("chromium")
@pytest.mark.parametrize("eyes", [1, pytest.param(2, marks=needs.from_npm("iwer"))])
def test_a_session_can_be_replayed(tmp_path, eyes):
    """That of a window, and of an emulated headset.

    The replay's frames are drawn at even times, the browser's when it asked: what is the same are
    their delays, until they are first shown, and the head that the page was warped to.
    """
    with (
        Serving("--scene", "room", "--web", "127.0.0.1:*", "--out", str(tmp_path / "out")) as server,
        Browser(tmp_path / "profile", (240, 130)) as browser,
    ):
        address = server.line("for a browser").split()[-1] + "&raw&trace=walk&latency=100&size=96"
        if eyes == 2:
            wear(browser)
        browser.open(address)
        browser.until("hmdwarp.session.report")
        browser.does(NOTES)
        if eyes == 2:
            entered(browser)
        socket = "hmdwarp.session.feed.socket.readyState"
        ends = "hmdwarp.session.report.send(hmdwarp.session.time()), hmdwarp.session.feed.close(), true"
        browser.until(f"{ENOUGH} && {socket} === 1 && ({ends})")
        browser.until(f"{socket} === 3")  # all that was sent has arrived
    folder = max((tmp_path / "out").iterdir())  # a headset's window has a session before it
    summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    assert summary["trace"] == ("webxr" if eyes == 2 else "walk")
    session = _refreshes(folder)
    assert {row["eye"] for row in _rows(folder)} == {str(eye) for eye in range(eyes)}
    frames, seconds = summary["link"]["frames"]["shown"], summary["live"]["seconds"]
    rate, server_rate = len(session) / seconds, frames / seconds
    width, height = summary["size"]
    command = [
        *("replay", f"{folder}/trace.csv", "--scene", "room", "--against", "", "--samples", "1"),
        *("--delay-trace", f"{folder}/delays.csv", "--rate", str(rate), "--server-rate", str(server_rate)),
        *("--size", f"{width}x{height}", "--metrics-every", "1000", "--workers", "0", "--images", "0", "--quiet"),
        *("--headset", f"{folder}/headset.toml", "--fill", "none", "--out", str(tmp_path / "replay")),
    ]
    done = hmdwarp(*command, page=False)
    assert done.returncode == 0, done.stderr
    assert abs(load_headset(f"{folder}/headset.toml").ipd_m - (0.068 if eyes == 2 else 0)) < 1e-6
    replayed = _refreshes(tmp_path / "replay")
    delays = np.loadtxt(folder / "delays.csv", skiprows=1)
    ages = [float(row["age_ms"]) for row in session]
    is_first = np.diff([int(row["drawn_ns"]) for row in session], prepend=0) != 0
    np.testing.assert_allclose(delays, np.array(ages)[is_first], atol=1e-3)  # as written
    # Each refresh shows the newest frame whose delay is over. Rates within a thousandth of a whole
    # ratio are taken for that.
    shown_ms, age_ms = (np.array([float(row[name]) for row in replayed]) for name in ("shown_ns", "age_ms"))
    shown_ms *= 1e-6
    begun_ms, interval_ms = shown_ms[0] - 1e3 * math.ceil(delays.max() * 1e-3 * rate - 1e-3) / rate, 1e3 / server_rate
    off_ms = 1e-3 * (shown_ms[-1] - begun_ms) + 1e-3
    drawn_ms = np.arange(begun_ms, shown_ms[-1] + interval_ms, interval_ms)
    there_ms = drawn_ms + np.resize(delays, drawn_ms.size)
    for at_ms, number in zip(shown_ms, np.rint((shown_ms - age_ms - begun_ms) / interval_ms).astype(int), strict=True):
        assert there_ms[number] <= at_ms + off_ms and (there_ms[number + 1 :] > at_ms - off_ms).all()
    between = [row for row in replayed if row["pose_origin"] == "interpolated"]  # over a gap the head is held
    for part in ("shown_x_m", "shown_y_m", "shown_z_m"):
        (at, place), (at_again, place_again) = (
            np.array([(float(row["time_s"]), float(row[part])) for row in rows]).T for rows in (session, between)
        )
        # Both interpolate linearly; times are written in nanoseconds, in which a head moves less.
        np.testing.assert_allclose(place_again, np.interp(at_again, at, place), atol=1e-6)


def _picture(folder: Path, number: int, eye: int, size: tuple[int, int]) -> np.ndarray:
    """Return what a replay showed: of truth, late frame, warped and error, below their labels."""
    with Image.open(folder / "images" / f"frame-{number:06d}-{('left', 'right')[eye]}.png") as file:
        strip = np.asarray(file.convert("RGB"))
    width, height = size
    at = 2 * (width + (strip.shape[1] - 4 * width) // 3)
    return strip[-height:, at : at + width]


@needs.programs("chromium")
@pytest.mark.parametrize("eyes", [1, pytest.param(2, marks=needs.from_npm("iwer"))])
def test_a_replay_shows_what_the_page_showed(tmp_path, eyes):
    """A window, and an emulated headset whose eyes are canted and unequal.

    Its guard band is of whole pixels on each side, which a replay would round up to.

    The clock is stepped, so frames are even; poses are those of the page's own predictor.

    Frames cross without a codec. Off by half a level of 255 for the late frame's bytes, half for
    each program's picture, and half for both's half floats: 2 in all, except where a comparison of
    depths stands on the brink and another surface is taken.
    """
    with (
        Serving("--scene", "room", "--web", "127.0.0.1:*", "--out", str(tmp_path / "out")) as server,
        Browser(tmp_path / "profile", (960, 640)) as browser,
    ):
        browser.send("Page.addScriptToEvaluateOnNewDocument", source=CLOCK.replace("1000 / 60", str(REFRESH_MS)))
        wide = (960, 640) if eyes == 1 else (192, 104)
        browser.send(
            "Emulation.setDeviceMetricsOverride", width=wide[0], height=wide[1], deviceScaleFactor=1, mobile=False
        )
        if eyes == 2:
            wear(browser, CANTED)
        asks = f"&raw&trace=walk&warp=iterative&size=96&rate=120&latency={LATENCY_MS}"
        browser.open(server.line("for a browser").split()[-1] + asks)
        browser.until("hmdwarp.session.feed.socket.readyState === 1")
        if eyes == 2:
            enter_vr_at_once(browser)
        browser.does("(async () => { while (!hmdwarp.session.shown) await stepped(1); })()")
        looked = [browser.does(look_after(1)) for _ in range(60)]
        browser.does("hmdwarp.session.report.send(hmdwarp.session.time())")
        browser.does("hmdwarp.session.feed.close()")
        folders = [Path(server.line("a browser's session").split()[-1]) for _ in range(eyes)]  # a window's before
    folder = folders[-1]
    size, rate = tuple(looked[0]["views"][0]["size"]), str(1e3 / REFRESH_MS)
    ahead = LATENCY_MS + 500 / 120  # as the page predicts
    command = [
        *("replay", f"{folder}/trace.csv", "--scene", "room", "--samples", "1"),
        *("--delay-trace", f"{folder}/delays.csv", "--headset", f"{folder}/headset.toml", "--guard", "1.25"),
        *("--rate", rate, "--server-rate", rate, "--size", f"{size[0]}x{size[1]}", "--predict", "cautious"),
        *("--horizon", str(ahead), "--warp", f"iterative:seed=rotation,steps={STEPS}", "--fill", "none"),
        *("--against", "", "--metrics-every", "16", "--images", "1000", "--workers", "0", "--quiet"),
        *("--out", str(tmp_path / "replay")),
    ]
    done = hmdwarp(*command, page=False)
    assert done.returncode == 0, done.stderr
    heads = np.array([np.mean([view["pose"]["position"] for view in look["views"]], axis=0) for look in looked])
    rows = {round(1e3 * float(row["time_s"])): row for row in _refreshes(folder)}
    compared = 0
    for again in (row for row in _rows(tmp_path / "replay") if int(row["eye"]) < eyes):
        row = rows[round(1e3 * float(again["time_s"]))]
        if int(row["drawn_ns"]) - int(rows[0]["shown_ns"]) < 1e6 * KNOWN_MS:
            continue  # the page knew how the head had moved before
        assert row["age_ms"] == again["age_ms"]
        for name in (f"{which}_{axis}_m" for which in ("shown", "drawn") for axis in "xyz"):
            assert abs(float(row[name]) - float(again[name])) < 1e-6  # both interpolate, at times in whole ns
        if again["hole_share"]:  # it is measured, and so kept
            eye, place = int(again["eye"]), [float(row[f"shown_{axis}_m"]) for axis in "xyz"]
            apart = np.abs(heads - place).max(axis=1)
            assert apart.min() < 1e-6  # WebXR has the places of eyes in single precision
            off = pictures_of(looked[apart.argmin()])[eye].astype(int)
            off -= _picture(tmp_path / "replay", int(again["frame"]), eye, size)
            assert np.mean(np.abs(off).max(axis=-1) > 2) <= 0.01 + float(again["hole_share"])
            compared += 1
    assert compared >= 2 * eyes
