"""The console on a real pseudo-terminal, with a session's program behind it that is also killed."""

from __future__ import annotations

import ast
import os
import signal
import sys
import termios
import time
from pathlib import Path

import pytest

pexpect = pytest.importorskip("pexpect", reason="these tests drive a pseudo-terminal by pexpect")
pyte = pytest.importorskip("pyte", reason="these tests read a screen by pyte")

ROOT = Path(__file__).resolve().parents[3]
PATIENCE_S = 600.0  # against hanging; a loaded machine is slow, and may stand still
PLAYED = [sys.executable, str(Path(__file__).with_name("played.py"))]


class Terminal:
    """A pseudo-terminal with a program in it (pexpect), and what stands on it (pyte)."""

    def __init__(self, argv: list[str], columns: int = 80, **more: str) -> None:
        environment = {**os.environ, "TERM": "xterm-256color", "PYTHONPATH": str(ROOT), "PYTHONUTF8": "1", **more}
        environment.pop("NO_COLOR", None)
        self.screen = pyte.Screen(columns, 24)
        self._stream = pyte.ByteStream(self.screen)
        self.program = pexpect.spawn(
            argv[0], argv[1:], dimensions=(24, columns), env=environment, timeout=PATIENCE_S, cwd=str(ROOT)
        )
        self.program.delaybeforesend = None
        self._deadline = time.monotonic() + PATIENCE_S

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *_: object) -> None:
        self.program.close(force=True)

    def read(self) -> bool:
        """Take what the program has written; return whether there may be more."""
        assert time.monotonic() < self._deadline, f"it takes too long:\n{self.text()}"
        try:
            self._stream.feed(self.program.read_nonblocking(1 << 16, timeout=0.05))
        except pexpect.TIMEOUT:
            return True
        except pexpect.EOF:
            return False
        return True

    def lines(self) -> list[str]:
        return [line.rstrip() for line in self.screen.display]

    def text(self) -> str:
        return "\n".join(self.lines())

    def last(self) -> str:
        """The lowest line with something on it."""
        return next((line for line in self.lines()[::-1] if line), "")

    def until(self, *what: str) -> None:
        """Wait for texts that are on the screen together."""
        is_open = True
        while off := [each for each in what if each not in self.text()]:
            assert is_open, f"it ended, and {off} did not come:\n{self.text()}"
            is_open = self.read()

    def modes(self) -> list:
        return termios.tcgetattr(self.program.child_fd)


@pytest.fixture
def log(tmp_path) -> Path:
    return tmp_path / "asked.log"


def asked(log: Path) -> list[tuple[str, object]]:
    return [ast.literal_eval(line) for line in log.read_text(encoding="utf-8").splitlines()]


def show(log: Path, state: str) -> None:
    new = log.with_suffix(".new")
    new.write_text(state, encoding="utf-8")
    new.replace(log.with_suffix(".state"))


SESSION = [  # the state, what is there then, what is typed, what comes of it
    ("reading", "P07 | consent | reading | 12:04", "agree\r", "asked for: agree"),
    ("asking", "asking (3.25 entered)", "answer 3,3\r", "lies between two steps"),
    ("asking", "asked: How good was the picture?", "answer 3,3\x7f5\r", "asked for: answer"),
    ("asking", "asking", "again\r", "asked for: again"),
    ("asking", "asking", "remark the strap slipped: é\r", "asked for: remark"),
    ("asking", "asking", "skip\r", "asked for: skip"),
    ("showing", "trial 3 of 12 | showing, 0:14 left | 12:04", "pause\r", "asked for: pause"),
    ("paused", "| paused |", "continue\r", "asked for: continue"),
    ("paused", "| paused |", "break\r\x04\x1b[A", "asked for: break"),  # Ctrl-D and an arrow key do nothing
]


def test_a_session_by_typed_commands(log):
    """Every command arrives, wrong ones are refused with words, and the terminal is afterwards as
    it was.
    """
    with Terminal([*PLAYED, str(log), "reading"]) as terminal:
        before = terminal.modes()
        terminal.until("the session begins")
        for state, there, keys, told in SESSION:
            show(log, state)
            terminal.until(there)
            assert terminal.modes() != before
            terminal.program.send(keys)
            terminal.until(told)
        terminal.program.send("stop\r")
        terminal.until("the program has ended")
        assert " | " not in terminal.last() and terminal.modes() == before
        while terminal.read():
            pass
        assert terminal.program.wait() == 0
    values = {"answer": 3.5, "remark": "the strap slipped: é"}
    commands = ("agree", "answer", "again", "remark", "skip", "pause", "continue", "break", "stop")
    assert asked(log) == [(command, values.get(command)) for command in commands]


def test_the_status_is_one_line_and_keeps_what_is_typed(log):
    """Lines of the session come above it while a command is half typed, on a narrow screen too."""
    with Terminal([*PLAYED, str(log), "showing"], 44) as terminal:
        terminal.until("P07 | trial 3")
        terminal.program.send("pau")
        terminal.until("> pau")
        show(log, "lost")
        terminal.until("! tracking lost | P07")
        assert terminal.last().endswith("> pau")
        assert sum(" > " in line for line in terminal.lines()) == 1
        terminal.program.send("se\r")
        terminal.until("asked for: pause")
        terminal.program.send("remark " + "漢字" * 40)
        terminal.until("字")
        assert sum(" > " in line for line in terminal.lines()) == 1
    assert asked(log) == [("pause", None)]


def test_the_terminal_is_given_back_after_an_error_and_taken_again_after_a_stop(log):
    """By a shell, whose terminal stays when the program dies."""
    shell = ["/bin/sh", "-c", '"$@"; echo "status $?"; exec sleep 600', "sh"]
    with Terminal([*shell, *PLAYED, str(log), "showing", "fault"]) as terminal:
        before = terminal.modes()
        terminal.until("trial 3 of 12 | showing")
        child = int(Path(f"/proc/{terminal.program.pid}/task/{terminal.program.pid}/children").read_text().split()[0])
        os.kill(child, signal.SIGSTOP)
        termios.tcsetattr(terminal.program.child_fd, termios.TCSANOW, before)
        os.kill(child, signal.SIGCONT)
        while terminal.modes() == before:
            terminal.read()
        terminal.program.send("again\r")
        terminal.until("RuntimeError: a fault in the session", "status 1")
        assert terminal.modes() == before


@pytest.mark.parametrize(("end", "kind"), [(" | cat", "xterm"), ("", "dumb")], ids=["no terminal", "dumb"])
def test_what_cannot_place_text_has_plain_lines(log, end, kind):
    with Terminal(["/bin/sh", "-c", f"{' '.join(PLAYED)} {log} showing{end}"], TERM=kind) as terminal:
        terminal.until("console: trial 3 of 12: showing")
        assert " | " not in terminal.text()
        terminal.program.send("stop\n")
        terminal.until("the program has ended")
