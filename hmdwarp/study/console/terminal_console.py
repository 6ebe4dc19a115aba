"""Full-screen console, as the session has it, and the choice of a console.

Another program keeps the terminal. Why a program and not a thread: drawing a screen takes some ten
milliseconds of Python, and a thread would hold the interpreter's lock, which the frames need, ten
times a second. And a program outlives this one: after a crash, a SIGKILL or a driver's abort it
restores the terminal and prints the last lines.
"""

from __future__ import annotations

import importlib.util
import json
import os
import signal
import socket
import subprocess
import sys
import termios
from collections.abc import Sequence
from contextlib import suppress
from typing import Self

from ...display import Command
from ...errors import InputError, MachineError
from ...resources import install_line
from .browser_console import BrowserConsole
from .line_console import AUTO, BROWSER, KINDS, LINES, NONE, TERMINAL, Console, ConsoleState, LineConsole, NoConsole
from .message_socket import LONGEST_LINE, MessageSocket, PeerGone, ProgramConsole
from .output_capture import OutputCapture

LEAVING_S = 3.0  # for the console to restore the terminal
# Signals of the session's program alone; the console ends when that program does.
BLOCKED = {signal.SIGINT, signal.SIGTERM, signal.SIGTTOU}
CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from hmdwarp.study.console.terminal_app import main; main(*map(int, sys.argv[2:]))"
)
# After a console that died: colours, pasting, reports of focus and size, page, cursor, wrapping.
RESTORE = b"\x1b[0m\x1b[?2004l\x1b[?1004l\x1b[?2048l\x1b[?1049l\x1b[?25h\x1b[?7h"


class TerminalConsole(ProgramConsole):
    """Full-screen console; stdin and stdout must be a terminal.

    A LineConsole replaces a console program that dies, and the session goes on.
    """

    what = "the full-screen console"

    def __enter__(self) -> Self:
        self._modes = termios.tcgetattr(0)
        here, there = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        capture = self._capture = OutputCapture()
        passed = (there.fileno(), capture.read, capture.err)
        masked = signal.pthread_sigmask(signal.SIG_BLOCK, BLOCKED)  # the new program inherits the mask
        try:
            self.program = subprocess.Popen(
                [sys.executable, "-c", CODE, json.dumps(sys.path), *map(str, passed), str(os.getpid())],
                stdin=0,
                stdout=capture.out,
                stderr=capture.out,  # textual draws on stderr
                pass_fds=passed,
                env=_environment(),
            )
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, masked)
            there.close()
        self.messages = MessageSocket(here)
        capture.begin()
        self.tell(self._state)
        return self

    def tell(self, state: ConsoleState) -> None:
        """Show a new state."""
        self._state = state
        self._queue.tell(state)
        if self._lines is not None:
            self._lines.tell(state)
        else:
            try:
                self.messages.send_state(state)
            except PeerGone:
                self._continue_with_lines()

    def say(self, text: str) -> None:
        """Add a line to the journal."""
        if self._lines is not None:
            self._lines.say(text)
        else:
            try:
                self.messages.send("say", text[:LONGEST_LINE])
            except PeerGone:
                self._continue_with_lines().say(text)

    def commands(self) -> Sequence[Command]:
        """Return the commands since the last call."""
        if self._lines is None:
            try:
                self._queue.receive(self.messages)
            except PeerGone:
                self._continue_with_lines()
        more = self._lines.commands() if self._lines is not None else ()
        taken = self._queue.taken()
        return [*taken, *more] if taken else more

    def _end(self) -> int:
        """Take the terminal back, whatever was left of it. Returns the program's exit status."""
        self.messages.leave()
        self._capture.end()
        try:
            status = self.program.wait(LEAVING_S)
        except subprocess.TimeoutExpired:
            self.program.kill()
            status = self.program.wait()
        finally:
            if self.program.returncode != 0:
                self.program.kill()
                with suppress(OSError):
                    os.write(self._capture.out, RESTORE)
            with suppress(termios.error):
                termios.tcsetattr(0, termios.TCSANOW, self._modes)
            self.messages.close()
            self._capture.close()
        return status


def make_console(kind: str, title: str, *, quiet: bool = False) -> Console:
    """Make a console. kind: one of KINDS; "auto" is the terminal where possible, else lines.

    title: shown until the first state comes. quiet: lines only answer commands.
    Errors: InputError for another kind; MachineError where "terminal" or "browser" is impossible.
    """
    if kind not in KINDS:
        raise InputError(f"--console {kind!r}: there are {', '.join(KINDS)}")
    why = _why_no_terminal() if kind in (AUTO, TERMINAL) else ""
    if kind == TERMINAL and why:
        raise MachineError(f"--console terminal: {why}; or use --console lines")
    if kind == NONE:
        return NoConsole()
    if kind == BROWSER:
        if importlib.util.find_spec("textual_serve") is None:
            raise MachineError(
                f"--console browser needs textual-serve, which is not installed: {install_line('study')}"
            )
        return BrowserConsole(title)
    if kind == LINES or why:
        return LineConsole(title, f"no full-screen console: {why}" if why else "", quiet=quiet)
    return TerminalConsole(title)


def _environment() -> dict[str, str]:
    """Return the environment of the console's program.

    Without a size that a shell has exported: the terminal knows its own, which changes. Without
    the kitty key mode, which a killed program would leave on.
    """
    kept = {name: value for name, value in os.environ.items() if name not in ("COLUMNS", "LINES")}
    return {**kept, "TEXTUAL_DISABLE_KITTY_KEY": "1"}


def _why_no_terminal() -> str:
    """Return why there can be no full-screen console, "" where there can."""
    for name, stream in (("stdin", sys.stdin), ("stdout", sys.stdout)):
        if stream is None or stream.closed or not stream.isatty():
            return f"{name} is not a terminal"
    if os.environ.get("TERM", "dumb") in ("", "dumb"):
        return "TERM says that this terminal cannot place text (dumb, or not set)"
    if importlib.util.find_spec("textual") is None:
        return f"textual is not installed: {install_line('study')}"
    if sys.stdin.fileno() != 0 or sys.stdout.fileno() != 1:
        return "stdin and stdout are other files than the program was started with"
    if os.tcgetpgrp(0) != os.getpgrp():
        return "the program runs in the background"
    return ""
