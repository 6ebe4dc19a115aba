"""What a page reports: bounded lines of session.jsonl, which a replay reads as a trace."""

from __future__ import annotations

import csv
import errno
import json
import math
import os
from contextlib import closing
from pathlib import Path

import needs
import numpy as np
import pytest
from commands import hmdwarp
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from serving import Serving

from hmdwarp.base import InputError
from hmdwarp.geometry import Fov
from hmdwarp.headsets import Headset, HeadsetEye, headset_toml
from hmdwarp.poses import TraceOptions, load_trace
from hmdwarp.run import ServeOptions, browser_log
from hmdwarp.run.browser_log import DISPLAY, FULL, MOST_REFRESHES, NAME, SessionLog
from hmdwarp.web import MOST_REPORT, STEPS

from .browser import CANTED, Browser, wear
from .looks import CLOCK, enter_vr_at_once, look_after, pictures_of, view_of

SHOWN = dict.fromkeys(DISPLAY, 100) | {"browser": "a browser", "renderer": "a GPU", "codec": "av1", "trace": "walk"}
KNOWN_MS = 120  # of a head's motion, that the predictor knows
REFRESH_MS, LATENCY_MS = 16, 100  # whole in ns; between two refreshes, so that no rounding of theirs matters


def refresh(shown_ms: float, age_ms: float = 100.0, x_m: float = 0.0) -> list[float]:
    return [shown_ms, age_ms, 2.0, x_m, 1.6, 0.0, 0.0, 0.0, 0.0, 1.0]


def message(rows: list[list[float]] | None = None, **changed) -> str:
    """What a page says of a second: a head that walks along x; each frame is shown twice."""
    rows = [refresh(1000 + 11 * k, 100 + k, 0.01 * k) for k in range(6)] if rows is None else rows
    said = {"display": SHOWN, "warp": "iterative", "missed": 1, "delays_ms": [row[1] for row in rows[::2]]}
    return json.dumps({**said, "refreshes": rows, **changed})


class Logged(SessionLog):
    """A server's file, and what its log was told."""

    def __init__(self, folder: Path) -> None:
        self.said: list[str] = []
        super().__init__(folder, self.said.append)

    def lines(self) -> list[dict]:
        """Whole lines of JSON alone, in a file within its bound."""
        data = self.path.read_bytes() if self.path.exists() else b""
        assert len(data) <= browser_log.MOST_BYTES and (not data or data.endswith(b"\n"))
        return [json.loads(line) for line in data.splitlines()]


@pytest.fixture
def logged(tmp_path):
    with closing(Logged(tmp_path / "out")) as made:
        yield made


def test_a_second_is_a_line(logged):
    page = logged.begin()
    page.take(message())
    page.take(message([refresh(2000)], display=None))
    first, second = logged.lines()
    assert first["display"] == SHOWN and first["session"] == second["session"] and "display" not in second
    assert (first["refreshes"], first["missed"], first["errors"], first["warp"]) == (6, 1, 0, "iterative")
    assert (first["age_ms"], first["warp_ms"], first["delays_ms"]) == ([102.5, 105], [2, 2], [100, 102, 104])
    assert first["heads"][1] == [1011, 0.01, 1.6, 0, 0, 0, 0, 1]
    assert logged.said == []


def test_another_display_another_page_and_another_server_are_other_sessions(tmp_path):
    """In one file, which is not there without a line."""
    Logged(tmp_path).close()
    assert not (tmp_path / NAME).exists()
    for _ in range(2):
        with closing(Logged(tmp_path)) as logged:
            pages = [logged.begin() for _ in range(2)]
            for page in pages * 2:
                page.take(message())
    pages[0].take(message())  # a page that ends after its server
    names = [line["session"] for line in logged.lines()]
    assert len(names) == 8 and len({*names}) >= 4  # two servers may begin within a second


def test_a_session_is_a_trace_and_its_delays(logged, tmp_path):
    page, other = logged.begin(), logged.begin()
    page.take(message())
    other.take(message([refresh(5 + k, 50) for k in range(3)]))
    page.take(message([refresh(2000 + 11 * k, 90, 1 + k) for k in range(3)], display=None))
    names = list(dict.fromkeys(line["session"] for line in logged.lines()))
    mine = load_trace(logged.path, TraceOptions(device=names[0]))
    assert mine.format == "browser" and len(mine.track) == 9 and len(mine.track.position_m) == 9
    np.testing.assert_allclose(mine.track.position_m[-1], [3, 1.6, 0])
    assert len(load_trace(logged.path, TraceOptions(device=names[1])).track) == 3
    assert any("--device" in note for note in load_trace(logged.path).notes)
    alone = only(logged.path, names[0], tmp_path / "one.jsonl")
    assert delays_in(alone) == [100, 102, 104, 90, 90]
    assert len(load_trace(alone).track) == 9


def delays_in(path: Path) -> list[float]:
    """Return those of all lines, as jq does in docs/web.md."""
    lines = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return [delay for line in lines for delay in line.get("delays_ms", ())]


def only(path: Path, session: str, alone: Path) -> Path:
    """Keep the lines of a session, as grep does."""
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    alone.write_text("".join(line for line in lines if f'"{session}"' in line), encoding="utf-8")
    return alone


BENCH = {"warp": "iterative", "fill": "none", "warp_ms": 2.5, "total_ms": 3.5, "psnr_db": 30}
BENCHED = {"display": SHOWN | {"clock": "gpu", "how": "a timer", "seconds": 2}, "bench": [BENCH] * 6}


def test_a_bench_is_a_line_of_no_session(logged):
    page = logged.begin()
    page.take(message())
    page.take(json.dumps(BENCHED))
    assert logged.lines()[1] == BENCHED
    assert len(delays_in(logged.path)) == 3 and len(load_trace(logged.path).track) == 6


WRONG = {
    "no JSON": "{", "deep JSON": "[" * MOST_REPORT, "long": json.dumps("x" * MOST_REPORT),
    "thousands of digits": "1" * 5000, "a list": "[]", "other keys": message(more=1),
    "refreshes of no display": message(display=None), "another display": message(display=SHOWN | {"more": 1}),
    "a display of lists": message(display=dict.fromkeys(DISPLAY, [])),
    "letters of a terminal": message(display=SHOWN | {"browser": "\x1b[2J"}),
    "half a letter": message(display=SHOWN | {"browser": "\ud800"}), "a long name": message(warp="x" * 301),
    "no refresh": message([]), "many refreshes": message([refresh(1 + k) for k in range(MOST_REFRESHES + 1)]),
    "many delays": message(delays_ms=[1] * 7), "a delay that is none": message(delays_ms=[True]),
    "half a refresh": message([refresh(1)[:-1]]), "a refresh of words": message([["1"] * 10]),
    "NaN": message([refresh(1, math.nan)]), "a number that is huge": message(missed=10**400),
    "negative": message([refresh(1, -1)]), "far": message([refresh(1, x_m=1e7)]),
    "no unit quaternion": message([[*refresh(1)[:-1], 0.5]]), "back in time": message([refresh(2), refresh(2)]),
    "a bench of nothing": json.dumps({"bench": {}}), "a bench of no display": json.dumps({"bench": [BENCH]}),
    "a bench of many rows": json.dumps(BENCHED | {"bench": [BENCH] * 17}),
    "a bench of words": json.dumps(BENCHED | {"bench": [BENCH | {"warp_ms": [1]}]}),
}  # fmt: skip


@pytest.mark.parametrize("wrong", WRONG)
def test_what_no_page_says_is_counted_in_the_next_line(logged, wrong):
    page = logged.begin()
    page.take(WRONG[wrong])
    page.take(message())
    page.take(WRONG[wrong])
    page.close()
    line, end = logged.lines()
    assert line["errors"] == 1 and end == {"session": line["session"], "errors": 1}
    page.close()
    assert len(logged.lines()) == 2 and logged.said == []


SECONDS = st.lists(
    st.tuples(st.floats(1e-3, 1e3), st.floats(0, 6e4), st.floats(-1e6, 1e6)), min_size=1, max_size=MOST_REFRESHES
)


@given(st.lists(SECONDS, min_size=1, max_size=4))
def test_what_a_page_says_is_read_again(tmp_path_factory, seconds):
    with closing(Logged(tmp_path_factory.mktemp("out"))) as logged:
        page, now_ms, heads, delays = logged.begin(), 0.0, [], []
        for number, second in enumerate(seconds):
            rows = []
            for step_ms, age_ms, x_m in second:
                now_ms += step_ms
                rows.append(refresh(now_ms, age_ms, x_m))
            heads += [[row[0], *row[3:]] for row in rows]
            delays += [row[1] for row in rows[::2]]
            page.take(message(rows, **({"display": None} if number else {})))
        lines = logged.lines()
        assert [head for line in lines for head in line["heads"]] == heads
        assert delays_in(logged.path) == delays
        assert {line["errors"] for line in lines} == {0}


def test_more_than_two_messages_a_second_are_errors(logged, monkeypatch):
    now_s = [100.0]
    monkeypatch.setattr(browser_log.time, "monotonic", lambda: now_s[0])
    page = logged.begin()
    for number in range(50):
        page.take(message([refresh(number + 1)], display=None if number else SHOWN))
    assert len(logged.lines()) == 8
    now_s[0] += 1
    for number in range(50):
        page.take(message([refresh(number + 100)], display=None))
    lines = logged.lines()
    assert len(lines) == 10 and [line["errors"] for line in lines[8:]] == [42, 0]


@given(st.integers(0, 4000), st.integers(1, 12))
def test_the_file_is_bounded_and_says_so_once(tmp_path_factory, most, pages):
    with pytest.MonkeyPatch.context() as patched, closing(Logged(tmp_path_factory.mktemp("out"))) as logged:
        patched.setattr(browser_log, "MOST_BYTES", most)
        for _ in range(pages):
            page = logged.begin()
            for _ in range(4):
                page.take(message())
            page.close()
        lines = logged.lines()
        is_full = len(lines) < 4 * pages or "full" in lines[-1]
        assert logged.said == ([f"{logged.path}: {FULL}"] if is_full else [])
        assert [line for line in lines if "full" in line] == ([{"full": FULL}] if is_full and most >= 100 else [])
        assert not is_full or most < 100 or lines[-1] == {"full": FULL}


@given(st.integers(0, 3000))
def test_a_full_disk_leaves_whole_lines_and_ends_nothing(tmp_path_factory, room):
    write = os.write
    with pytest.MonkeyPatch.context() as patched, closing(Logged(tmp_path_factory.mktemp("out"))) as logged:

        def fills(file: int, data: bytes) -> int:
            if (left := room - os.fstat(file).st_size) <= 0:
                raise OSError(errno.ENOSPC, "No space left on device")
            return write(file, data[:left])

        patched.setattr(browser_log.os, "write", fills)
        page = logged.begin()
        for _ in range(8):
            page.take(message())
        assert all("heads" in line for line in logged.lines())
        assert len(logged.said) == (len(logged.lines()) < 8)
        assert all("No space left" in line for line in logged.said)


def test_a_folder_that_is_none_is_refused_before_the_server_begins(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match="cannot write"):
        SessionLog(tmp_path / "file", print)
    with pytest.raises(InputError, match="--web"):  # reports come by the door
        ServeOptions(out="out")


@needs.programs("chromium")
@needs.from_npm("iwer")
def test_a_replay_shows_what_the_page_showed(tmp_path):
    """In an emulated headset whose eyes are canted and unequal.

    Its guard band is of whole pixels on each side, which a replay would round up to. The clock is
    stepped, so frames are even; poses are those of the page's own predictor. Frames cross without a
    codec. Off by half a level of 255 for the late frame's bytes, half for each program's picture,
    and half for both's half floats: 2 in all, except where a comparison of depths stands on the
    brink and another surface is taken.
    """
    with (
        Serving("--scene", "room", "--web", "127.0.0.1:*", "--out", str(tmp_path / "out")) as server,
        Browser((192, 104)) as browser,
    ):
        browser.send("Page.addScriptToEvaluateOnNewDocument", source=CLOCK.replace("1000 / 60", str(REFRESH_MS)))
        wear(browser, CANTED)
        asks = f"&raw&trace=walk&warp=iterative&size=96&rate=120&latency={LATENCY_MS}"
        browser.open(server.line("for a browser").split()[-1] + asks)
        browser.until("hmdwarp.session.feed.socket.readyState === 1")
        enter_vr_at_once(browser)
        browser.does("(async () => { while (!hmdwarp.session.shown) await stepped(1); })()")
        looked = [look_after(browser, 1) for _ in range(60)]
        left, right = (np.tan(view["fov"]) for view in looked[0]["views"])
        assert np.allclose(right, [*(left[:2] + left[1] / 12) / 1.15, *(left[2:] + left[3] / 13)], atol=1e-6)
        browser.does("hmdwarp.session.report.send(hmdwarp.session.time())")
        browser.does("hmdwarp.session.feed.close()")
        browser.until("hmdwarp.session.feed.socket.readyState === 3")
    # The last session: a headset's window has one before it.
    lines = [json.loads(line) for line in (tmp_path / "out" / NAME).read_text(encoding="utf-8").splitlines()]
    assert not any(line["errors"] for line in lines)
    alone = only(tmp_path / "out" / NAME, lines[-1]["session"], tmp_path / "one.jsonl")
    views = [HeadsetEye(view_of(view).head_from_eye, Fov(*view["fov"])) for view in looked[0]["views"]]
    size, rate = tuple(looked[0]["views"][0]["size"]), str(1e3 / REFRESH_MS)
    ahead = LATENCY_MS + 500 / 120  # as the page predicts
    shown = Headset("browser", "a page", "a page", size, 1e3 / REFRESH_MS, (views[0], views[1]))
    (tmp_path / "headset.toml").write_text(headset_toml(shown), encoding="utf-8")
    (tmp_path / "delays.csv").write_text("\n".join(map(str, delays_in(alone))), encoding="utf-8")
    command = [
        *("replay", str(alone), "--scene", "room", "--samples", "1", "--delay-trace", str(tmp_path / "delays.csv")),
        *("--headset", str(tmp_path / "headset.toml"), "--guard", "1.25"),
        *("--rate", rate, "--server-rate", rate, "--size", f"{size[0]}x{size[1]}", "--predict", "cautious"),
        *("--horizon", str(ahead), "--warp", f"iterative:frames=1,seed=rotation,steps={STEPS}", "--fill", "none"),
        *("--against", "", "--metrics-every", "16", "--images", "1000", "--workers", "0", "--quiet"),
        *("--out", str(tmp_path / "replay")),
    ]
    done = hmdwarp(*command, page=False)
    assert done.returncode == 0, done.stderr
    seen = np.array([np.mean([view["pose"]["position"] for view in look["views"]], axis=0) for look in looked])
    heads = [head for line in lines if line["session"] == lines[-1]["session"] for head in line["heads"]]
    places = {round(head[0] - heads[0][0]): head[1:4] for head in heads}
    compared, rows = 0, list(csv.DictReader((tmp_path / "replay" / "frames.csv").read_text().splitlines()))
    for again in rows:
        at_ms, age_ms = round(1e3 * float(again["time_s"])), float(again["age_ms"])
        if at_ms - age_ms < KNOWN_MS:
            continue  # the page knew how the head had moved before
        place = np.array(places[at_ms])
        # Both interpolate, at times in whole ns; the page rounds to a micrometre.
        assert np.abs(place - [float(again[f"shown_{axis}_m"]) for axis in "xyz"]).max() < 2e-6
        if again["hole_share"]:  # it is measured, and so kept
            apart = np.abs(seen - place).max(axis=1)
            assert apart.min() < 2e-6  # WebXR has the places of eyes in single precision
            look, eye = looked[apart.argmin()], int(again["eye"])
            assert abs(look["age"] - age_ms) < 1e-3
            name = f"frame-{int(again['frame']):06d}-{('left', 'right')[eye]}.png"
            # Of truth, late frame, warped and error side by side, below their labels.
            strip = np.asarray(Image.open(tmp_path / "replay" / "images" / name).convert("RGB"))
            at = 2 * (size[0] + (strip.shape[1] - 4 * size[0]) // 3)
            off = pictures_of(look)[eye].astype(int) - strip[-size[1] :, at : at + size[0]]
            assert np.mean(np.abs(off).max(axis=-1) > 2) <= 0.01 + float(again["hole_share"])
            compared += 1
    assert compared >= 4
