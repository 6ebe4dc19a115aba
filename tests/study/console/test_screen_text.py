"""The texts of the screen, from any state."""

from __future__ import annotations

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.cells import cell_len

from hmdwarp.study.console.line_console import ConsoleState, Question
from hmdwarp.study.console.screen_text import HINTS, KeyEntry, Scene, end_of, gauge, keys_now, plain, scale_line

from .played import ASKING, GRADE, SHOWING, SICK, STATES


def text_of(state: ConsoleState, **more) -> str:
    """All parts of the screen."""
    return "\n".join(part.plain for part in Scene(state, KeyEntry(), **more).parts().values())


def test_problems_are_shown():
    assert "TRACKING LOST" in text_of(STATES["lost"])
    assert Scene(STATES["lost"], KeyEntry()).parts()["loud"].plain == " PILOT "
    assert "NO NEWS FOR 0:04" in text_of(SHOWING, age_s=4.0)
    assert "NO NEWS" not in text_of(STATES["sick"], age_s=60.0)
    assert "SICKNESS 15 OF 20" in text_of(STATES["sick"])


def test_the_condition_stands_there_only_where_the_state_has_it():
    assert "condition: late-200" in text_of(STATES["open"])
    assert "condition" not in text_of(SHOWING)


def test_a_break_that_ends_by_a_command_shows_no_time_left():
    assert "left of this step" not in text_of(attrs.evolve(STATES["break"], left_s=0.0))
    assert "0:22 left" in text_of(STATES["break"])


def test_a_trial_that_the_participant_ends_shows_both_times():
    assert "0:31 of this step so far, 9:29 left of this step at most" in text_of(
        attrs.evolve(SHOWING, seen_s=31.0, left_s=569.0)
    )


TEXTS = st.text(max_size=120)
NUMBERS = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-400, 400)
QUESTIONS = st.builds(
    Question, TEXTS, st.just(1.0), st.sampled_from([1.0, 2.0, 6.0, 100.0]), st.sampled_from([0.25, 1.0]),
    st.lists(st.tuples(st.floats(0, 100), TEXTS), max_size=8).map(tuple), st.none() | st.floats(-9, 200),
)  # fmt: skip
STATE = st.builds(
    ConsoleState, heading=TEXTS, step=TEXTS, done=NUMBERS, elapsed_s=st.floats(0, 1e6),
    left_s=st.none() | st.floats(-5, 1e5),
    phase=st.sampled_from(["", "reading", "waiting", "showing", "asking", "break", "paused", "over", "new"]),
    rate_hz=st.floats(0, 1e4), missed=st.integers(0, 10**7), notice=TEXTS, condition=TEXTS,
    question=st.none() | QUESTIONS,
    position_m=st.none() | st.tuples(NUMBERS, NUMBERS, NUMBERS),
    angles_deg=st.none() | st.tuples(NUMBERS, NUMBERS, NUMBERS),
)  # fmt: skip


@settings(max_examples=60)
@given(STATE, st.integers(1, 130), st.sampled_from(["keys", "answer", "remark", "help", "stop"]), TEXTS, TEXTS)
def test_no_part_moves_the_cursor(state, width, mode, typed, note):
    """A control character would; a line end would push what is below it down."""
    entry = KeyEntry(mode, "".join(c for c in typed if c.isprintable()), note)
    for part in Scene(state, entry, 0.0, width).parts().values():
        assert part.plain.isprintable()


@pytest.mark.parametrize("phase", [*HINTS, ""])
def test_the_keys_that_do_something_now_fit_into_80_columns(phase):
    asks = phase == "asking"
    shown = keys_now(ConsoleState(phase=phase, question=GRADE if asks else None))
    assert len(shown) <= 80
    assert shown.endswith("?:help")
    assert ("s:stop" in shown) == (phase != "over")
    assert ("g:agree" in shown) == (phase == "reading")
    assert ("a:answer" in shown) == asks


@given(TEXTS, st.integers(1, 130))
def test_a_line_that_is_typed_shows_its_end(typed, width):
    text = "".join(c for c in typed if c.isprintable())
    assert cell_len(end_of(text, width)) <= max(width, 1)
    assert end_of(text, width)[-1:] in (text[-1:], "…")


def test_the_scale_marks_what_is_entered_where_it_is():
    for question, value in ((GRADE, 1.0), (GRADE, 3.5), (GRADE, 6.0), (SICK, 15.0)):
        line = scale_line(attrs.evolve(question, entered=value), 61)
        (marked,) = line.spans
        share = (value - question.least) / (question.most - question.least)
        assert (marked.start, marked.end, marked.style) == (round(share * 60), round(share * 60) + 1, "reverse bold")
    unmarked = scale_line(GRADE, 61)
    assert not unmarked.spans
    assert [unmarked.plain.index(str(n)) for n in range(1, 7)] == [0, 12, 24, 36, 48, 60]


def test_gauges_turn_to_the_side_the_head_turns_to():
    assert gauge(90.0, -180.0, 11).index("█") < 5  # a positive yaw is a turn to the left
    assert gauge(45.0, 90.0, 11).index("█") > 5
    assert gauge(1e9, 90.0, 11)[-1] == "█" and "█" not in gauge(float("nan"), 90.0, 11)


def test_texts():
    assert plain("a\x1b[31mred\x1b[0m\tb\x07\x1b]0;title\x07c") == "ared bc"
    assert end_of("0123456789", 5) == "…6789"


def test_an_answer_so_far_is_shown():
    assert "entered 3.25" in text_of(ASKING) and "nothing entered" in text_of(STATES["next"])
