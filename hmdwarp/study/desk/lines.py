"""A desk without a screen: a line for each thing that happens on stderr, commands line by line from stdin."""

from __future__ import annotations

import contextlib
import os
import queue
import select
import sys
import threading
from collections.abc import Sequence

from ...display import Command
from ._base import DeskState
from .words import ALL, span, typed

LAST_LINES_S = 1.0
LONGEST_LINE = 1 << 16  # bytes without an end: whatever sends that sends no commands
_END = None


class LinesDesk:
    """why: said first, "" for nothing. stdin may be a terminal, a pipe, a file or nothing; at its end, commands end, the session goes on.

    Lines are written from a thread of its own: a terminal held by Ctrl-S, or a full pipe, holds no pictures.
    """

    def __init__(self, title: str, why: str = "") -> None:
        self._title, self._why = title, why
        self._state = DeskState(heading=title)
        self._told = DeskState()
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._thread = threading.Thread(target=self._write_on, name="desk", daemon=True)
        self._input = -1
        self._rest = b""

    def __enter__(self) -> LinesDesk:
        self._thread.start()
        with contextlib.suppress(OSError, ValueError, AttributeError):  # no stdin at all
            self._input = sys.stdin.fileno()
        if self._why:
            self.say(self._why)
        if self._input >= 0:
            self.say("commands are read from stdin, one in a line; 'help' lists them")
        return self

    def __exit__(self, *_: object) -> None:
        self._lines.put(_END)
        self._thread.join(LAST_LINES_S)

    def tell(self, state: DeskState) -> None:
        """As Desk.tell."""
        self._state = state
        for line in news(self._told, state):
            self.say(line)
        self._told = state

    def say(self, text: str) -> None:
        """As Desk.say."""
        self._lines.put(text)

    def commands(self) -> Sequence[Command]:
        """As Desk.commands. 2 us where nothing has come."""
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
        asked = [self._command(line.decode("utf-8", "replace")) for line in lines]
        return [command for command in asked if command is not None]

    def _ready(self) -> bool:
        """Whether there is something to read; a program in the background must not read its terminal, or it is stopped."""
        try:
            if not select.select([self._input], [], [], 0)[0]:
                return False
            return not os.isatty(self._input) or os.tcgetpgrp(self._input) == os.getpgrp()
        except (OSError, ValueError):
            self._input = -1
            return False

    def _command(self, line: str) -> Command | None:
        if line.strip().lower() in ("help", "?"):
            for name, words in ALL.items():
                self.say(f"  {name:<9} {words}")
            return None
        try:
            asked = typed(line, self._state)
        except ValueError as error:
            self.say(str(error))
            return None
        return Command(*asked) if asked is not None else None

    def _write_on(self) -> None:
        while (line := self._lines.get()) is not _END:
            with contextlib.suppress(OSError, ValueError):  # nobody reads any more: the session goes on
                print(f"desk: {line}", file=sys.stderr, flush=True)


def news(before: DeskState, now: DeskState) -> list[str]:
    """What has changed so that an experimenter should know, in lines. Numbers that change all the time are not among it."""
    lines = []
    if now.heading and now.heading != before.heading:
        lines.append(now.heading)
    if (now.step, now.phase) != (before.step, before.phase) and (now.step or now.phase):
        hidden = f" ({now.condition})" if now.condition else ""
        lines.append(": ".join(filter(None, (now.step, now.phase))) + hidden)
    if now.notice != before.notice:
        lines.append(f"! {now.notice}" if now.notice else f"over: {before.notice}")
    question, last = now.question, before.question
    if question is not None and (last is None or question.text != last.text or now.step != before.step):
        anchors = ", ".join(f"{value:g} {words}" for value, words in question.anchors)
        lines.append(f"asked: {question.text} ({span(question)}{'; ' + anchors if anchors else ''})")
    return lines
