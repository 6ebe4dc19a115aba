"""The page and the lines of a live run, from figures that were made up."""

from __future__ import annotations

import copy

import numpy as np

from hmdwarp.metrics import aggregate, metrics
from hmdwarp.report import live_lines, render_live_report, validate_summary

from .samples import a_summary

NAMES = (
    *("age_ms", "pose_age_ms", "period_ms", "busy_ms", "angular_speed_deg_s", "linear_speed_m_s"),
    *("hole_share/0", "hole_share/1"),
)
REFRESH = {"render": (3.0, 4.0), "warp": (2.5,), "fill": (1.0,), "effects": (0.0,), "lens": (1.0,), "total": (7.5,)}


def pair(median, p95=None):
    return {"median": median, "p95": median if p95 is None else p95}


def a_live_summary(**changes) -> dict:
    live = {
        "source": "openxr", "about": {"runtime": "Monado 25.0", "headset": "Simulated HMD"}, "record": "head.csv",
        "seconds": 12.5, "refreshes": 1001, "missed": 9, "waiting": 3, "unseen": 2, "over": 40, "timed": 1001,
        "age_ms": pair(203.4, 211.0), "pose_age_ms": pair(1.25, 1.9), "period_ms": pair(12.5, 13.1), "budget_ms": 12.5,
        "refresh_ms": {name: pair(*ms) for name, ms in REFRESH.items()},
        "changes": [{"time_s": 3.5, "frame": 280, "what": {"latency": [200.0, 250.0]}, "reason": "manual"}],
        "change_count": 1, "notices": {"tracking lost": 12}, "lost": [],
        "sampled_every": 1,
    }  # fmt: skip
    figures = aggregate(
        [{"warp_ms": 1.25, "fill_ms": 0.5, "effects_ms": 0.0, "lens_ms": 0.5, "total_ms": 2.25, "hole_share": 0.0213}]
    )
    return {
        **a_summary(), **figures, "clock": "gpu", "rate_hz": 80.0, "notes": ["A <note>."],
        "miss": {"stale_share": 9 / 1010, "longest_stale": 4, "budget_ms": 12.5},
        "live": {**live, **changes},
    }  # fmt: skip


def a_column(count=300, holes=True):
    rng = np.random.default_rng(1)
    columns = {"time_s": np.arange(count) / 80, **{name: rng.uniform(1, 12, count) for name in NAMES}}
    columns["pose_age_ms"][0] = columns["period_ms"][0] = np.nan
    if not holes:
        columns["hole_share/0"][:] = columns["hole_share/1"][:] = np.nan
    return lambda name: columns[name].copy()


def test_the_lines_say_what_counts():
    validate_summary(a_live_summary())
    told = live_lines(a_live_summary(), None)
    assert told == [
        "Shown:                        1001 pictures in 12.5 s, 80.0 a second",
        "Frame age at display:         203.4 ms, from drawing to showing; p95 211.0 ms",
        "Pose age at frame submission: 1.25 ms, from reading the head to submitting the picture; p95 1.90 ms",
        "Missed refreshes:             0.9 %, at most 4 in a row",
        "Time per eye:                 2.25 ms, all stages; p95 2.25 ms",
        "Holes:                        2.13 %, " + metrics.get("hole_share").tile_note,
        "note:                         A <note>.",
    ]  # fmt: skip


def test_a_display_that_waits_misses_nothing_and_says_what_took_longer():
    summary = a_live_summary()
    summary["live"] |= {"missed": 0, "over": 200, "timed": 200}
    waits = "this display waits for each picture, and 100% took longer than a refresh"
    assert f"Missed refreshes:             –, {waits}" in "\n".join(live_lines(summary, None))
    page = render_live_report(summary, a_column(), command="hmdwarp live")
    assert waits in page and "0.0<" not in page.partition("Missed refreshes")[2][:200]


def test_lines_without_a_measurement_are_left_out():
    nothing = {name: pair(None) for name in ("render", "warp", "fill", "effects", "lens", "total")}
    absent = {"pose_age_ms": pair(None), "period_ms": pair(None), "refresh_ms": nothing}
    summary = a_live_summary(**absent, refreshes=1, missed=0, seconds=0.0)
    told = live_lines({**summary, **aggregate([])}, None)
    assert told[0] == "Shown:                        1 picture in 0.0 s"
    assert [line.partition(":")[0] for line in told] == ["Shown", "Frame age at display", "Missed refreshes", "note"]


def test_the_page_says_it_too_and_escapes():
    def made() -> str:
        return render_live_report(a_live_summary(about={"runtime": "<Monado>"}), a_column(), command="live --out 'a&b'")

    page = made()
    wanted = "&lt;Monado&gt;|a&amp;b|A &lt;note&gt;.|latency 200 → 250|24%|60%|at most 4 in a row"
    for text in (*wanted.split("|"), "tracking lost (12×)"):
        assert text in page, text
    assert page.count("<svg") == 6 and "not measured" not in page and page == made()
    summary = copy.deepcopy({**a_live_summary(record=None, changes=[], notices={}, about={}), **aggregate([])})
    page = render_live_report(summary, a_column(1, holes=False), command="")
    assert "not measured" in page and "recorded to" not in page and "<h2>Changes</h2>" not in page
