"""What is typed, checked; and the keys, without a terminal."""

from __future__ import annotations

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.study.console.line_console import ConsoleState, checked_answer, clock, parse_line, subject_of
from hmdwarp.study.console.screen_text import KeyEntry

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
        "0:00",
        "0:00",
        "0:59",
        "1:05",
        "1:00:00",
        "1:02:03",
    ]


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


def pressed(entry: KeyEntry, state: ConsoleState, *keys: str) -> list[tuple[str, object]]:
    """What the keys ask for.

    A key that is a word of several letters is typed letter by letter unless it is a name.
    """
    names = ("enter", "escape", "backspace", "clear")
    each = [k for key in keys for k in ([key] if key in names else key)]
    return [asked[:2] for asked in (entry.key(k, state) for k in each) if asked is not None]


@pytest.mark.parametrize(
    ("state", "keys", "asked"),
    [
        ("showing", ["p"], ("pause", None)), ("paused", ["p"], ("continue", None)),
        ("paused", ["c"], ("continue", None)),
        ("waiting", ["c"], ("continue", None)),
        ("break", ["c"], ("continue", None)), ("showing", ["b"], ("break", None)), ("showing", ["r"], ("again", None)),
        ("asking", ["kk"], ("skip", None)), ("reading", ["g", "y"], ("agree", None)),
        ("reading", ["dd"], ("decline", None)),
        ("showing", ["sy"], ("stop", None)),
        ("asking", ["a3.25", "enter", "enter"], ("answer", 3.25)), ("asking", ["2", "enter", "y"], ("answer", 2.0)),
        ("showing", ["mslipped, é 漢", "enter"], ("remark", "slipped, é 漢")),
        ("sick", ["mend", "enter"], ("remark", "end")),
        ("asking", ["47", "backspace", "enter", "enter"], ("answer", 4.0)),
        ("asking", ["47", "clear", "5", "enter", "enter"], ("answer", 5.0)),
        ("asking", ["3", "enter", ".5", "enter", "enter"], ("answer", 3.5)),
    ],
)  # fmt: skip
def test_every_key_asks_for_its_command(state, keys, asked):
    entry = KeyEntry()
    assert pressed(entry, STATES[state], *keys) == [asked]
    assert entry.mode == "keys"


@pytest.mark.parametrize(
    ("state", "keys", "note"),
    [
        ("showing", ["a"], "nothing is being asked"), ("showing", ["k"], "nothing is being asked"),
        ("showing", ["g"], "no text to agree"), ("asking", ["d"], "no text to decline"),
        ("reading", ["d", "n"], "not done"),
        ("waiting", ["g"], "no text to agree"),
        ("showing", ["c"], "going on already"), ("showing", ["x"], "does nothing here"),
        ("showing", ["3"], "does nothing here"),
        ("showing", ["ss"], "not done"), ("showing", ["sn"], "not done"), ("asking", ["k", "n"], "not done"),
        ("sick", ["s"], "is over"),
        ("asking", ["9", "enter"], "not on the scale"), ("asking", ["a", "enter"], "nothing was typed"),
        ("asking", ["3", "enter", "escape"], ""), ("showing", ["m", "enter"], ""),
        ("showing", ["mwords", "escape"], ""),
    ],
)  # fmt: skip
def test_keys_that_ask_for_nothing_say_why(state, keys, note):
    entry = KeyEntry()
    assert pressed(entry, STATES[state], *keys) == []
    assert note in entry.note and bool(entry.note) == bool(note)


def test_an_answer_half_typed_is_not_one_to_the_next_question():
    for keys in (["3"], ["3", "enter"], ["k"]):
        entry = KeyEntry()
        pressed(entry, ASKING, *keys)
        entry.follow(STATES["next"])
        assert entry.mode == "keys" and "over" in entry.note
        assert pressed(entry, STATES["next"], "enter", "y") == []


def test_a_note_expires_and_an_open_line_stays():
    entry = KeyEntry()
    pressed(entry, SHOWING, "x")
    for seconds, there in ((0.0, True), (9.0, True), (10.5, False)):
        entry.follow(attrs.evolve(SHOWING, elapsed_s=SHOWING.elapsed_s + seconds))
        assert bool(entry.note) == there
    pressed(entry, SHOWING, "m", "slipped")
    for seconds in (0.0, 99.0):
        entry.follow(attrs.evolve(SHOWING, elapsed_s=SHOWING.elapsed_s + seconds))
    assert entry.mode == "remark" and entry.text == "slipped"


def test_entries_of_the_participant_do_not_disturb_the_typing():
    entry = KeyEntry()
    pressed(entry, ASKING, "4")
    later = attrs.evolve(ASKING, question=attrs.evolve(GRADE, entered=None), elapsed_s=999.0)
    assert pressed(entry, later, "enter", "enter") == [("answer", 4.0)]


def test_pasting_goes_into_an_open_line_and_never_acts_as_keys():
    entry = KeyEntry()
    entry.paste("sy", SHOWING)
    assert entry.mode == "keys" and "open line" in entry.note
    pressed(entry, SHOWING, "m")
    entry.paste("two\nlines\x1b[31m", SHOWING)
    assert pressed(entry, SHOWING, "enter") == [("remark", "two lines[31m")]


@given(
    st.lists(st.one_of(st.sampled_from(["enter", "escape", "backspace", "clear"]), st.characters()), max_size=40),
    st.data(),
)
def test_any_typing_gives_answers_on_the_scale_about_the_question(keys, data):
    entry = KeyEntry()
    for key in keys:
        state = data.draw(st.sampled_from(list(STATES.values())))
        asked = entry.key(key, state)
        entry.prompt(state.question)
        if asked is not None:
            name, value, what = asked
            assert what == subject_of(state)
            if name == "answer":
                question = state.question
                assert question is not None and checked_answer(str(value), question) == value
            assert name not in ("agree", "decline") or state.phase == "reading"


def test_the_sickness_scale_takes_whole_numbers_only():
    assert checked_answer("15", SICK) == 15.0
    with pytest.raises(ValueError, match="between two steps"):
        checked_answer("15.5", SICK)
