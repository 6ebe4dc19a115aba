"""What is typed, checked."""

from __future__ import annotations

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.study.line_console import checked_answer, clock, parse_line

from .played import ASKING, GRADE, SHOWING, SICK, STATES


@given(st.integers(0, 20))
def test_every_step_of_the_scale_is_taken_with_point_and_comma(step):
    value = 1.0 + step * 0.25
    assert checked_answer(f"{value}", GRADE) == checked_answer(f" {value} ".replace(".", ","), GRADE) == value


def test_a_step_that_is_no_binary_fraction_is_met():
    tenths = attrs.evolve(GRADE, least=0.0, most=1.0, step=0.1)
    assert [checked_answer(f"0.{k}", tenths) for k in range(10)] == [round(k / 10, 9) for k in range(10)]


@pytest.mark.parametrize(
    ("text", "words"),
    [("", "nothing was typed"), ("good", "no number"), ("7", "not on the scale"), ("0.75", "not on the scale"),
     ("nan", "not on the scale"),
     ("inf", "not on the scale"), ("3.3", "between two steps"), ("3.25.1", "no number")],
)  # fmt: skip
def test_a_wrong_answer_is_refused_with_what_is_wanted(text, words):
    with pytest.raises(ValueError, match=words) as caught:
        checked_answer(text, GRADE)
    assert "1 to 6 in steps of 0.25" in str(caught.value)


def test_times():
    assert [clock(s) for s in (-1, 0, 59.99, 65, 3600, 3723.5)] == [
        "0:00", "0:00", "0:59", "1:05", "1:00:00", "1:02:03",
    ]  # fmt: skip


def test_lines_as_commands():
    assert parse_line(" answer 3,25 ", ASKING) == ("answer", 3.25)
    assert parse_line("Pause", SHOWING) == ("pause", None)
    assert parse_line("decline", STATES["reading"]) == ("decline", None)
    assert parse_line("remark the strap slipped", SHOWING) == ("remark", "the strap slipped")
    assert parse_line("   ", SHOWING) is None
    for line, state, words in [
        ("answer 3", SHOWING, "nothing is being asked"), ("agree", SHOWING, "no text to agree"),
        ("pause now", SHOWING, "takes no value"),
        ("remark", SHOWING, "needs words"), ("dance", SHOWING, "no command"), ("continue", SHOWING, "going on already"),
        ("pause", STATES["paused"], "paused already"), ("break", STATES["break"], "a break already"),
        ("stop", STATES["sick"], "is over"),
    ]:  # fmt: skip
        with pytest.raises(ValueError, match=words):
            parse_line(line, state)


def test_the_sickness_scale_takes_whole_numbers_only():
    assert checked_answer("15", SICK) == 15.0
    with pytest.raises(ValueError, match="between two steps"):
        checked_answer("15.5", SICK)
