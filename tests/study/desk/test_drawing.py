"""The screen as rows of text: every state in every size."""

from __future__ import annotations

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

pytest.importorskip(
    "prompt_toolkit", reason="the experimenter's screen needs prompt_toolkit: pip install 'hmdwarp[study]'"
)

from prompt_toolkit.utils import get_cwidth

from hmdwarp.study.desk import DeskState, Question
from hmdwarp.study.desk.cells import ASCII, end_of, plain, wrapped
from hmdwarp.study.desk.drawing import HELP, Scene, page
from hmdwarp.study.desk.entry import Entry
from hmdwarp.study.desk.gauges import gauge, scale
from hmdwarp.study.desk.styles import style

from .played import ASKING, GRADE, SHOWING, SICK, STATES

SIZES = [(80, 24), (120, 40), (60, 20), (100, 21)]


def text_of(scene: Scene, size: tuple[int, int]) -> str:
    return "\n".join(
        "".join(text for style, text in row if style != "[SetCursorPosition]") for row in page(scene, *size)
    )


def styles_of(scene: Scene, words: str) -> set[str]:
    return {style for row in page(scene, 80, 24) for style, text in row if words in text}


@pytest.mark.parametrize("size", SIZES)
def test_what_is_looked_for_is_there_in_every_size(size):
    text = text_of(Scene(SHOWING, Entry(), ["line one", "line two"]), size)
    for words in ("participant P07", "trial 3 of 12", "25 %", "12:04", "0:14 left", "SHOWING", "89.9", "missed 3", "+1.62", "yaw  -35°",
                  "pitch   +3°", "roll   +0°", "line two", "p pause", "s stop", "? help"):  # fmt: skip
        assert words in text, words
    text = text_of(Scene(ASKING, Entry(mode="answer", text="3.2")), size)
    for words in (
        "ASKING",
        "How good was the picture?",
        "1 very good",
        "6 insufficient",
        "entered 3.25",
        "answer > 3.2",
        "Enter",
    ):
        assert words in text, words


@pytest.mark.parametrize("size", SIZES)
def test_the_whole_help_is_readable(size):
    text = text_of(Scene(ASKING, Entry(mode="help")), size)
    for keys, _ in HELP:
        assert keys in text


def test_what_is_wrong_is_loud():
    assert styles_of(Scene(STATES["lost"], Entry()), "TRACKING LOST") == {"class:loud"}
    assert styles_of(Scene(STATES["lost"], Entry()), "PILOT") == {"class:loud"}
    assert styles_of(Scene(SHOWING, Entry(), heard_s=4.0), "NO NEWS FOR 0:04") == {"class:loud"}
    assert "NO NEWS" not in text_of(Scene(STATES["sick"], Entry(), heard_s=60.0), (80, 24))
    assert styles_of(Scene(STATES["sick"], Entry()), "SICKNESS 15 OF 20") == {"class:loud"}


def test_the_condition_stands_there_only_where_the_state_has_it():
    assert "condition: late-200" in text_of(Scene(STATES["open"], Entry()), (80, 24))
    assert "condition" not in text_of(Scene(SHOWING, Entry()), (80, 24))


def test_what_happened_is_read_to_its_end():
    line = "   1:15  Simulator sickness questionnaire (SSQ), question 15 of 16: left unanswered by the participant"
    rows = text_of(Scene(SHOWING, Entry(), ["   1:14  before", line, "   1:16  after"]), (80, 24)).splitlines()
    first = next(k for k, row in enumerate(rows) if "question 15" in row)
    assert " ".join((rows[first] + rows[first + 1]).split()) == " ".join(line.split())
    assert rows[first + 1].index("participant") >= line.index("Simulator") and "1:16" in rows[first + 2]


def test_nothing_is_left_of_a_break_that_ends_when_somebody_says_so():
    resting = attrs.evolve(STATES["break"], left_s=0.0)
    assert "left of this step" not in text_of(Scene(resting, Entry()), (80, 24))
    assert "0:22 left" in text_of(Scene(STATES["break"], Entry()), (80, 24))


def test_what_is_undone_does_not_look_done():
    assert styles_of(Scene(SHOWING, Entry()), "██") == {"class:bar"} and styles_of(Scene(SHOWING, Entry()), "░░") == {
        "class:rest"
    }


def test_no_black_is_bold():
    """xterm draws it grey."""
    for name in ("showing", "paused", "break", "asking", "reading", "waiting"):
        drawn = style(colours=True).get_attrs_for_style_str(f"class:phase.{name}")
        assert (drawn.color, drawn.bold, drawn.reverse) == ("ansiblack", False, False) and drawn.bgcolor


def test_a_window_too_small_says_so_and_keeps_what_matters():
    text = text_of(Scene(STATES["lost"], Entry(mode="stop")), (50, 10))
    for words in ("60 x 20", "SHOWING", "trial 3", "TRACKING LOST", "End the session now?"):
        assert words in text


TEXTS = st.text(max_size=120)
NUMBERS = st.floats(allow_nan=True, allow_infinity=True) | st.floats(-400, 400)

QUESTIONS = st.builds(
    Question, TEXTS, st.just(1.0), st.sampled_from([1.0, 2.0, 6.0, 100.0]), st.sampled_from([0.25, 1.0]),
    st.lists(st.tuples(st.floats(0, 100), TEXTS), max_size=8).map(tuple), st.none() | st.floats(-9, 200),
)  # fmt: skip


@settings(max_examples=60)
@given(
    st.builds(
        DeskState, heading=TEXTS, step=TEXTS, done=NUMBERS, elapsed_s=st.floats(0, 1e6), left_s=st.none() | st.floats(-5, 1e5),
        phase=st.sampled_from(["", "reading", "waiting", "showing", "asking", "break", "paused", "over", "new"]), rate_hz=st.floats(0, 1e4),
        missed=st.integers(0, 10**7), notice=TEXTS, condition=TEXTS,
        question=st.none() | QUESTIONS,
        position_m=st.none() | st.tuples(NUMBERS, NUMBERS, NUMBERS), turned_deg=st.none() | st.tuples(NUMBERS, NUMBERS, NUMBERS),
    ),
    st.lists(TEXTS, max_size=30), st.integers(1, 130), st.integers(1, 50), st.sampled_from(["keys", "answer", "remark", "help", "stop"]),
    TEXTS, TEXTS, st.booleans(),
)  # fmt: skip
def test_every_page_fills_its_window_exactly(state, journal, width, height, mode, typed, note, ascii_only):
    """Whatever is in it: a row one cell too long would push all below it down, a control character would move the cursor."""
    entry = Entry(
        mode=mode, text="".join(c for c in typed if c.isprintable()), note="".join(c for c in note if c.isprintable())
    )
    rows = page(Scene(state, entry, journal, 0.0, ASCII if ascii_only else Scene(state, entry).glyphs), width, height)
    assert len(rows) == height
    for row in rows:
        text = "".join(text for style, text in row if style != "[SetCursorPosition]")
        assert get_cwidth(text) == width, text
        assert text.isprintable()


def test_ascii_screens_are_ascii():
    assert text_of(Scene(ASKING, Entry(), ["a"], 0.0, ASCII), (80, 24)).isascii()


def test_the_scale_marks_what_is_entered_where_it_is():
    for question, value in ((GRADE, 1.0), (GRADE, 3.5), (GRADE, 6.0), (SICK, 15.0)):
        row = scale(attrs.evolve(question, entered=value), 61, Scene(SHOWING, Entry()).glyphs)
        before = len(row[0][1])
        assert row[1][0] == "class:entered" and before == round(
            (value - question.least) / (question.most - question.least) * 60
        )
    plain_row = scale(GRADE, 61, ASCII)[0][1]
    assert [plain_row.index(str(n)) for n in range(1, 7)] == [0, 12, 24, 36, 48, 60]


def test_gauges_turn_to_the_side_the_head_turns_to():
    assert gauge(90.0, -180.0, 11, ASCII).index("#") < 5  # a positive yaw is a turn to the left
    assert gauge(45.0, 90.0, 11, ASCII).index("#") > 5
    assert gauge(1e9, 90.0, 11, ASCII)[-1] == "#" and "#" not in gauge(float("nan"), 90.0, 11, ASCII)


def test_texts():
    assert plain("a\x1b[31mred\x1b[0m\tb\x07\x1b]0;title\x07c") == "ared bc"
    assert wrapped("one two three four", 9, 2, "~") == ["one two", "three fo~"]
    assert end_of("0123456789", 5, "~") == "~6789"
