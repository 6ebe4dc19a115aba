"""The table of the bench.

Fits the terminal without losing a digit, the best first, the front marked; and as Markdown.
"""

import io
import re

import pytest
from rich.console import Console

from hmdwarp.report.bench.rows import COLUMNS, bench_table, cases, common, verdict_text

from .bench_samples import WARPS, a_row, some_rows

SPECS = (*WARPS, "iterative:seed=forward,steps=3", "mesh:cut=slope")


def printed(rows, width=100) -> str:
    console = Console(file=io.StringIO(), width=width)
    console.print(bench_table(rows))
    return console.file.getvalue()


def body(text: str) -> list[str]:
    return [line for line in text.splitlines() if re.search(r"\d\.\d\d", line)]


@pytest.mark.parametrize("width", [60, 80, 100, 140])
def test_fits_and_nothing_is_cut(width):
    rows = some_rows(SPECS, latencies=(200.0, 800.0))
    long = {stage: {"median": 12345.678, "p95": 23456.789} for stage in ("warp", "fill", "lens", "total")}
    rows += [a_row("none", "none", time_ms=long), a_row("[bold]x[/bold]", trace="[red]t.csv")]
    text = printed(rows, width)
    assert max(map(len, text.splitlines())) <= width
    letters = re.sub(r"\s", "", text)
    assert "…" not in text and letters.count("12345.68") == 1 and "t.csv" in letters
    if width > 80:  # names are no markup, and stand in one piece
        assert [name for name in (*SPECS, "[bold]x[/bold]", "[red]t.csv") if name not in text] == []


def test_a_spread_is_that_where_nothing_was_cut():
    near_the_end = {"quality": {"ssim": {"mean": 0.99, "interval": [0.9, 1.0]}}}
    assert COLUMNS["ssim_spread"].value(near_the_end) == pytest.approx(0.09)


def test_each_case_begins_with_its_best_and_marks_its_front():
    rows = some_rows()
    lines = printed(rows, 120).splitlines()
    for case in cases(rows):
        start = next(i for i, line in enumerate(lines) if line.strip() == case.label) + 1
        block = lines[start : start + len(case.rows)]
        flips = [COLUMNS["flip"].text(row) for row in case.ordered()]
        assert flips == sorted(flips)
        assert all(flip in line for flip, line in zip(flips, block, strict=True))
        best = {id(row) for row in case.held()}
        assert [line.startswith("*") for line in block] == [id(row) in best for row in case.ordered()]
        assert 1 < len(best) < len(block)


def test_rows_with_other_conditions_are_another_case():
    rows = [a_row(), a_row("backward"), a_row(size=[640, 400]), a_row(guard=1.0), a_row(scene="planes")]
    groups = cases(rows)
    assert [len(group.rows) for group in groups] == [2, 1, 1, 1]
    assert groups[1].label == "look-around, 200 ms, scene room, 640x400, guard 1.5"
    assert "scene room" not in common(rows) and "rift-dk1" in common(rows)
    assert cases([]) == []


def test_a_lead_within_the_noise_is_not_marked_and_too_few_instants_mark_nothing():
    """Better on the whole, but worse at every other instant: on the front, not held."""
    quick, slow = a_row("rotation"), a_row("layered")
    near = {name: {**entry, "mean": quick["quality"][name]["mean"] - 1e-4} for name, entry in slow["quality"].items()}
    doubtful = {**slow, "quality": near, "at_instants": {"flip": _beside(quick, 0.02)}}
    (case,) = cases([quick, doubtful])
    assert case.front() == [quick, doubtful] and case.held() == [quick]
    (case,) = cases([quick, slow])
    assert case.held() == [quick, slow]
    few = [_of_few_instants(row) for row in (quick, slow)]
    assert cases(few)[0].held() == []
    assert "no *: intervals need 6 instants" in printed(few) and "±" in printed([quick])


def _of_few_instants(row):
    return {**row, "quality": {name: {**entry, "interval": None} for name, entry in row["quality"].items()}}


def _beside(row, by):
    """The row's FLIP at each instant, now that much more and now that much less."""
    return {at: value + by * (-1) ** n for n, (at, value) in enumerate(row["at_instants"]["flip"].items())}


def _with(row, name, mean, at):
    quality = {**row["quality"], name: {**row["quality"][name], "mean": mean}}
    return {**row, "quality": quality, "at_instants": {**row["at_instants"], name: at}}


def test_a_lead_that_holds_wins_one_that_does_not_ties_and_a_metric_that_disagrees_is_named():
    best, other = a_row("layered", "none"), a_row("rotation", "none")
    (case,) = cases([other, best])
    assert (case.verdict()["best"], case.verdict()["disagree"]) == (["layered"], [])
    assert verdict_text(case.verdict()) == "look-around, 200 ms: layered wins by FLIP."
    near = _with(other, "flip", best["quality"]["flip"]["mean"] + 1e-4, _beside(best, 0.02))
    better = {at: value + 2.0 for at, value in best["at_instants"]["psnr_db"].items()}
    (case,) = cases([_with(near, "psnr_db", best["quality"]["psnr_db"]["mean"] + 2, better), best])
    told = case.verdict()
    assert told["best"] == ["layered", "rotation"] and [one["metric"] for one in told["disagree"]][:1] == ["psnr_db"]
    assert told["disagree"][0]["difference"] == pytest.approx(2) and told["disagree"][0]["best"] == "rotation"
    low, high = next(one["interval"] for one in told["paired"] if one["method"] == "rotation")
    assert low <= 0 <= high and len(told["paired"]) == len(case.rows) - 1
    text = verdict_text(told)
    assert "a tie by FLIP: layered and rotation." in text and "But PSNR favours rotation by 2.00 dB (95 %:" in text
    few = [_of_few_instants(row) for row in case.rows]
    assert "no winner: intervals need 6 instants" in verdict_text(cases(few)[0].verdict())
    assert cases([{**row, "lacks": "compute"} for row in case.rows])[0].verdict()["best"] == []
