"""A verdict follows from the numbers of its settings by the stated rule, and from nothing else."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.experiments.thesis import Finding, Rule, Verdict, settings_text, verdict_of

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
