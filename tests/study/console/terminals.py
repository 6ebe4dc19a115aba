"""A real pseudo-terminal with a program in it (pexpect), and what stands on it (pyte)."""

from __future__ import annotations

import contextlib
import os
import sys
import termios
import time
from collections.abc import Callable
from pathlib import Path

import pexpect
import pyte

ROOT = Path(__file__).resolve().parents[3]
PATIENCE_S = 60.0  # against hanging; a loaded machine is slow


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

    def take(self, seconds: float = 0.05) -> None:
        """What the program has written."""
        with contextlib.suppress(pexpect.TIMEOUT, pexpect.EOF):
            data = self.program.read_nonblocking(1 << 16, timeout=seconds)
            self.raw += data
            self.stream.feed(data)

    def lines(self) -> list[str]:
        self.take()
        return [line.rstrip() for line in self.screen.display]

    def text(self) -> str:
        return "\n".join(self.lines())

    def until(self, what: str, there: bool = True) -> str:
        """Wait for a text on the screen, or for it to go."""
        deadline = time.monotonic() + PATIENCE_S
        while (what in self.text()) != there:
            assert time.monotonic() < deadline, f"{what!r} {'did not come' if there else 'did not go'}:\n{self.text()}"
            if not self.program.isalive():
                self.take()
                assert (what in self.text()) == there, f"the program ended without {what!r}:\n{self.text()}"
        return self.text()

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
        self.take()
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
        ["/bin/sh", "-c", '"$@"; echo "status $?"; exec sleep 60', "sh", sys.executable, PLAYED, str(log), *more]
    )
