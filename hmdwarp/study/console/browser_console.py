"""Console in a browser on this machine: the terminal's screen, served by textual-serve.

A program of its own serves the page and starts the screen for it, for the reasons of
terminal_console. The screen calls this program by a socket in a folder that only this user may
open: a page that is closed and opened again gets the state and the journal anew.
"""

from __future__ import annotations

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
from ...errors import MachineError
from .line_console import ConsoleState
from .message_socket import LINES_KEPT, LONGEST_LINE, MessageSocket, PeerGone, ProgramConsole

LOOPBACK = "127.0.0.1"
TOKEN_BYTES = 24  # of the address: who does not know it gets "404: Not Found"
LEAVING_S = 3.0  # for the page's programs to end
CODE = (
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
        self._page: MessageSocket | None = None
        self.address = ""

    def __enter__(self) -> Self:
        self._folder = Path(tempfile.mkdtemp(prefix="hmdwarp-console-"))  # for this user alone
        door = str(self._folder / "door")
        self._door = socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET)
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
        self._queue.tell(state)
        if self._lines is not None:
            self._lines.tell(state)
        elif self.server.poll() is not None:
            self._continue_with_lines()
        elif self._page is not None:
            try:
                self._page.send_state(state)
            except PeerGone:
                self._close_page()

    def say(self, text: str) -> None:
        """Add a line to the journal."""
        if self._lines is not None:
            self._lines.say(text)
            return
        line = text[:LONGEST_LINE], self._state.elapsed_s
        self._journal.append(line)
        if self._page is not None:
            try:
                self._page.send("say", *line)
            except PeerGone:
                self._close_page()

    def commands(self) -> Sequence[Command]:
        """Return the commands since the last call."""
        if self._lines is not None:
            return [*self._queue.taken(), *self._lines.commands()]
        self._welcome()
        if self._page is not None:
            try:
                self._queue.receive(self._page)
            except PeerGone:
                self._close_page()
        return self._queue.taken()

    def _welcome(self) -> None:
        """Take the page that was opened since the last call in place of the one before."""
        try:
            caller, _ = self._door.accept()
        except BlockingIOError:
            return
        self._close_page()
        self._page = MessageSocket(caller)
        try:
            self._page.send_state(self._state)
            for line in self._journal:
                self._page.send("say", *line)
        except PeerGone:
            self._close_page()

    def _close_page(self) -> None:
        if self._page is not None:
            self._page.leave()
            self._page.close()
            self._page = None

    def _end(self) -> int:
        """End page and server. Returns the exit status of the server."""
        self._close_page()
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
    return [sys.executable, "-c", CODE.format(main=main), json.dumps(sys.path), *arguments]
