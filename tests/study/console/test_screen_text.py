"""The texts of the screen, from any state."""

from __future__ import annotations

import attrs
from hypothesis import given, settings
from hypothesis import strategies as st
from rich.cells import cell_len

from hmdwarp.study.console import (
    ConsoleState,
    KeyEntry,
    Question,
    Scene,
    end_of,
    gauge,
    journal,
    plain,
    scale_line,
    wrapped,
)

from .played import ASKING, GRADE, SHOWING, SICK, STATES


def text_of(state: ConsoleState, **more) -> str:
    """All parts of the screen."""
    return "\n".join(part.plain for part in Scene(state, KeyEntry(), **more).parts().values())


def test_what_is_wrong_is_said():
    assert "TRACKING LOST" in text_of(STATES["lost"])
    assert Scene(STATES["lost"], KeyEntry()).parts()["loud"].plain == " PILOT "
    assert "NO NEWS FOR 0:04" in text_of(SHOWING, heard_s=4.0)
    assert "NO NEWS" not in text_of(STATES["sick"], heard_s=60.0)
    assert "SICKNESS 15 OF 20" in text_of(STATES["sick"])


def test_the_condition_stands_there_only_where_the_state_has_it():
    assert "condition: late-200" in text_of(STATES["open"])
    assert "condition" not in text_of(SHOWING)


def test_what_happened_is_read_to_its_end():
    line = "Simulator sickness questionnaire (SSQ), question 15 of 16: left unanswered by the participant"
    lines = [("   1:14  ", "before"), ("   1:15  ", line), ("   1:16  ", "after")]
    rows = journal(lines, 80, 10).plain.splitlines()
    first = next(k for k, row in enumerate(rows) if "question 15" in row)
    assert " ".join((rows[first] + rows[first + 1]).split()) == f"1:15 {line}"
    assert rows[first + 1].index("participant") >= rows[first].index("Simulator") and "1:16" in rows[first + 2]
    assert journal(lines, 80, 2).plain.splitlines() == rows[-2:]
    assert journal(lines, 80, 0).plain == ""


def test_nothing_is_left_of_a_break_that_ends_when_somebody_says_so():
    assert "left of this step" not in text_of(attrs.evolve(STATES["break"], left_s=0.0))
    assert "0:22 left" in text_of(STATES["break"])


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
    turned_deg=st.none() | st.tuples(NUMBERS, NUMBERS, NUMBERS),
)  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(
    STATE, st.lists(TEXTS, max_size=30), st.integers(1, 130), st.booleans(),
    st.sampled_from(["keys", "answer", "remark", "help", "stop"]), TEXTS, TEXTS,
)  # fmt: skip
def test_whatever_is_in_it_no_part_moves_the_cursor_or_pushes_what_is_below(
    state, lines, width, roomy, mode, typed, note
):
    """Each part has at most the rows that the layout has for it; a control character would move the
    cursor.
    """
    entry = KeyEntry(mode, "".join(c for c in typed if c.isprintable()), note)
    parts = Scene(state, entry, 0.0, width, roomy).parts()
    parts["journal"] = journal([("   0:01  ", plain(line)) for line in lines], width, 7)
    rows = {name: part.plain.split("\n") for name, part in parts.items()}
    assert all(row.isprintable() for part in rows.values() for row in part)
    most = {"journal": 7, "note": 2, "keys": 2}
    assert all(len(part) <= most.get(name, 1) for name, part in rows.items() if name not in ("question", "anchors"))
    assert len(rows["question"]) + len(rows["anchors"]) <= (4 if roomy else 3)
    assert all(cell_len(row) <= width for row in rows["journal"]) or width < 12


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
    assert wrapped("one two three four", 9, 2) == ["one two", "three fo…"]
    assert end_of("0123456789", 5) == "…6789"


def test_an_answer_so_far_is_said():
    assert "entered 3.25" in text_of(ASKING) and "nothing entered" in text_of(STATES["next"])
