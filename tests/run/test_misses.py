"""A client that misses refreshes: when its pictures are seen, and what that costs."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import attrs
import pytest
from bench_files import PAIRS, a_bench, a_row
from hypothesis import given
from hypothesis import strategies as st
from replays import run, small

from hmdwarp.errors import InputError
from hmdwarp.run import Misses, RunOptions, miss_figures

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
    assert found["turn"]["miss"]["judder_deg"] == 0 < found["hold"]["miss"]["judder_deg"]
    assert found["turn"]["miss"]["stale_share"] == found["hold"]["miss"]["stale_share"]


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
    with pytest.raises(InputError, match="cannot be read"):
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


def test_quality_of_stale_refreshes_alone_is_told(tmp_path):
    period_two = client(1.5 * PERIOD_MS)
    unlucky = run(tmp_path / "out", miss=period_two, metrics_every=2).summary
    assert unlucky["miss"]["stale_share_measured"] == 0 < unlucky["miss"]["stale_share"]
    assert any("0.0 % of the measured ones" in note for note in unlucky["notes"])
    lucky = run(tmp_path / "all", miss=period_two, metrics_every=1).summary
    assert lucky["miss"]["stale_share_measured"] == lucky["miss"]["stale_share"]
    assert not any("of the measured ones" in note for note in lucky["notes"])


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
