"""The console of lines."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import attrs
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.cells import cell_len

from hmdwarp.study.line_console import ConsoleState, LineConsole, TypedLine, fitted, news, status, subject_of

from .played import ASKING, GRADE, SHOWING, STATES

ROOT = Path(__file__).resolve().parents[3]
PATIENCE_S = 600


def told(tmp_path, commands: str, *more: str) -> tuple[list[tuple[str, object]], str]:
    """What a played session got from these lines on stdin, and what it said on stderr."""
    log = tmp_path / "asked.log"
    done = subprocess.run(
        [sys.executable, str(Path(__file__).with_name("played.py")), str(log), *more], input=commands,
         capture_output=True, text=True,
        cwd=ROOT, env={"PYTHONPATH": str(ROOT), "PATH": "/usr/bin:/bin"}, timeout=PATIENCE_S, check=True,
    )  # fmt: skip
    return [ast.literal_eval(line) for line in log.read_text(encoding="utf-8").splitlines()], done.stderr


def test_lines_through_pipes(tmp_path):
    asked, said = told(
        tmp_path, "help\nanswer 3,25\nanswer 9\ndance\npause\nremark it slipped\nstop\n", "--states", "asking"
    )
    assert asked == [("answer", 3.25), ("pause", None), ("remark", "it slipped"), ("stop", None)]
    for words in ("commands are read from stdin", "trial 3 of 12: asking",
    "asked: How good was the picture?",
                  "1 very good", "9 is not on the scale", "'dance' is no command", "leave this question"):  # fmt: skip
        assert words in said, said
    assert all(line.startswith("console: ") for line in said.splitlines())


def test_a_last_line_without_an_end_counts_and_the_end_of_stdin_ends_nothing(tmp_path):
    asked, _ = told(tmp_path, "pause", "--seconds", "1")
    assert asked == [("pause", None)]


def test_news_are_what_an_experimenter_should_know():
    assert news(ConsoleState(), SHOWING) == [SHOWING.heading, "trial 3 of 12: showing"]
    assert news(SHOWING, attrs.evolve(SHOWING, elapsed_s=999.0, rate_hz=1.0, missed=9)) == []
    assert news(SHOWING, attrs.evolve(SHOWING, notice="tracking lost")) == ["! tracking lost"]
    assert news(attrs.evolve(SHOWING, notice="tracking lost"), SHOWING) == ["no longer: tracking lost"]
    assert news(ASKING, attrs.evolve(ASKING, question=attrs.evolve(ASKING.question, entered=1.0))) == []
    assert [line[:6] for line in news(ASKING, STATES["next"])] == ["trial ", "asked:"]
    assert news(SHOWING, STATES["open"]) == []
    assert news(SHOWING, attrs.evolve(SHOWING, step="session finished", phase="over")) == ["session finished"]
    assert news(ConsoleState(heading=SHOWING.heading), STATES["open"]) == ["trial 3 of 12: showing (late-200)"]


def test_a_second_scale_that_asks_the_same_is_announced():
    """Who reads the questions aloud must not miss it; no answer typed for the first reaches it."""
    first = attrs.evolve(ASKING, question=attrs.evolve(GRADE, scale="School grade"))
    second = attrs.evolve(first, question=attrs.evolve(first.question, scale="Quality, continuous", most=100.0))
    (line,) = news(first, second)
    assert line.startswith("asked: Quality, continuous: How good was the picture? (1 to 100")
    assert subject_of(first) != subject_of(second)
    assert news(second, second) == []


def test_a_quiet_console_only_answers(capfd, monkeypatch):
    read, write = os.pipe()
    with os.fdopen(read) as stdin, os.fdopen(write, "w") as typed:
        monkeypatch.setattr(sys, "stdin", stdin)
        typed.write("dance\npause\n")
        typed.flush()
        with LineConsole("a study", quiet=True) as console:
            console.say("a line")
            console.tell(ASKING)
            commands = [command.control for command in console.commands()]
    assert commands == ["pause"]
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("console: 'dance' is no command")


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


def test_the_status_says_who_what_and_when():
    assert status(SHOWING) == "P07 | trial 3 of 12 | showing, 0:14 left | 12:04 | 89.9/s, 3 missed"
    assert status(ASKING).startswith("P07 | trial 3 of 12 | asking (3.25 entered) | 12:04")
    assert status(STATES["break"]).startswith("P07 | break 1 of 2 | break, 0:22 left")
    assert status(STATES["open"]).split(" | ")[3] == "late-200"
    assert status(STATES["lost"]).startswith("! tracking lost | P07 - PILOT | ")
    done = attrs.evolve(SHOWING, seen_s=12.0, left_s=588.0)
    assert "showing, 0:12 so far, 9:48 left" in status(done)


@given(st.text(), st.text(), st.integers(1, 200))
def test_a_status_line_never_reaches_the_last_column(head, typed, columns):
    """There the cursor would go to the next line, and the line before would stay."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("COLUMNS", str(columns))
        patch.setenv("LINES", "24")
        line = fitted(head, typed)
    assert cell_len(line) <= max(columns - 1, 11) and line.isprintable()
    shown = line.rpartition(" > ")[2] if not {">", " "} & {*typed} else ""
    assert typed.endswith(shown) or not typed.isprintable()


def test_what_is_typed_can_be_mended():
    line = TypedLine()
    assert line.feed("answér 3".encode()) == [] and line.text == "answér 3"
    assert line.feed(b"\x7f4\x1b[A\x1bOB") == [] and line.text == "answér 4"
    assert line.feed(b"\x15pause\rstop\nhe") == ["pause", "stop"] and line.text == "he"
    assert line.feed("é".encode()[:1]) == [] and line.feed("é".encode()[1:]) == [] and line.text == "heé"


def test_an_answer_half_typed_is_not_one_to_the_next_question(capfd, monkeypatch):
    read, write = os.pipe()
    with os.fdopen(read) as stdin, os.fdopen(write, "wb", buffering=0) as typed:
        monkeypatch.setattr(sys, "stdin", stdin)
        with LineConsole("a study") as console:
            console.tell(ASKING)
            typed.write(b"answer 3")
            assert console.commands() == []
            console.tell(STATES["next"])
            typed.write(b"\nremark it sl")
            assert console.commands() == []
            console.tell(SHOWING)
            typed.write(b"ipped\n")
            assert [(each.control, each.value) for each in console.commands()] == [("remark", "it slipped")]
    assert "'answer 3' is dropped: what it was typed for is over" in capfd.readouterr().err
