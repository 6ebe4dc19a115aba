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
import secrets
import shlex
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Self

from ...display import Command
from ...errors import InputError, MachineError
from ...platforms import in_foreground, message_socket, message_sockets, signals_blocked, termios
from ...resources import install_line
from .line_console import AUTO, BROWSER, KINDS, LINES, NONE, TERMINAL, Console, ConsoleState, LineConsole, NoConsole
from .message_socket import LINES_KEPT, MessageSocket, OutputCapture, ProgramConsole

LOOPBACK = "127.0.0.1"
TOKEN_BYTES = 24  # of the address: who does not know it gets "404: Not Found"
LEAVING_S = 3.0  # for the programs to end and to restore the terminal
PAGE_CODE = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from hmdwarp.study.console.browser_app import {main}; {main}(*sys.argv[2:])"
)


class BrowserConsole(ProgramConsole):
    """Console in a browser; one page at a time, the newest.

    A LineConsole replaces a server that dies, and the session goes on.
    Errors, on entering: MachineError where no socket can be made.
    """

    what = "the console in the browser"

    def __init__(self, title: str) -> None:
        super().__init__(title)
        self._journal: deque[tuple[str, float]] = deque(maxlen=LINES_KEPT)  # lines, and when they were printed
        self.address = ""

    def __enter__(self) -> Self:
        self._folder = Path(tempfile.mkdtemp(prefix="hmdwarp-console-"))  # for this user alone
        door = str(self._folder / "door")
        self._door = message_socket()
        try:
            self._door.bind(door)
        except OSError as error:  # a path of more than 107 bytes
            self._close_door()
            raise MachineError(f"--console browser: {door}: {error}; TMPDIR may name another folder") from error
        self._door.listen()
        self._door.setblocking(False)
        token = secrets.token_urlsafe(TOKEN_BYTES)
        screen = shlex.join(_program("show", door))
        with socket.create_server((LOOPBACK, 0)) as listener:
            self.address = f"http://{LOOPBACK}:{listener.getsockname()[1]}/{token}/"
            given = {"listener": listener.fileno(), "token": token, "title": self._title, "command": screen}
            self.server = subprocess.Popen(
                _program("serve"),
                stdin=subprocess.PIPE,  # its end tells the server that this program is gone
                stdout=2,
                pass_fds=[listener.fileno()],
                env={**os.environ, "PYTHONUTF8": "1"},
                start_new_session=True,  # Ctrl-C is for this program
            )
        assert self.server.stdin is not None
        with suppress(BrokenPipeError):  # it died: tell() goes on with lines
            self.server.stdin.write(json.dumps({**given, "folder": str(self._folder)}).encode() + b"\n")
            self.server.stdin.flush()
        print(f"console: open {self._told()} in a browser on this machine", file=sys.stderr, flush=True)
        return self

    def _told(self) -> str:
        """Return the address, or a file that has it: a log is kept, and read by others."""
        if not stat.S_ISREG(os.fstat(2).st_mode):
            return self.address
        page = self._folder / "console.html"
        page.write_text(f'<meta http-equiv="refresh" content="0; url={self.address}">', encoding="utf-8")
        return page.as_uri()

    def tell(self, state: ConsoleState) -> None:
        """Show a new state."""
        self._state = state
        if self._lines is None and self.server.poll() is not None:
            self._continue_with_lines()
        super().tell(state)

    def commands(self) -> Sequence[Command]:
        """Return the commands since the last call."""
        if self._lines is None:
            self._welcome()
        return super().commands()

    def _note(self, line: str) -> None:
        self._journal.append((line, self._state.elapsed_s))
        self._reach(lambda page: page.send("say", *self._journal[-1]))

    def _welcome(self) -> None:
        """Take the page that was opened since the last call in place of the one before."""
        try:
            caller, _ = self._door.accept()
        except BlockingIOError:
            return
        self._lose_screen()
        self.messages = MessageSocket(caller)
        self._reach(self._show_all)

    def _show_all(self, page: MessageSocket) -> None:
        page.send_state(self._state)
        for line in self._journal:
            page.send("say", *line)

    def _lose_screen(self) -> None:
        if self.messages is not None:
            self.messages.leave()
            self.messages.close()
            self.messages = None

    def _end(self) -> int:
        """End page and server. Returns the exit status of the server."""
        self._lose_screen()
        assert self.server.stdin is not None
        self.server.stdin.close()
        try:
            status = self.server.wait(LEAVING_S)
        except subprocess.TimeoutExpired:
            self.server.kill()
            status = self.server.wait()
        self._close_door()
        return status

    def _close_door(self) -> None:
        self._door.close()
        shutil.rmtree(self._folder, ignore_errors=True)


def _program(main: str, *arguments: str) -> list[str]:
    return [sys.executable, "-c", PAGE_CODE.format(main=main), json.dumps(sys.path), *arguments]


SCREEN_CODE = (
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
        here, there = message_sockets()
        capture = self._capture = OutputCapture()
        passed = (there.fileno(), capture.read, capture.err)
        try:
            with signals_blocked():  # they are the session's alone; the console ends when that does
                self.program = subprocess.Popen(
                    [sys.executable, "-c", SCREEN_CODE, json.dumps(sys.path), *map(str, passed), str(os.getpid())],
                    stdin=0,
                    stdout=capture.out,
                    stderr=capture.out,  # textual draws on stderr
                    pass_fds=passed,
                    env=_environment(),
                )
        finally:
            there.close()
        self.messages = MessageSocket(here)
        capture.begin()
        self.tell(self._state)
        return self

    def _end(self) -> int:
        """Take the terminal back, whatever was left of it. Returns the program's exit status."""
        assert self.messages is not None
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
    if termios is None or os.environ.get("TERM", "dumb") in ("", "dumb"):
        return "TERM says that this terminal cannot place text (dumb, or not set)"
    if importlib.util.find_spec("textual") is None:
        return f"textual is not installed: {install_line('study')}"
    if sys.stdin.fileno() != 0 or sys.stdout.fileno() != 1:
        return "stdin and stdout are other files than the program was started with"
    if not in_foreground(0):
        return "the program runs in the background"
    return ""
