"""A client that misses refreshes: when its pictures are seen, and what that costs."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path

import attrs
import pytest
from bench_files import PAIRS, a_bench, a_row
from hypothesis import given
from hypothesis import strategies as st
from replays import run, small

from hmdwarp.errors import InputError
from hmdwarp.run import Misses, RunOptions, miss_figures
from hmdwarp.run.truth import is_measured

PERIOD_MS = 1e3 / 60.0  # of the small replays
QUALITY = ("psnr_db", "ssim", "flip", "flicker")


def cells(folder: Path) -> list[dict[str, str]]:
    with (folder / "misses.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def client(time: object, **options: object) -> Misses:
    return Misses.of({"client_time": str(time), **options})


def poses_and_quality(rows: list[dict]) -> list[dict]:
    return [{key: value for key, value in row.items() if not key.endswith("_ms") or key == "age_ms"} for row in rows]


@pytest.mark.parametrize("show", ["turn", "hold"])
def test_without_a_miss_the_run_is_that_of_a_client_that_is_always_ready(tmp_path, show):
    plain = run(tmp_path / "plain", metrics_every=1)
    timed = run(tmp_path / "timed", metrics_every=1, miss=client(PERIOD_MS, on_miss=show))
    assert poses_and_quality(timed.rows) == poses_and_quality(plain.rows)
    assert timed.summary["quality"] == plain.summary["quality"]
    entry = timed.summary["miss"]
    assert (entry["stale_share"], entry["longest_stale"], entry["judder_deg"]) == (0, 0, 0)


def test_two_and_a_half_budgets_show_each_picture_for_three_refreshes(tmp_path):
    result = run(tmp_path / "out", page=True, miss=client(2.5 * PERIOD_MS, on_miss="hold"))
    rows = cells(tmp_path / "out")
    assert [row["stale"] for row in rows] == (["0", "1", "1"] * len(rows))[: len(rows)]
    page = (tmp_path / "out" / "report.html").read_text().replace("<wbr>", "")
    assert "Missed refreshes" in page and "budget" in page
    entry = result.summary["miss"]
    assert entry["stale_share"] == sum(row["stale"] == "1" for row in rows) / len(rows)
    assert entry["longest_stale"] == 2
    drawn = [row["drawn_ns"] for row in result.rows if row["eye"] == 0]
    assert all(len(set(drawn[k : k + 3])) == 1 for k in range(0, len(drawn), 3))
    # Seen two refreshes after the one it was made for.
    ages = [row["age_ms"] for row in result.rows if row["eye"] == 0]
    assert ages[3] - ages[0] == pytest.approx(2 * PERIOD_MS, abs=1e-5)  # instants are whole ns


def test_turning_a_late_picture_is_better_where_the_head_only_turns(tmp_path):
    found = {
        show: run(tmp_path / show, warp="rotation", metrics_every=1, miss=client(60, on_miss=show)).summary
        for show in ("turn", "hold")
    }
    assert found["turn"]["quality"]["flip"]["mean"] < found["hold"]["quality"]["flip"]["mean"]
    assert found["turn"]["miss"]["judder_deg"] < found["hold"]["miss"]["judder_deg"]
    assert found["turn"]["miss"]["stale_share"] == found["hold"]["miss"]["stale_share"]


def moving(path: Path, m_s: float, deg_s: float) -> str:
    """A head that walks to the right and turns to the left, evenly."""
    rows = [f"{k / 60} {m_s * k / 60} 1.6 0 0 {math.sin(a)} 0 {math.cos(a)}" for k in range(61)
            for a in (math.radians(deg_s * k / 120),)]  # fmt: skip
    path.write_text("# timestamp tx ty tz qx qy qz qw\n" + "\n".join(rows), encoding="utf-8")
    return str(path)


@pytest.mark.parametrize(("show", "m_s", "deg_s", "expected"), [
    ("turn", 0.0, 60.0, 0.0),  # a turned picture is right for a head that turns
    ("hold", 0.0, 60.0, 1.0 * 0.93),  # a degree a refresh, less towards the axis of the turn
    ("turn", 0.6, 0.0, None),  # a centimetre a refresh, at the depth of what is there
    ("hold", 0.6, 0.0, None),
])  # fmt: skip
def test_judder_is_what_the_eye_sees(tmp_path, show, m_s, deg_s, expected):
    """Every second refresh shows the picture before it; none is stale by what is right about it."""
    said = {"trace": moving(tmp_path / "head.txt", m_s, deg_s), "warp": "none", "latency_ms": 0.0}
    found = run(tmp_path / "out", miss=client(1.5 * PERIOD_MS, on_miss=show), scene="planes", **said).summary["miss"]
    if expected is None:
        # Planes are 1 to 10 m away: a centimetre is 0.57 to 0.06 degrees.
        assert 0.05 < found["judder_deg"] < 0.6
    else:
        assert found["judder_deg"] == pytest.approx(expected, abs=0.05)


def test_times_from_a_file_repeat_and_give_the_same_run_twice(tmp_path):
    times = tmp_path / "times.csv"
    times.write_text("time_ms\n5\n40\n")
    runs = [run(tmp_path / name, miss=client(times), metrics_every=1) for name in "ab"]
    assert poses_and_quality(runs[0].rows) == poses_and_quality(runs[1].rows)
    assert (tmp_path / "a" / "misses.csv").read_text() == (tmp_path / "b" / "misses.csv").read_text()
    assert {row["took_ms"] for row in cells(tmp_path / "a")} == {"5.0", "40.0", ""}


def test_measured_times_are_those_of_this_run(tmp_path):
    result = run(tmp_path / "out", miss=client("measured", client_budget=0.0001))
    assert result.summary["miss"]["times"] == "measured"
    assert result.summary["miss"]["stale_share"] > 0  # no pass takes less than 0.1 us


def test_trace_events_tell_the_misses(tmp_path):
    path = tmp_path / "events.json"
    run(tmp_path / "out", miss=client(1.5 * PERIOD_MS), trace_events=path)
    events, rows = json.loads(path.read_text()), cells(tmp_path / "out")
    shown = [event for event in events if event["ph"] == "X" and event["name"].startswith("refresh")]
    assert [event["name"].endswith("missed") for event in shown] == [row["stale"] == "1" for row in rows]
    work = [event for event in events if event["ph"] == "X" and event["name"].startswith("work")]
    assert len(work) == sum(row["stale"] == "0" for row in rows)
    # Written in microseconds, rounded to whole ns.
    assert [event["dur"] for event in work] == pytest.approx([1500 * PERIOD_MS] * len(work), abs=1e-3)
    ends = {event["name"].split()[-1]: event["ts"] + event["dur"] for event in work}
    begins = {event["name"].split()[-1]: event["ts"] for event in shown if not event["name"].endswith("missed")}
    assert ends.keys() == begins.keys()
    later = [name for name in ends if name != "0"]  # the first is there in time, whatever it takes
    assert all(ends[name] <= begins[name] for name in later)


@given(st.lists(st.booleans(), min_size=1), st.floats(0, 90))
def test_the_figures_of_a_head_that_is_always_as_far_off(stale, off):
    figures = miss_figures(stale, [off] * len(stale))
    assert figures["stale_share"] * len(stale) == pytest.approx(stale.count(True))
    assert figures["longest_stale"] <= stale.count(True)
    assert figures["judder_deg"] == 0


@given(st.floats(0, 1e3), st.floats(0.1, 1e3), st.floats(1, 1e3))
def test_a_longer_time_is_seen_no_sooner(took, budget, period):
    misses = Misses((took,), budget)
    assert misses.refreshes(took, period) >= 1
    assert (misses.refreshes(took, period) == 1) or took > budget
    assert misses.refreshes(took + period, period) >= misses.refreshes(took, period)


@pytest.mark.parametrize(
    "wrong",
    [
        {"client_time": "fast"},
        {"client_time": "-1"},
        {"client_time": "nan"},
        {"client_budget": 5.0},
        {"on_miss": "hold"},
        {"compare_governor": True},
        {"client_time": "2", "client_budget": 0.0},
        {"client_time": "2", "on_miss": "none"},
    ],
)
def test_a_wrong_option_names_itself(wrong):
    option = max(wrong, key=list(wrong).index).replace("_", "-")
    with pytest.raises(InputError, match=f"--{option}"):
        Misses.of(wrong)


def test_a_file_of_times_names_its_bad_line(tmp_path):
    times = tmp_path / "times.csv"
    times.write_text("5\nlong\n")
    with pytest.raises(InputError, match=r"times.csv: line 2: 'long': expected one time"):
        client(times)
    with pytest.raises(InputError, match="no such file"):
        client(tmp_path / "none.csv")


@pytest.mark.parametrize("other", [{"fused": True}, {"scanout_ms": 5.0}])
def test_options_that_exclude_it(other):
    with pytest.raises(InputError, match="--client-time with --"):
        small(miss=client(20), **other)


def test_there_is_a_governor_to_run_without(tmp_path):
    both = client(20, compare_governor=True)
    with pytest.raises(InputError, match="compare-governor: expected --warp auto, found --warp forward"):
        run(tmp_path / "out", miss=both)
    with pytest.raises(InputError, match="expected at most 1 warp with --compare-governor"):
        run(tmp_path / "out", miss=both, warp="auto", budget_ms=8.0, against="none,rotation")


@pytest.mark.parametrize("every", [2, 5, 10])
@pytest.mark.parametrize("period", [2, 3, 4, 5])
def test_measured_refreshes_are_in_step_with_no_period(every, period):
    """Of 1200 refreshes every second was stale and none of the measured ones, every tenth."""
    measured = [number for number in range(1200) if is_measured(number, every)]
    assert measured[0] == 0 and len(measured) in (1200 // every, 1200 // every - 1)
    assert [number // every for number in measured] == list(range(len(measured)))
    shares = [sum(number % period == phase for number in measured) / len(measured) for phase in range(period)]
    assert max(abs(share - 1 / period) for share in shares) < 0.05


def test_a_run_measures_as_many_stale_refreshes_as_there_are(tmp_path):
    found = run(tmp_path / "out", miss=client(1.5 * PERIOD_MS), metrics_every=10, seconds=5.0).summary["miss"]
    assert found["stale_share"] == pytest.approx(0.5, abs=0.01)
    assert found["stale_share_measured"] == pytest.approx(0.5, abs=0.1)


def test_a_client_is_in_time_unless_its_time_is_set():
    assert not RunOptions.of({"trace": "walk"}).miss.on
    assert RunOptions.of({"trace": "walk", "client_time": "20"}).miss == Misses((20.0,))


def test_a_governor_reacts_to_the_given_times(tmp_path):
    # The middle one takes three eighths of the best, 0.94 refreshes for both eyes.
    levels = zip(PAIRS, (1.0, 3.0, 8.0), (0.3, 0.2, 0.1), strict=True)
    bench = a_bench(tmp_path / "bench.json", [a_row(*pair, took, flip) for pair, took, flip in levels])
    slow = client(2.5 * PERIOD_MS)
    auto = {"warp": "auto", "bench": bench, "budget_ms": PERIOD_MS / 2, "seconds": 1.5}
    governed = run(tmp_path / "on", miss=slow, **auto)
    changes = governed.summary["auto"]["changes"]
    first = governed.rows[0]
    fixed = run(tmp_path / "off", miss=slow, seconds=1.5, warp=first["warp"], fill=first["fill"])
    assert changes and changes[0]["from"] != changes[0]["to"]
    assert governed.summary["miss"]["stale_share"] < fixed.summary["miss"]["stale_share"]
    beside = run(tmp_path / "both", miss=attrs.evolve(slow, compare_governor=True), **auto)
    assert poses_and_quality(beside.rows) == poses_and_quality(governed.rows)
    (alone,) = beside.against
    assert (alone["warp"], alone["fill"], alone["miss"]) == (first["warp"], first["fill"], fixed.summary["miss"])
    assert alone["quality"] == fixed.summary["quality"] and alone["difference"]["flip"]["mean"] is not None
    assert beside.summary["against"][0]["miss"] == alone["miss"]
    assert any("Without the governor" in note for note in beside.summary["notes"])
    # The last picture by the level before is that of the change.
    before = {row["frame"]: (row["warp"], row["fill"]) for row in governed.rows}
    assert before[changes[0]["frame"]] == (first["warp"], first["fill"])
