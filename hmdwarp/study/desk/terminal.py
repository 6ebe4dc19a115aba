"""The experimenter's screen, as the session has it: a program of its own keeps the terminal, and this end sends it what is new.

Why a program and not a thread: drawing a screen is some ten milliseconds of Python, and a thread that does it holds the lock that the
pictures need, ten times a second. And a program outlives this one: after a crash, a SIGKILL or a driver's abort it gives the terminal
back as it was and prints what was said last.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
import termios
from collections import deque
from collections.abc import Sequence
from contextlib import suppress

from ...display import Command
from ._base import DeskState
from .capture import Capture
from .lines import LinesDesk
from .post import LONGEST_LINE, Gone, Post
from .words import about, bound

LEAVING_S = 3.0  # for the screen to give the terminal back
NOT_FOR_THE_SCREEN = {
    signal.SIGINT,
    signal.SIGTERM,
    signal.SIGTTOU,
}  # they are this program's; its end is the screen's end
CODE = "import json, sys; sys.path[:] = json.loads(sys.argv[1]); from hmdwarp.study.desk.screen import main; main(*sys.argv[2:])"
LEFT = b"\x1b[0m\x1b[?2004l\x1b[?1049l\x1b[?25h\x1b[?7h"  # of a screen that died: colours, pasting, the other page, cursor, wrapping


class TerminalDesk:
    """stdin and stdout must be a terminal. A screen that dies is replaced by a LinesDesk; the session goes on."""

    def __init__(self, title: str) -> None:
        self._title = title
        self._state = DeskState(heading=title)
        self._asked: deque[Command] = deque()
        self._bound: deque[tuple[str, object, object]] = (
            deque()
        )  # commands that are about what was on when they were typed
        self._told = True  # since a bound one was handed over: only then is it known what the next one would be about
        self._lines: LinesDesk | None = None
        self._failed = ""

    def __enter__(self) -> TerminalDesk:
        self._modes = termios.tcgetattr(0)
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._capture = Capture()
        masked = signal.pthread_sigmask(
            signal.SIG_BLOCK, NOT_FOR_THE_SCREEN
        )  # the new program starts with these blocked
        try:
            self._screen = subprocess.Popen(
                [sys.executable, "-c", CODE, json.dumps(sys.path), str(there.fileno()), str(self._capture.read), str(os.getpid())],
                stdin=0, stdout=self._capture.out, stderr=self._capture.err, pass_fds=(there.fileno(), self._capture.read),
            )  # fmt: skip
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, masked)
            there.close()
        self._post = Post(here)
        self._capture.begin()
        self.tell(self._state)
        return self

    def __exit__(self, *_: object) -> None:
        if self._lines is not None:
            self._lines.__exit__()
            return
        self._post.leave()
        self._end()

    def tell(self, state: DeskState) -> None:
        """As Desk.tell."""
        self._state, self._told = state, True
        if self._lines is not None:
            self._lines.tell(state)
        else:
            try:
                self._post.state(state)
            except Gone:
                self._go_on_with_lines()

    def say(self, text: str) -> None:
        """As Desk.say."""
        if self._lines is not None:
            self._lines.say(text)
        else:
            try:
                self._post.send("say", text[:LONGEST_LINE])
            except Gone:
                self._go_on_with_lines()
                self.say(text)

    def commands(self) -> Sequence[Command]:
        """As Desk.commands."""
        if self._lines is None:
            try:
                self._post.flush()
                for packet in self._post.received():
                    self._take(packet)
                self._hand_over_bound()
            except Gone:
                self._go_on_with_lines()
        more = self._lines.commands() if self._lines is not None else ()
        if not self._asked:
            return more
        asked = [*self._asked, *more]
        self._asked.clear()
        return asked

    def _take(self, packet: tuple[object, ...]) -> None:
        if packet[0] == "failed":
            self._failed = str(packet[1])
            return
        _, name, value, what = packet
        if bound(str(name)):
            self._bound.append((str(name), value, what))
        else:
            self._asked.append(Command(str(name), value))

    def _hand_over_bound(self) -> None:
        """One at a time: after an answer, a second one typed for the same question must not become one to the next."""
        while self._bound and self._told:
            name, value, what = self._bound.popleft()
            if what != about(self._state):
                self._post.send("say", f"{name!r} came too late and was dropped: that question is over")
            else:
                self._asked.append(Command(name, value))
                self._told = False

    def _go_on_with_lines(self) -> None:
        """The screen is gone, with the terminal in whatever state."""
        died = self._end()
        why = self._failed or f"exit status {died}"
        self._lines = LinesDesk(self._title, f"the experimenter's screen ended ({why}); the session goes on")
        self._lines.__enter__()
        self._lines.tell(self._state)

    def _end(self) -> int:
        """Take the terminal back, whatever the screen does. Returns the screen's exit status."""
        self._capture.end()
        try:
            status = self._screen.wait(LEAVING_S)
        except subprocess.TimeoutExpired:
            self._screen.kill()
            status = self._screen.wait()
        finally:
            if self._screen.returncode != 0:
                self._screen.kill()
                with suppress(OSError):
                    os.write(self._capture.out, LEFT)
            with suppress(termios.error):
                termios.tcsetattr(0, termios.TCSANOW, self._modes)
            self._post.close()
            self._capture.close()
        return status
