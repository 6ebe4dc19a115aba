"""Console of plain lines: events on stderr, commands line by line from stdin."""

from __future__ import annotations

import contextlib
import os
import queue
import select
import sys
import threading
from collections.abc import Sequence
from typing import Self

from ...display import Command
from ._base import ConsoleState
from .console_commands import COMMANDS, answers_text, parse_line, subject_of

LAST_LINES_S = 1.0
LONGEST_LINE = 1 << 16  # bytes without a line end: a sender of that sends no commands


class LineConsole:
    """Console of plain lines. stdin may be a terminal, a pipe, a file or absent.

    At the end of stdin commands end, and the session goes on. A thread of its own writes the lines:
    a terminal held by Ctrl-S, or a full pipe, delays no frame.
    """

    def __init__(self, title: str, why: str = "", *, quiet: bool = False) -> None:
        self._quiet = quiet  # whether only the answers to commands are written
        self._state = ConsoleState(heading=title)
        self._shown = ConsoleState()
        self._why = why  # printed first
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()  # None ends the thread
        self._thread = threading.Thread(target=self._write_on, name="console", daemon=True)
        self._input = -1
        self._rest = b""

    def __enter__(self) -> Self:
        self._thread.start()
        with contextlib.suppress(OSError, ValueError, AttributeError):  # no stdin at all
            self._input = sys.stdin.fileno()
        if self._why:
            self.say(self._why)
        if self._input >= 0:
            self.say("commands are read from stdin, one in a line; 'help' lists them")
        return self

    def __exit__(self, *_: object) -> None:
        self._lines.put(None)
        self._thread.join(LAST_LINES_S)

    def tell(self, state: ConsoleState) -> None:
        """Say what is new."""
        self._state = state
        for line in news(self._shown, state):
            self.say(line)
        self._shown = state

    def say(self, text: str) -> None:
        """Write a line, unless the console is quiet."""
        if not self._quiet:
            self._write(text)

    def _write(self, text: str) -> None:
        self._lines.put(text)

    def commands(self) -> Sequence[Command]:
        """Return the commands that came; 2 us where none came."""
        if self._input < 0 or not self._ready():
            return ()
        try:
            data = os.read(self._input, 1 << 12)
        except OSError:
            data = b""
        if not data:
            self._input = -1
        *lines, self._rest = (self._rest + data + (b"" if data else b"\n")).split(b"\n")
        self._rest = self._rest[:LONGEST_LINE]
        commands = [self._command(line.decode("utf-8", "replace")) for line in lines]
        return [command for command in commands if command is not None]

    def _ready(self) -> bool:
        """Return whether there is input; reading its terminal would stop a background program."""
        try:
            if not select.select([self._input], [], [], 0)[0]:
                return False
            return not os.isatty(self._input) or os.tcgetpgrp(self._input) == os.getpgrp()
        except (OSError, ValueError):
            self._input = -1
            return False

    def _command(self, line: str) -> Command | None:
        if line.strip().lower() in ("help", "?"):
            for name, words in COMMANDS.items():
                self._write(f"  {name:<9} {words}")
            return None
        try:
            command = parse_line(line, self._state)
        except ValueError as error:
            self._write(str(error))
            return None
        return Command(*command) if command is not None else None

    def _write_on(self) -> None:
        while (line := self._lines.get()) is not None:
            with contextlib.suppress(OSError, ValueError):  # a closed stderr must not end the session
                print(f"console: {line}", file=sys.stderr, flush=True)


def news(before: ConsoleState, now: ConsoleState) -> list[str]:
    """Return what has changed, in lines; not the numbers that change all the time."""
    lines = []
    if now.heading and now.heading != before.heading:
        lines.append(now.heading)
    if (now.step, now.phase) != (before.step, before.phase) and (now.step or now.phase):
        condition = f" ({now.condition})" if now.condition else ""
        phase = "" if now.phase == "over" else now.phase  # the step says so itself
        lines.append(": ".join(filter(None, (now.step, phase))) + condition)
    if now.notice != before.notice:
        lines.append(f"! {now.notice}" if now.notice else f"no longer: {before.notice}")
    question = now.question
    if question is not None and subject_of(now) != subject_of(before):
        anchors = ", ".join(f"{value:g} {words}" for value, words in question.anchors)
        asked = ": ".join(filter(None, ("asked", question.scale, question.text)))
        lines.append(f"{asked} ({answers_text(question)}{'; ' + anchors if anchors else ''})")
    return lines
