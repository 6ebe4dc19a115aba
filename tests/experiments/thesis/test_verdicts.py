"""A verdict follows from the numbers of its settings by the stated rule, and from nothing else."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from report_tables import summary_markdown

from hmdwarp.experiments.thesis.experiment import (
    Finding,
    Motion,
    PictureRun,
    Rule,
    Verdict,
    experiments_named,
    number_of,
    settings_text,
    verdict_of,
)  # fmt: skip
from hmdwarp.experiments.thesis.run_figures import Thoroughness, beyond
from hmdwarp.experiments.thesis.thesis_run import cases_of, figures_by_run, judge

HOLDS = st.sampled_from([True, False, None])


def findings(holds: list[bool | None]) -> list[Finding]:
    return [Finding(f"row {n}", "column", None if one is None else 1.0, one) for n, one in enumerate(holds)]


@given(st.lists(HOLDS))
def test_the_verdict_follows_from_what_was_measured(holds):
    known = [hold for hold in holds if hold is not None]
    mixed = Verdict.CONDITIONS if sum(known) >= len(known) / 2 else Verdict.MOSTLY_FAILS
    expected = {(): Verdict.UNKNOWN, (True,): Verdict.HOLDS, (False,): Verdict.FAILS, (False, True): mixed}[
        tuple(sorted(set(known)))
    ]
    assert verdict_of(findings(holds)) is expected
    assert verdict_of(findings(holds[::-1])) is expected
    assert verdict_of(findings([*holds, None])) is expected


def test_rules_are_said_in_the_unit_of_the_number_and_judge_only_what_was_measured():
    for value in (None, math.nan, math.inf, -math.inf):
        finding = Finding.of("row", "column", value, Rule(high=1.0))
        assert (finding.value, finding.holds) == (None, None)
    assert Rule.of("at most 0.001").words("%", 100) == "at most 0.1 %"
    assert Rule.of("at least 1").words("times", 1) == "at least 1 times"
    assert Rule.of("from 0.5 to 2").words("times", 1) == "from 0.5 to 2 times"


@given(st.lists(st.tuples(st.sampled_from("pqr"), st.sampled_from("xyz"), HOLDS), unique_by=lambda one: one[:2]))
def test_settings_name_each_row_that_is_so_and_no_other(cells):
    found = [Finding(row, column, None, holds) for row, column, holds in cells]
    for holds in (True, False, None):
        text = settings_text(found, holds)
        rows = {row for row, _, one in cells if one is holds}
        assert {row for row in "pqr" if row in text} == rows
        for row in rows:
            some = [column for other, column, one in cells if other == row and one is holds]
            every = [column for other, column, _ in cells if other == row]
            (part,) = [part for part in text.split("; ") if row in part]
            assert ("(" in part) == (some != every)


RUNS = [
    {"a": 2.0, "b": 0.5, "pixels": 100.0},
    {"a": 6.0, "b": 0.2, "pixels": 400.0},
    {"a": 5.0, "b": 0.1, "pixels": 900.0},
]


@pytest.mark.parametrize(
    ("text", "runs", "expected"),
    [
        ("only a", RUNS[:1], 2.0),
        ("only a 4", RUNS[:1], 0.5),
        ("change a", RUNS, 5.0 - 2.0),
        ("ratio a", RUNS, 5.0 / 2.0),
        ("ratio b a", RUNS, 0.1 / 2.0),
        ("ratio a a 5", RUNS, 5.0 / 2.0 / 5),
        ("least_growth a", RUNS, 5.0 / 6.0),
        ("least_step a", RUNS, 5.0 - 6.0),
        ("greatest_step a", RUNS, 6.0 - 2.0),
        ("closed b a", RUNS, 1 - 0.1 / 5.0),
        ("growth_exponent a", RUNS[:2], math.log(3) / math.log(4)),
        ("none", RUNS, None),
        *((f"{name} c", RUNS, None) for name in ("change", "ratio", "least_growth", "least_step", "growth_exponent")),
        ("least_growth a", [{"a": 0.5e-4}, {"a": 0.2}], None),  # a few pixels
        ("closed b a", [{"a": 0.5e-4, "b": 0.0}], None),
        ("ratio a", [{"a": 0.0}, {"a": 1.0}], None),
    ],
)
def test_numbers_are_those_of_the_figures(text, runs, expected):
    assert number_of(text, runs) == (None if expected is None else pytest.approx(expected))


def judged(name: str, *numbers: dict[str, float | None]) -> dict:
    """What an experiment says whose every cell has runs with these figures, first to last."""
    (experiment,) = experiments_named([name])
    figures = {run: one for cell in experiment.cells for run, one in zip(cell.runs, numbers, strict=True)}
    return judge(experiment, figures)


@pytest.mark.parametrize(
    ("name", "holding", "failing"),
    [
        ("size-bandwidth", [{"mbit_s": 10.0}, {"mbit_s": 14.0}], [{"mbit_s": 10.0}, {"mbit_s": 10.0}]),
        ("size-latency", [{"response_ms": 60.0}, {"response_ms": 66.0}], [{"response_ms": 60.0}] * 2),
        ("model-silhouettes", [{"psnr_db": 25.0}, {"psnr_db": 24.0}], [{"psnr_db": 25.0}, {"psnr_db": 24.95}]),
        ("composite-copies", [{"psnr_db": 25.0}, {"psnr_db": 26.0}], [{"psnr_db": 25.0}, {"psnr_db": 24.0}]),
        ("composite-cost", [{"fill_ms": 2.0}, {"fill_ms": 3.0}], [{"fill_ms": 3.0}, {"fill_ms": 2.0}]),
        ("edges-doubled", [{"false_edges": 0.2}], [{"false_edges": 0.02}]),
        ("reflections-missed", [{"psnr_db": 25.0}, {"psnr_db": 25.5}], [{"psnr_db": 25.0}, {"psnr_db": 25.0}]),
        ("irradiance-bandwidth", [{"mbit_s": 10.0}, {"mbit_s": 12.0}], [{"mbit_s": 10.0}, {"mbit_s": 2.0}]),
        ("classes", [{"value": 1.0}], [{"value": 0.75}]),
        ("fig31", [{"gain_db": 9.0}], [{"gain_db": 0.5}]),
        ("mesh-cracks", [{"crack_share": 0.0}], [{"crack_share": 2e-3}]),
        ("imposters", [{"psnr_db": 32.0}], [{"psnr_db": 24.0}]),
        ("fig10-bandwidth", [{"full_size_mbit_s": 14.0}], [{"full_size_mbit_s": 18.4}]),
    ],
)
def test_a_verdict_is_that_of_made_up_figures(name, holding, failing):
    holds, one = judged(name, *holding)["verdict"], judged(name, *failing)
    count = len(one["cells"])
    assert holds.startswith("holds") and one["verdict"].startswith("does not hold")
    assert one["fails_at"].startswith(f"{count} of {count} settings: ")
    assert (one["holds_at"], one["unknown_at"]) == ("", "")
    unknown = judged(name, *({} for _ in failing))
    assert unknown["verdict"].startswith("cannot be told") and unknown["unknown_at"] and not unknown["fails_at"]


def test_one_of_four_is_mostly_no_and_a_weak_stand_in_says_so():
    assert verdict_of(findings([True, False, False, False])) is Verdict.MOSTLY_FAILS
    (times,) = experiments_named(["times"])
    figures = {run: {"warp_ms": 1.0, "client_depth_ms": 1.5} for cell in times.cells for run in cell.runs}
    figures |= {run: each | {"fill_ms": 9.0, "effects_ms": 9.0} for run, each in figures.items()}
    one = judge(times, figures)
    assert (one["verdict"], one["holds_at"]) == ("mostly does not hold", "1 of 4 settings: client depth")
    weak = judge(experiments_named(["edges-doubled"])[0], {})
    run = {"experiments": [one, weak], "size": (8, 8), "machine": {"gl_renderer": ""}, "hmdwarp": ""}
    table = summary_markdown([run])
    assert "| mostly does not hold (1 of 4 settings) |" in table
    assert "Cannot be told: `edges-doubled`, by a weak stand-in." in table


def test_a_time_on_a_gpu_is_what_it_takes_beyond_the_least_picture():
    figures = {"warp_ms": 3.0, "fill_ms": 0.5, "copy_ms": None, "psnr_db": 30.0, "effects_ms": 2.0}
    assert beyond(figures, {"warp_ms": 1.0, "fill_ms": 0.6, "psnr_db": 20.0, "effects_ms": None}) == {
        "warp_ms": 2.0, "fill_ms": None, "copy_ms": None, "psnr_db": 30.0, "effects_ms": 2.0,
    }  # fmt: skip


def test_the_later_the_worse_from_each_latency_to_the_next():
    (falls,) = experiments_named(["quality-latency"])
    runs = [run for cell in falls.cells for run in cell.runs]
    assert judge(falls, {run: {"psnr_db": -run.latency_ms} for run in runs})["ours"] == "-200.00 dB"
    rises = judge(falls, {run: {"psnr_db": max(400.0, run.latency_ms)} for run in runs})
    # It is the same at 200 and 400 ms, and 200 dB more at 600.
    assert (rises["verdict"], rises["ours"]) == ("does not hold", "200.00 dB")


def test_some_settings_of_a_claim_that_was_measured_in_part():
    """A cell one of whose runs is missing has no number; the others are told apart and counted."""
    (classes,) = experiments_named(["classes"])
    one, two, three = (run for cell in classes.cells for run in cell.runs)
    found = judge(classes, {one: {"value": 0.5}, two: {"value": 1.0}})
    assert (found["verdict"], found["ours"]) == ("holds under conditions", "50 to 100 %")
    assert (found["holds_at"], found["fails_at"]) == ("1 of 2 settings: class 2", "1 of 2 settings: class 1")
    assert found["unknown_at"] == "class 3"
    assert [(cell["value"], cell["holds"]) for cell in found["cells"]] == [(0.5, False), (1.0, True), (None, None)]
    (size,) = experiments_named(["size-bandwidth"])
    first, last = size.cells[0].runs
    for alone in (first, last):  # half of a ratio is none
        assert judge(size, {alone: {"mbit_s": 1.0}})["verdict"] == "cannot be told"
    assert three not in figures_by_run([])


def test_times_of_another_machine_are_left_out():
    motion = Motion("sideways", 0.5)
    which = ((200.0, True), (400.0, True), (600.0, False))
    runs = [PictureRun(motion=motion, latency_ms=latency, timed=timed) for latency, timed in which]
    cases = cases_of(runs, set(), Thoroughness((48, 30), 1, 1))
    made_on = ["this", "that", "that"]
    order = [runs.index(case.what.run) for case in cases]
    data = [{"machine": made_on[at], "figures": {"warp_ms": 1.0, "psnr_db": 20.0}} for at in order]
    found = figures_by_run(zip(cases, data, strict=True))
    assert found[runs[0]] == {"warp_ms": 1.0, "psnr_db": 20.0}
    assert found[runs[1]] == {"psnr_db": 20.0}
    assert found[runs[2]] == {"warp_ms": 1.0, "psnr_db": 20.0}  # none of the runs that are timed
