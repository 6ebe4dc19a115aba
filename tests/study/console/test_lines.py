"""The console of lines, and which console there is."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from pathlib import Path

import attrs
import pytest

from hmdwarp.errors import InputError, MachineError
from hmdwarp.study.console.line_console import ConsoleState, LineConsole, news, subject_of
from hmdwarp.study.console.terminal_console import make_console

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
    for words in ("no full-screen console: stdin is not a terminal", "trial 3 of 12: asking",
    "asked: How good was the picture?",
                  "1 very good", "9 is not on the scale", "'dance' is no command", "leave this question"):  # fmt: skip
        assert words in said, said
    assert all(line.startswith("console: ") for line in said.splitlines())


def test_a_last_line_without_an_end_counts_and_the_end_of_stdin_ends_nothing(tmp_path):
    asked, _ = told(tmp_path, "pause", "--seconds", "1")
    assert asked == [("pause", None)]


def test_no_console_is_silent(tmp_path):
    asked, said = told(tmp_path, "stop\n", "--console", "none", "--seconds", "0.2")
    assert asked == [] and said == ""


def test_news_are_what_an_experimenter_should_know():
    assert news(ConsoleState(), SHOWING) == [SHOWING.heading, "trial 3 of 12: showing"]
    assert news(SHOWING, attrs.evolve(SHOWING, elapsed_s=999.0, rate_hz=1.0, missed=9, done=0.5)) == []
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
        with make_console("auto", "a study", quiet=True) as console:
            console.say("a line")
            console.tell(ASKING)
            commands = [command.control for command in console.commands()]
    assert commands == ["pause"]
    (line,) = capfd.readouterr().err.splitlines()
    assert line.startswith("console: 'dance' is no command")


def test_a_console_whose_stdin_is_closed_asks_for_nothing(monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    with LineConsole("a study") as console:
        console.tell(SHOWING)
        assert console.commands() == ()


def test_an_unread_stderr_blocks_nothing(monkeypatch):
    class Broken:
        def write(self, text: str) -> int:
            raise BrokenPipeError

        flush = write

    monkeypatch.setattr(sys, "stdin", None)
    monkeypatch.setattr(sys, "stderr", Broken())
    with LineConsole("a study") as console:
        console.say("a line")


def test_consoles_that_are_none():
    with pytest.raises(InputError, match="auto, terminal, browser, lines, none"):
        make_console("screen", "a study")
    with pytest.raises(MachineError, match="is not a terminal.*--console lines"):
        make_console("terminal", "a study")
    with make_console("none", "a study") as console:
        console.tell(SHOWING)
        console.say("a line")
        assert console.commands() == ()
