"""The console on a real pseudo-terminal, with a session's program behind it that is also killed."""

from __future__ import annotations

import ast
import os
import signal
import sys
import termios
from pathlib import Path

import pytest

pytest.importorskip("pexpect", reason="these tests drive a pseudo-terminal by pexpect")
pytest.importorskip("pyte", reason="these tests read a screen by pyte")

from .terminals import Terminal, played, played_by_a_shell


@pytest.fixture
def log(tmp_path) -> Path:
    return tmp_path / "asked.log"


def asked(log: Path) -> list[tuple[str, object]]:
    return [ast.literal_eval(line) for line in log.read_text(encoding="utf-8").splitlines() if line.startswith("(")]


def show(log: Path, state: str) -> None:
    new = log.with_suffix(".new")
    new.write_text(state, encoding="utf-8")
    new.replace(log.with_suffix(".state"))


def last(terminal: Terminal) -> str:
    """The lowest line with something on it."""
    return next((line for line in terminal.lines()[::-1] if line), "")


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_a_session_by_typed_commands(log, size):
    """Every command arrives, wrong ones are refused with words, and the terminal is afterwards as
    it was.
    """
    with played(log, "--states", "reading", size=size) as terminal:
        before = terminal.modes()
        terminal.until("P07 | consent | reading | 12:04", "the session begins")
        assert terminal.modes() != before
        terminal.keys("agree\r")
        terminal.until("asked for: agree")
        show(log, "asking")
        terminal.until("asked: How good was the picture?", "asking (3.25 entered)")
        terminal.keys("answer 3,3\r")
        terminal.until("lies between two steps")
        terminal.keys("answer 3,3\x7f5\r")
        terminal.until("asked for: answer")
        terminal.keys("again\r")
        terminal.until("asked for: again")
        terminal.keys("remark the strap slipped: é\r")
        terminal.until("asked for: remark")
        terminal.keys("skip\r")
        terminal.until("asked for: skip")
        show(log, "showing")
        terminal.until("trial 3 of 12 | showing, 0:14 left | 12:04")
        terminal.keys("pause\r")
        terminal.until("asked for: pause")
        show(log, "paused")
        terminal.until("| paused |")
        terminal.keys("continue\r")
        terminal.until("asked for: continue")
        terminal.keys("break\r")
        terminal.until("asked for: break")
        terminal.keys("\x04\x1b[A")  # Ctrl-D and an arrow key do nothing
        terminal.keys("stop\r")
        assert terminal.ended() == 0
        assert terminal.modes() == before
        assert "the program has ended" in terminal.text() and " | " not in last(terminal)
    assert asked(log) == [
        ("agree", None), ("answer", 3.5), ("again", None), ("remark", "the strap slipped: é"), ("skip", None),
        ("pause", None),
        ("continue", None), ("break", None), ("stop", None),
    ]  # fmt: skip


def test_the_status_is_one_line_and_keeps_what_is_typed(log):
    """Lines of the session come above it while a command is half typed, on a narrow screen too."""
    with played(log, "--states", "showing", size=(44, 24)) as terminal:
        terminal.until("P07 | trial 3")
        terminal.keys("pau")
        terminal.until("> pau")
        show(log, "lost")
        terminal.until("! tracking lost | P07")
        assert last(terminal).endswith("> pau")
        assert sum(" > " in line for line in terminal.lines()) == 1
        terminal.keys("se\r")
        terminal.until("asked for: pause")
        terminal.keys("remark " + "漢字" * 40)
        terminal.until("字")
        assert sum(" > " in line for line in terminal.lines()) == 1
    assert asked(log) == [("pause", None)]


def test_the_terminal_is_given_back_after_an_error_and_taken_again_after_a_stop(log):
    with played_by_a_shell(log, "--do", "raise") as terminal:
        before = terminal.modes()
        terminal.until("trial 3 of 12 | showing")
        child = int(Path(f"/proc/{terminal.program.pid}/task/{terminal.program.pid}/children").read_text().split()[0])
        os.kill(child, signal.SIGSTOP)
        termios.tcsetattr(terminal.program.child_fd, termios.TCSANOW, before)
        os.kill(child, signal.SIGCONT)
        terminal.until_holds(lambda: terminal.modes() != before)
        terminal.keys("again\r")
        terminal.until("RuntimeError: a fault in the session", "status 1")
        assert terminal.modes() == before


def test_ctrl_c_ends_the_program_and_the_terminal_is_as_before(log):
    with played(log) as terminal:
        before = terminal.modes()
        terminal.until("trial 3 of 12 | showing")
        terminal.keys("half a line\x03")
        assert terminal.ended() == 0
        assert "the program has ended" in terminal.text()
        assert terminal.modes() == before


def test_without_a_terminal_on_stdout_there_are_plain_lines(log):
    with Terminal(["/bin/sh", "-c", f"{sys.executable} {Path(__file__).with_name('played.py')} {log} | cat"]) as one:
        one.until("console: trial 3 of 12: showing")
        assert " | " not in one.text()
        one.keys("stop\n")
        one.until("the program has ended")


def test_a_terminal_that_cannot_place_text_has_plain_lines(log):
    with played(log, TERM="dumb") as terminal:
        terminal.until("console: trial 3 of 12: showing")
        assert " | " not in terminal.text()
