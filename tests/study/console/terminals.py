"""A real pseudo-terminal with a program in it (pexpect), and what stands on it (pyte)."""

from __future__ import annotations

import os
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path

import pexpect
import pyte

ROOT = Path(__file__).resolve().parents[3]
PATIENCE_S = 600.0  # against hanging; a loaded machine is slow, and may stand still


class Terminal:
    """argv: the program. size: (columns, rows). more: of the environment."""

    def __init__(self, argv: list[str], size: tuple[int, int] = (80, 24), **more: str) -> None:
        columns, rows = size
        environment = {**os.environ, "TERM": "xterm-256color", "PYTHONPATH": str(ROOT), "PYTHONUTF8": "1", **more}
        environment.pop("NO_COLOR", None) if "NO_COLOR" not in more else None
        self.screen = pyte.Screen(columns, rows)
        self.stream = pyte.ByteStream(self.screen)
        self.raw = b""
        self.program = pexpect.spawn(
            argv[0], argv[1:], dimensions=(rows, columns), env=environment, timeout=PATIENCE_S, cwd=str(ROOT)
        )
        self.program.delaybeforesend = None

    def __enter__(self) -> Terminal:
        return self

    def __exit__(self, *_: object) -> None:
        self.program.close(force=True)

    def take(self, seconds: float = 0.05) -> bool:
        """Read what the program has written; return whether that was anything."""
        try:
            data = self.program.read_nonblocking(1 << 16, timeout=seconds)
        except (pexpect.TIMEOUT, pexpect.EOF):
            return False
        self.raw += data
        self.stream.feed(data)
        return True

    def lines(self) -> list[str]:
        self.take()
        return [line.rstrip() for line in self.screen.display]

    def text(self) -> str:
        return "\n".join(self.lines())

    def until(self, *what: str, there: bool = True) -> str:
        """Wait for texts that are on the screen together, or for all of them to go."""
        deadline, has_ended = time.monotonic() + PATIENCE_S, False
        while off := [each for each in what if (each in (text := self.text())) != there]:
            assert not has_ended and time.monotonic() < deadline, (
                f"{off} {'did not come' if there else 'did not go'}, has ended: {has_ended}\n{text}"
            )
            has_ended = not self.program.isalive()
            while has_ended and self.take():  # a terminal gives a few kilobytes at a time
                pass
        return text

    def until_holds(self, holds: Callable[[], bool]) -> None:
        """Wait for anything else."""
        deadline = time.monotonic() + PATIENCE_S
        while not holds():
            self.take()
            assert time.monotonic() < deadline, f"it did not come to be:\n{self.text()}"

    def keys(self, text: str) -> None:
        self.program.send(text)

    def resize(self, columns: int, rows: int) -> None:
        self.screen.resize(rows, columns)
        self.program.setwinsize(rows, columns)

    def modes(self) -> list:
        return termios.tcgetattr(self.program.child_fd)

    def ended(self) -> int | None:
        """Wait until the program has; its exit status, None if by a signal."""
        deadline = time.monotonic() + PATIENCE_S
        while self.program.isalive():
            self.take()
            assert time.monotonic() < deadline, f"it does not end:\n{self.text()}"
        while self.take():
            pass
        return self.program.exitstatus


PLAYED = str(Path(__file__).with_name("played.py"))


def played(log: Path, *more: str, size: tuple[int, int] = (80, 24), **environment: str) -> Terminal:
    """played.py in a terminal."""
    return Terminal([sys.executable, PLAYED, str(log), *more], size, **environment)


def played_by_a_shell(log: Path, *more: str) -> Terminal:
    """played.py in a shell's terminal, which stays when the program dies.

    The shell then says "status N".
    """
    return Terminal(
        ["/bin/sh", "-c", '"$@"; echo "status $?"; exec sleep 600', "sh", sys.executable, PLAYED, str(log), *more]
    )
