"""What a live run writes: the files of a replay, true to what was shown, whatever ends it."""

from __future__ import annotations

import json
import threading

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from replays import contents, rows_of

from hmdwarp.base import MachineError
from hmdwarp.display import Command, Lost, Tick
from hmdwarp.gpu import Canvas, download, upload
from hmdwarp.report import FRAME_COLUMNS, validate_summary
from hmdwarp.run import HoleCounter, LiveLog, LiveOptions
from hmdwarp.run.live_log import Thinned

from .offscreen import PERIOD_NS, READ_NS, SUBMITTED_NS, OffscreenDisplay, closed_at, run_on

SMALL = {
    "scene": "planes", "headset": "rift-dk1", "latency_ms": 30.0, "warp": "forward", "fill": "interpolate",
    "guard": 1.0, "predict": "none",
}  # fmt: skip


@attrs.define
class Seen:
    """What a log was told: refreshes, and of each eye the share of pixels without coverage."""

    logs: list = attrs.field(factory=list)
    refreshes: list = attrs.field(factory=list)
    holes: list = attrs.field(factory=list)


@pytest.fixture
def seen(monkeypatch) -> Seen:
    found, add = Seen(), LiveLog.add

    def adding(self, tick, refresh, submitted_ns, notice):
        found.logs.append(self)
        if refresh is not None:
            found.refreshes.append(refresh)
            warped = [eye.warped for eye in refresh.eyes if eye.warped is not None]
            found.holes.append([float((download(result.texture)[..., 3] == 0).mean()) for result in warped])
        add(self, tick, refresh, submitted_ns, notice)

    monkeypatch.setattr(LiveLog, "add", adding)
    return found


def go(monkeypatch, out, events=None, options=None, page=False, **display):
    """A small run into `out`."""
    shown = OffscreenDisplay(events=closed_at(20) if events is None else events, **display)
    options = LiveOptions(**{**SMALL, "out": out, "command": "hmdwarp live", **(options or {})})
    return run_on(monkeypatch, shown, options, page), shown


def test_rows_are_what_was_shown(monkeypatch, tmp_path, seen):
    result, _ = go(monkeypatch, tmp_path / "out", options={"fill": "none"})
    rows = rows_of(tmp_path / "out")
    assert tuple(rows[0]) == FRAME_COLUMNS
    assert len(rows) == 2 * len(seen.refreshes) == 2 * result.summary["frames"] > 20
    for row, (number, eye) in zip(rows, np.ndindex(len(seen.refreshes), 2), strict=True):
        refresh = seen.refreshes[number]
        assert (row["frame"], row["eye"], row["warp"], row["fill"]) == (str(number), str(eye), "forward", "none")
        assert int(row["shown_ns"]) == refresh.shown_ns and int(row["drawn_ns"]) == refresh.frame.drawn_ns
        assert float(row["time_s"]) == pytest.approx(number * PERIOD_NS * 1e-9, abs=1e-9)
        assert float(row["age_ms"]) == refresh.age_ns * 1e-6
        assert float(row["pose_age_ms"]) == (SUBMITTED_NS - READ_NS) * 1e-6
        for which, head in (("shown", refresh.head), ("drawn", refresh.frame.head)):
            parts = [float(row[f"{which}_{part}"]) for part in ("x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")]
            assert parts == [*head.pose.position_m, *head.pose.orientation_xyzw]  # every bit
        stages = dict(refresh.stage_ms[eye])
        assert float(row["warp_ms"]) == stages["warp"] and float(row["lens_ms"]) == stages["lens"]
        assert float(row["total_ms"]) == pytest.approx(sum(stages.values()))
        # The GPU's count and NumPy's, of the same picture.
        assert float(row["hole_share"]) == seen.holes[number][eye]
        assert row["psnr_db"] == row["flip"] == row["border_share"] == ""
    assert sum(map(sum, seen.holes)) > 0


def test_speeds_are_those_between_two_shown_poses(monkeypatch, tmp_path, seen):
    go(monkeypatch, tmp_path / "out")
    rows = rows_of(tmp_path / "out")[::2]
    assert rows[0]["angular_speed_deg_s"] == rows[0]["linear_speed_m_s"] == ""
    for row, before, now in zip(rows[1:], seen.refreshes, seen.refreshes[1:], strict=False):
        turn = (now.head.pose.rotation * before.head.pose.rotation.inv()).magnitude()
        assert float(row["angular_speed_deg_s"]) == pytest.approx(np.degrees(turn) / (PERIOD_NS * 1e-9), rel=1e-6)
        step = np.linalg.norm(now.head.pose.position_m - before.head.pose.position_m)
        assert float(row["linear_speed_m_s"]) == pytest.approx(step / (PERIOD_NS * 1e-9), rel=1e-6)


def test_the_summary_is_a_replay_s_and_more(monkeypatch, tmp_path, seen):
    result, _ = go(monkeypatch, tmp_path / "out", options={"fill": "none"})
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    validate_summary(summary)
    assert summary == result.summary and result.folder == tmp_path / "out"
    rows = rows_of(tmp_path / "out")
    for stage in ("warp", "fill", "effects", "lens", "total"):
        assert summary["time_ms"][stage]["median"] == np.median([float(row[f"{stage}_ms"]) for row in rows])
    assert summary["quality"]["hole_share"]["mean"] == pytest.approx(np.mean(seen.holes))
    assert summary["quality"]["flip"] == {"mean": None, "p95": None} and summary["measured"]["hole_share"] == len(rows)
    assert (summary["trace"], summary["headset"], summary["lens"]) == ("offscreen", "rift-dk1", "radial")
    assert summary["size"] == [96, 120] and summary["link"]["frames"]["shown"] > 10
    link = summary["link"]
    # A hundred pictures a second came.
    assert link["mbit_s"] == pytest.approx(link["frame_bytes"] * 8 * 100 / 1e6)
    live = summary["live"]
    assert {"display": "offscreen", "trace": "look-around"}.items() <= live["about"].items()
    assert live["budget_ms"] == 10.0
    assert live["pose_age_ms"] == {"median": 2.0, "p95": 2.0} and live["period_ms"]["median"] == 10.0
    both = [float(a["total_ms"]) + float(b["total_ms"]) for a, b in zip(rows[::2], rows[1::2], strict=True)]
    assert live["refresh_ms"]["total"]["median"] > np.median(both) > live["refresh_ms"]["warp"]["median"] > 0


def test_events_are_listed(monkeypatch, tmp_path):
    events = {
        8: Tick(0, 0, render=False), 9: Tick(0, 0, missed=2, notice="tracking lost"), 10: Lost("the runtime is gone"),
        16: Tick(0, 0, missed=1),
        12: None, **closed_at(30),
    }  # fmt: skip
    asked = {14: [Command("latency", 50.0)], 18: [Command("warp", "rotation")], 22: [Command("fill", "no such fill")]}
    result, display = go(monkeypatch, tmp_path / "out", events, asked=asked, back_after=0)
    live = result.summary["live"]
    assert (live["missed"], live["unseen"], live["lost"][0]["why"]) == (3, 1, "the runtime is gone")
    missed = {"stale_share": 3 / (3 + live["refreshes"]), "longest_stale": 2, "budget_ms": 10.0}
    assert result.summary["miss"] == pytest.approx(missed)
    assert live["lost"][0]["away_s"] >= 0 and live["notices"]["tracking lost"] == 1
    assert live["waiting"] == live["notices"]["waiting for the first frame"] > 0
    assert live["refreshes"] + live["waiting"] + live["unseen"] == 30 - 2
    changes = [(change["what"], change["reason"]) for change in live["changes"]]
    assert changes == [({"latency": [30.0, 50.0]}, "manual"), ({"warp": ["forward", "rotation"]}, "manual")]
    warps = [row["warp"] for row in rows_of(tmp_path / "out")[::2]]
    assert warps.index("rotation") == live["changes"][1]["frame"] + 1 and warps[-1] == "rotation"
    ages = {float(row["age_ms"]) for row in rows_of(tmp_path / "out")}
    assert result.summary["latency_ms"] == 30.0 and max(ages) == pytest.approx(50.0)
    told = "\n".join(result.describe())
    for text in ("Missed refreshes:", "at most 2 in a row", "Settings were changed 2 times", "the runtime is gone"):
        assert text in told
    assert display.statuses[-1].missed == 3


def test_a_view_of_one_eye_has_one_row(monkeypatch, tmp_path):
    asked = {10: [Command("view", "both")]}
    result, _ = go(monkeypatch, tmp_path / "out", view="flat", asked=asked, options={"view": "flat"})
    eyes = [int(row["eye"]) for row in rows_of(tmp_path / "out")]
    first = eyes.index(1)
    assert set(eyes[: first - 1]) == {0} and eyes[first - 1 :] == [0, 1] * ((len(eyes) - first + 1) // 2)
    assert result.summary["frames"] == first - 1 + (len(eyes) - first + 1) // 2
    assert result.summary["measured"]["hole_share"] == len(eyes)
    validate_summary(result.summary)


def test_a_fused_warp_has_no_picture_to_count_holes_in(monkeypatch, tmp_path):
    result, _ = go(monkeypatch, tmp_path / "out", options={"fused": True, "warp": "backward", "fill": "none"})
    assert {row["hole_share"] for row in rows_of(tmp_path / "out")} == {""}
    assert result.summary["quality"]["hole_share"]["mean"] is None


def test_without_a_folder_nothing_is_written_and_all_is_told(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    result, display = go(monkeypatch, None)
    validate_summary(result.summary)
    assert result.folder is None and not list(tmp_path.iterdir())
    told = "".join(result.describe())
    assert told.startswith("Shown:") and "Time per eye:" in told and "report" not in told
    status = display.statuses[-1]
    assert len(status.age_ms) == len(status.pose_age_ms) == result.summary["frames"]
    assert len(status.total_ms) == len(status.holes) == len(status.period_ms) + 1 == result.summary["frames"]
    assert set(status.stage_ms) == {"warp", "fill", "effects", "lens"} and status.budget_ms == 10.0


def test_logging_does_not_wait_for_the_gpu(monkeypatch, tmp_path, seen):
    """With timer queries, a refresh's times are asked for after the next one was handed over, and
    the last one's at the end.
    """
    read = []

    def after(number):
        *_, before, now = [None, *seen.refreshes]
        read.append(
            (before is None or not any(lap._pending for lap in before.laps), not all(lap._pending for lap in now.laps))
        )

    display = OffscreenDisplay(events=closed_at(20))
    display.gpu.timer.clock = "gpu"  # llvmpipe has queries too; their answers mean nothing
    run_on(monkeypatch, display, LiveOptions(**SMALL, out=tmp_path / "out"), after=after)
    assert set(read) == {(True, False)} and len(read) > 10
    assert all(row["total_ms"] and row["hole_share"] for row in rows_of(tmp_path / "out"))


def test_a_run_without_a_picture_writes_nothing_and_says_so(monkeypatch, tmp_path):
    result, display = go(monkeypatch, tmp_path / "out", closed_at(1), options={"record": tmp_path / "head.csv"})
    assert result.describe() == ["no picture was shown"] and result.folder is None
    assert "nothing recorded" in display.said[-1] and not list(tmp_path.iterdir())


@pytest.mark.parametrize("error", [MachineError("the GPU is gone"), KeyboardInterrupt()])
def test_any_ending_writes_the_shown_refreshes(monkeypatch, tmp_path, error):
    with pytest.raises(type(error)):
        go(monkeypatch, tmp_path / "out", {15: error}, options={"record": tmp_path / "head.csv"})
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    validate_summary(summary)
    rows = rows_of(tmp_path / "out")
    # The last one's times, too.
    assert len(rows) == 2 * summary["frames"] > 10 and rows[-1]["total_ms"]
    assert (tmp_path / "head.csv").read_text().count("\n") == 6 + summary["frames"]


def test_a_watchdog_s_thread_can_finish_it_while_the_loop_hangs(monkeypatch, tmp_path, seen):
    """No GL there.

    The last refresh's times are not known then. What comes back to life afterwards is not logged.
    """

    def after(number):
        if number == 10:
            other = threading.Thread(target=seen.logs[0].finish)
            other.start()
            other.join()

    display = OffscreenDisplay(events=closed_at(20))
    result = run_on(monkeypatch, display, LiveOptions(**SMALL, out=tmp_path / "out"), after=after)
    rows = rows_of(tmp_path / "out")
    assert len(rows) == 20 and result.summary["frames"] == 10 and result.folder == tmp_path / "out"
    assert rows[-1]["total_ms"] == rows[-1]["hole_share"] == "" and rows[-3]["total_ms"] and rows[-1]["shown_qw"]
    validate_summary(result.summary)


def test_the_page_is_there_and_nothing_hidden(monkeypatch, tmp_path):
    go(monkeypatch, tmp_path / "out", {5: Tick(0, 0, notice="<b>lost</b>"), **closed_at(20)}, page=True)
    page = (tmp_path / "out" / "report.html").read_text().replace("<wbr>", "")
    assert page.count("<svg") == 6 and "<h2>Time per refresh</h2>" in page and "<b>lost" not in page
    assert sorted(contents(tmp_path / "out")) == ["frames.csv", "report.html", "summary.json"]


def test_of_many_notices_a_bounded_part_is_kept(monkeypatch, tmp_path, seen):
    """As of rows, below; that refreshes leave nothing behind has test_no_allocation.py."""

    def after(number):
        refresh, logged = seen.refreshes[-1], seen.logs[0]
        for k in range(100 if number == 5 else 0):
            later = attrs.evolve(refresh, shown_ns=refresh.shown_ns + (k + 1) * PERIOD_NS)
            logged.add(Tick(later.shown_ns, PERIOD_NS), later, later.shown_ns, f"notice {k}")

    result = run_on(monkeypatch, OffscreenDisplay(events=closed_at(12)), LiveOptions(**SMALL), after=after)
    assert 10 < len(result.summary["live"]["notices"]) <= 52


@given(count=st.integers(0, 3000), half=st.integers(1, 40))
def test_kept_rows_are_evenly_spaced(count, half):
    most = 2 * half
    table = Thinned(("number", "square"), most)
    for number in range(count):
        table.add({"number": number, "square": number * number})
    kept = table.column("number")
    assert kept.tolist() == list(range(0, count, table.every))
    assert table.column("square").tolist() == [number * number for number in kept]
    assert len(kept) <= most and (table.every == 1 or len(kept) > half) and (table.every & (table.every - 1)) == 0


@pytest.fixture
def counter(gpu):
    made = HoleCounter(gpu)
    yield made
    made.close()


def picture(gpu, seed: int, size: tuple[int, int], share: float) -> tuple[Canvas, float]:
    """A canvas and the share of it that is holes.

    Alpha that is not 0 is as small as a half can be: it counts as covered.
    """
    w, h = size
    rng = np.random.default_rng(seed)
    image = rng.random((h, w, 4)).astype(np.float16)
    image[..., 3] = np.where(rng.random((h, w)) < share, 0, rng.choice(np.array([6e-8, 0.5, 1], np.float16), (h, w)))
    canvas = Canvas(gpu.gl, size)
    upload(canvas.texture, image)
    return canvas, np.count_nonzero(image[..., 3] == 0) / (w * h)


@pytest.mark.parametrize("size", [(1, 1), (63, 7), (64, 8), (65, 9), (131, 97)])
def test_every_hole_is_counted_once(gpu, counter, size):
    for share in (0, 0.01, 0.5, 1):
        canvas, wanted = picture(gpu, 1, size, share)
        counter.count([canvas])
        counter.count([canvas])
        assert counter.shares() == (wanted,)


def test_it_tells_the_refresh_before_of_each_eye(gpu, counter):
    """Of pictures that change, of eyes of two sizes, of one eye instead of two."""
    rounds = [[picture(gpu, 10 * n + eye, (40 + n, 30 - eye), 0.1 * n) for eye in range(2)] for n in range(5)]
    rounds.append([picture(gpu, 99, (20, 20), 0.3)])
    assert counter.shares() is None
    before = None
    for eyes in rounds:
        counter.count([canvas for canvas, _ in eyes])
        assert counter.shares() == before
        assert counter.shares() == before  # may be asked again
        before = tuple(share for _, share in eyes)


def test_a_count_outlives_its_picture(gpu, counter):
    """A change of the size frees the old pictures at once."""
    old, wanted = picture(gpu, 3, (50, 20), 0.2)
    counter.count([old])
    old.release()
    new, _ = picture(gpu, 4, (20, 50), 0.9)
    counter.count([new])
    assert counter.shares() == (wanted,)
