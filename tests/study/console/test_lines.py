"""The console of lines: what is typed, checked, and what is said."""

from __future__ import annotations

import os
import sys
from contextlib import contextmanager
from pathlib import Path

import attrs
import pytest
from golden_texts import assert_outcomes
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from hmdwarp.study.line_console import (
    LineConsole,
    TypedLine,
    checked_answer,
    clock,
    fitted,
    news,
    parse_line,
    status,
    subject_of,
)

from .played import ASKING, GRADE, SHOWING, STATES

FILE = Path(__file__).with_name("lines.txt")


@contextmanager
def typed(monkeypatch, **more):
    """A console, and what types into its stdin and reads the commands that come of it."""
    read, write = os.pipe()
    with os.fdopen(read) as stdin, os.fdopen(write, "wb", buffering=0) as end:
        monkeypatch.setattr(sys, "stdin", stdin)
        with LineConsole("a study", **more) as console:

            def types(text: str) -> list[tuple[str, object]]:
                end.write(text.encode())
                return [(each.control, each.value) for each in console.commands()]

            yield console, types


# --- what is typed


@given(st.integers(0, 20))
def test_every_step_of_the_scale_is_taken_with_point_and_comma(step):
    value = 1.0 + step * 0.25
    assert checked_answer(f"{value}", GRADE) == checked_answer(f" {value} ".replace(".", ","), GRADE) == value


def test_a_step_that_is_no_binary_fraction_is_met():
    tenths = attrs.evolve(GRADE, least=0.0, most=1.0, step=0.1)
    assert [checked_answer(f"0.{k}", tenths) for k in range(10)] == [round(k / 10, 9) for k in range(10)]


def test_lines_through_pipes(monkeypatch, capfd):
    with typed(monkeypatch) as (console, types):
        console.tell(ASKING)
        asked = types("help\nanswer 3,25\nanswer 9\ndance\npause\nremark it slipped\n")
        assert asked == [("answer", 3.25), ("pause", None), ("remark", "it slipped")]
    said = capfd.readouterr().err
    for words in (
        "commands are read from stdin", "trial 3 of 12: asking", "asked: How good was the picture?", "1 very good",
        "9 is not on the scale", "'dance' is no command", "leave this question",
    ):  # fmt: skip
        assert words in said, said
    assert all(line.startswith("console: ") for line in said.splitlines())


def test_a_last_line_without_an_end_counts_and_the_end_of_stdin_ends_nothing(tmp_path, monkeypatch):
    (tmp_path / "typed").write_text("pause")
    with (tmp_path / "typed").open() as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        with LineConsole("a study") as console:
            console.tell(SHOWING)
            assert [each.control for _ in range(3) for each in console.commands()] == ["pause"]


def test_a_quiet_console_only_answers(capfd, monkeypatch):
    with typed(monkeypatch, quiet=True) as (console, types):
        console.say("a line")
        console.tell(ASKING)
        assert types("dance\npause\n") == [("pause", None)]
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("console: 'dance' is no command")


def test_an_answer_half_typed_is_not_one_to_the_next_question(capfd, monkeypatch):
    with typed(monkeypatch) as (console, types):
        console.tell(ASKING)
        assert types("answer 3") == []
        console.tell(STATES["next"])
        assert types("\nremark it sl") == []
        console.tell(SHOWING)
        assert types("ipped\n") == [("remark", "it slipped")]
    assert "'answer 3' is dropped: what it was typed for is over" in capfd.readouterr().err


class Broken:
    def write(self, text: str) -> int:
        raise BrokenPipeError

    flush = write


@pytest.mark.parametrize("kind", ["lines", "none"])
def test_a_console_without_stdin_or_an_unread_stderr_blocks_nothing(monkeypatch, kind):
    monkeypatch.setattr(sys, "stdin", None if kind == "lines" else sys.stdin)
    monkeypatch.setattr(sys, "stderr", Broken())
    with LineConsole("a study", kind=kind) as console:
        console.tell(SHOWING)
        console.say("a line")
        assert console.commands() == ()


def test_what_is_typed_can_be_mended():
    line = TypedLine()
    assert line.feed("answér 3".encode()) == [] and line.text == "answér 3"
    assert line.feed(b"\x7f4\x1b[A\x1bOB") == [] and line.text == "answér 4"
    assert line.feed(b"\x15pause\rstop\nhe") == ["pause", "stop"] and line.text == "he"
    assert line.feed("é".encode()[:1]) == [] and line.feed("é".encode()[1:]) == [] and line.text == "heé"


# --- what is said


def came_of(line: str) -> object:
    """Of a line typed in a state, of a state after another one, of a state."""
    what, first, rest = (*line.split(" ", 2), "")[:3]
    if what == "news":
        return news(STATES[first], STATES[rest])
    if what == "status":
        return status(STATES[first])
    try:
        return parse_line(rest, STATES[first])
    except ValueError as error:
        return f"refused: {error}"


def test_lines_states_and_news_are_as_they_were():
    """lines.txt; HMDWARP_GOLDEN=write writes it anew: look at the difference."""
    assert_outcomes(FILE, came_of)
    told = {-1: "0:00", 0: "0:00", 59.99: "0:59", 65: "1:05", 3600: "1:00:00", 3723.5: "1:02:03"}
    assert {seconds: clock(seconds) for seconds in told} == told


def test_a_second_scale_that_asks_the_same_is_announced():
    """Who reads the questions aloud must not miss it; no answer typed for the first reaches it."""
    first = attrs.evolve(ASKING, question=attrs.evolve(GRADE, scale="School grade"))
    second = attrs.evolve(first, question=attrs.evolve(first.question, scale="Quality, continuous", most=100.0))
    (line,) = news(first, second)
    assert line.startswith("asked: Quality, continuous: How good was the picture? (1 to 100")
    assert subject_of(first) != subject_of(second)
    assert news(second, second) == []


@given(st.text(), st.text(), st.integers(1, 200))
def test_a_status_line_never_reaches_the_last_column(head, text, columns):
    """There the cursor would go to the next line, and the line before would stay."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", str(columns))
        patch.setenv("LINES", "24")
        line = fitted(head, text)
    assert cell_len(line) <= max(columns - 1, 11) and line.isprintable()
    shown = line.rpartition(" > ")[2] if not {">", " "} & {*text} else ""
    assert text.endswith(shown) or not text.isprintable()
