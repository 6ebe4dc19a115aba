"""What pages and tables say of made-up figures is what they said: words/NAME.txt.

HMDWARP_GOLDEN=write writes it anew. How a page looks and what it loads: test_page.py.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from pathlib import Path

import pytest
from golden_texts import assert_text, words_of
from rich.console import Console

from hmdwarp.metrics import REGIONS, aggregate
from hmdwarp.report import live_lines, render_live_report, summary_table
from hmdwarp.report.bench.page import bench_page
from hmdwarp.report.bench.rows import bench_table

from .bench_samples import a_bench, a_row, some_rows
from .samples import a_baseline, a_column, a_live_summary, a_summary
from .samples import some_rows as frames
from .test_page import render

WORDS = Path(__file__).with_name("words")
NOTHING = {**a_summary(), **aggregate([])}
UNMEASURED = {name: {"share": None, "psnr_db": None, "flip": None} for name in REGIONS}
BARE = {"baselines": [], "baselines_rows": [], "worst": [], "notes": []}
ONE_ROW = [{"frame": 0, "eye": 0, "time_s": 0.0, "angular_speed_deg_s": 1.0, "linear_speed_m_s": 0.0}]
PLAIN_LINK = {"codec": "none", "mbit_s": 100.0, "frames": {"drawn": 10, "sent": 10, "shown": 8, "under_way": 2}}
NO_MEASUREMENT = {**NOTHING, "regions": UNMEASURED, "filled": {}, "link": PLAIN_LINK}
MODEL = {"share": 0.2, "texture": 0.25, "triangles": 15064, "geometry_bytes": 912_345, "texture_bytes": 1_234_567}
CROSSED = {"start_up_bytes": 20_000, "first_picture_bytes": 64_400, "arrived_bytes": 9_000_000}
MODELS = [{**MODEL, "share": 1.0, "texture": 1.0}, MODEL | CROSSED, MODEL | CROSSED | {"first_picture_bytes": None}]
AXES = "ros (world=-y,z,x head=-y,z,x), assumed; the motion agrees"


def printed(table: object, width: int = 80) -> str:
    console = Console(file=io.StringIO(), width=width)
    console.print(table)
    return console.file.getvalue()


def tables() -> Iterator[str]:
    """A run alone, beside others, by few instants, and without any measurement."""
    good, bad, worst = frames(0), frames(0, worse=3), frames(0, worse=5)
    few, fewer = (frames(0, seconds=5 / 9, worse=worse) for worse in (1, 3))
    at_an_end = [{"frame": at, "eye": 0, "flip": 0.3 * (at == 5), "ssim": 1 - 0.3 * (at == 5)} for at in range(6)]
    ends = {name: aggregate(at_an_end)["quality"][name] for name in ("flip", "ssim")}
    for summaries in (
        [a_summary(good)],
        [a_summary(good), a_baseline(good, bad)],
        [a_summary(good), a_baseline(good, bad), a_baseline(good, worst, "forward")],
        [a_summary(few), a_baseline(few, fewer)],
        [NOTHING, a_summary()],
        [a_summary(), {**a_summary(), "fill": "none"}],
        [a_summary(), a_summary()],
        [{**a_summary(), "quality": {**a_summary()["quality"], **ends}}],
    ):
        yield printed(summary_table(*summaries))


def live(**changes: object) -> str:
    """The page of a live run and its lines."""
    more = {key: changes.pop(key) for key in ("quality", "time_ms") if key in changes}
    summary = {**a_live_summary(**changes), **more}
    page = render_live_report(summary, a_column(holes="quality" not in more), command="live --out 'a&b'")
    return "\n".join([*live_lines(summary, None), words_of(page)])


def bench_pages() -> str:
    pages = [{"rows": []}, {"rows": [a_row(**aggregate([]), regions={})]}]
    rows = [a_row("mesh", notes=["odd", "rare"]), *(a_row(warp, notes=["odd"]) for warp in ("none", "forward"))]
    pages.append(a_bench(rows=rows, notes=["The trace is <short>."]))
    pages.append(a_bench(rows=some_rows(("none", "forward"), latencies=(200.0, 800.0))))
    return "\n\n".join(words_of(bench_page(page).html()) for page in pages)


def bench_tables() -> str:
    jod = {"mean": 8.254, "truth_preferred": 0.88}
    tables = [
        [], some_rows(), some_rows(traces=("walk",), latencies=(400.0,)),
        [a_row("mesh"), a_row("mesh:grid=64", baseline="CloudXR.js", jod=jod)],
        [a_row("rotation", **aggregate([]), regions={}), a_row()],
        [a_row(), a_row("backward"), a_row(size=[640, 400]), a_row(guard=1.0), a_row(scene="planes")],
    ]  # fmt: skip
    return "\n".join(printed(bench_table(rows), 140) for rows in tables)


NO_TIMES = {name: {"median": None, "p95": None} for name in ("render", "warp", "fill", "effects", "lens", "total")}
SAID = {
    "replay": lambda: words_of(render(summary={**a_summary(), "trace_axes": AXES, "client_models": MODELS})),
    "replay bare": lambda: words_of(render(**BARE, rows=ONE_ROW, summary=NO_MEASUREMENT)),
    "terminal": lambda: "\n".join(tables()),
    "live": lambda: live(about={"runtime": "<Monado>"}),
    "live waits": lambda: live(missed=0, over=200, timed=200, lost=[{"away_s": 0.5}, {"away_s": None}]),
    "live bare": lambda: live(
        pose_age_ms={"median": None, "p95": None}, period_ms={"median": None, "p95": None}, refresh_ms=NO_TIMES,
        refreshes=1, missed=0, seconds=0.0, record=None, changes=[], notices={}, about={}, **aggregate([]),
    ),
    "bench": bench_pages,
    "bench tables": bench_tables,
}  # fmt: skip


@pytest.mark.parametrize("name", SAID)
def test_figures_are_told_as_before(name):
    assert_text(SAID[name](), WORDS / f"{name.replace(' ', '-')}.txt")
