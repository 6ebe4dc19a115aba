"""A verdict follows from the numbers of its settings by the stated rule, and from nothing else."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.experiments.thesis import Finding, Rule, Verdict, settings_text, verdict_of
from hmdwarp.experiments.thesis.run_kinds import number_of

NUMBERS = st.floats(-1e6, 1e6)
HOLDS = st.sampled_from([True, False, None])


def findings(holds: list[bool | None]) -> list[Finding]:
    return [Finding(f"row {n}", "column", None if one is None else 1.0, one) for n, one in enumerate(holds)]


@given(st.lists(HOLDS))
def test_the_verdict_follows_from_what_was_measured(holds):
    known = [hold for hold in holds if hold is not None]
    expected = {
        (): Verdict.UNKNOWN,
        (True,): Verdict.HOLDS,
        (False,): Verdict.FAILS,
        (False, True): Verdict.CONDITIONS,
    }[tuple(sorted(set(known)))]
    assert verdict_of(findings(holds)) is expected
    assert verdict_of(findings(holds[::-1])) is expected
    assert verdict_of(findings([*holds, None])) is expected


@given(NUMBERS, NUMBERS, NUMBERS)
def test_limits_belong_to_what_they_limit(value, one, other):
    low, high = sorted((one, other))
    assert Rule(high=high).holds(high) and Rule(low=low).holds(low)
    assert Rule(low, high).holds(value) == (Rule(low=low).holds(value) and Rule(high=high).holds(value))
    assert Rule(high=one).holds(value) or Rule(low=one).holds(value)


@pytest.mark.parametrize("value", [None, math.nan, math.inf, -math.inf])
def test_unmeasured_numbers_are_not_judged(value):
    finding = Finding.of("row", "column", value, Rule(high=1.0))
    assert (finding.value, finding.holds) == (None, None)


def test_rules_are_said_in_the_unit_of_the_number():
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


def test_settings_say_once_what_neighbours_share():
    cells = [
        Finding(f"{kind} {speed} {unit}", f"{latency} ms", 1.0, holds)
        for kind, unit, speeds in (("sideways", "m/s", (0.25, 0.5)), ("rotate", "deg/s", (30,)))
        for speed in speeds
        for latency, holds in ((200, True), (400, kind == "rotate"), (600, kind == "rotate"))
    ]
    assert settings_text(cells, True) == "sideways 0.25, 0.5 m/s (200 ms); rotate 30 deg/s"
    assert settings_text(cells, False) == "sideways 0.25, 0.5 m/s (400, 600 ms)"
    assert settings_text(cells, None) == ""


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
