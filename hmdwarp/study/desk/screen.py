"""The program that keeps the experimenter's screen: draws what it is told, sends what is asked for, and gives the terminal back at the end.

Started by TerminalDesk alone, with the terminal as stdin and stdout. It ends when it is told to, when its session's program is gone, or
when the terminal is.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import sys
import traceback
from collections import deque

from prompt_toolkit.application import Application
from prompt_toolkit.data_structures import Size
from prompt_toolkit.filters import Condition
from prompt_toolkit.formatted_text import StyleAndTextTuples
from prompt_toolkit.input import create_input
from prompt_toolkit.input.vt100 import raw_mode
from prompt_toolkit.layout import FormattedTextControl, Layout, Window
from prompt_toolkit.output import create_output

from ._base import DeskState
from .capture import pieces
from .cells import ASCII, Glyphs, plain
from .drawing import Scene, page
from .entry import Asked, Entry
from .keys import bindings
from .post import Gone, Post
from .styles import style
from .words import clock

REDRAW_S = 0.1  # of what is told; keys are shown at once
JOURNAL_LINES = 500
PRINTED_LINES = 500
NICE = 5
ESCAPE_S = 0.1  # after which a lone Esc is Esc and not the beginning of an arrow key; slow lines (ssh) need some


class Screen:
    """post: to the session. printed: the read end of what the session's program prints. parent: its process id."""

    def __init__(self, post: Post, printed: int, parent: int) -> None:
        self._post, self._printed, self._parent = post, printed, parent
        self.state, self.entry = DeskState(), Entry()
        self.left_well = False
        self._journal: deque[str] = deque(maxlen=JOURNAL_LINES)
        self._kept: deque[str] = deque(maxlen=PRINTED_LINES)
        self._dropped = 0
        self._rest = b""
        self._heard_s = 0.0
        self._stale = self._dirty = False
        encoding = (sys.stdout.encoding or "").lower().replace("-", "")
        self._glyphs = Glyphs() if encoding == "utf8" else ASCII
        self.app = self._application()

    def _application(self) -> Application[None]:
        control = FormattedTextControl(self._text, focusable=True)
        hidden = Condition(lambda: self.entry.mode not in ("answer", "sure", "remark", "stop", "skip", "agree"))
        window = Window(control, wrap_lines=False, always_hide_cursor=hidden)
        app: Application[None] = Application(
            layout=Layout(window), key_bindings=bindings(self), style=style(not os.environ.get("NO_COLOR")), full_screen=True,
            input=create_input(sys.stdin), output=create_output(sys.stdout), min_redraw_interval=0.03, mouse_support=False,
        )  # fmt: skip
        app.ttimeoutlen = app.timeoutlen = ESCAPE_S
        return app

    async def run(self) -> None:
        """Until it is over."""
        loop = asyncio.get_running_loop()
        self._heard_s = loop.time()
        loop.add_reader(self._post_fd, self._hear)
        loop.add_reader(self._printed, self._hear_printed)
        loop.add_signal_handler(signal.SIGCONT, self._come_back)
        keep_fresh = asyncio.create_task(self._keep_fresh())
        try:
            await self.app.run_async(handle_sigint=False, set_exception_handler=False)
        finally:
            keep_fresh.cancel()
            loop.remove_reader(self._printed)
            loop.remove_reader(self._post_fd)
            self._hear_printed()

    @property
    def _post_fd(self) -> int:
        return self._post.fileno()

    def ask(self, asked: Asked | None) -> None:
        """Send what a key has completed."""
        if asked is not None:
            with contextlib.suppress(Gone):
                self._post.send("command", *asked)

    def signal(self, number: int) -> None:
        """What the terminal would have sent to the session's program for this key."""
        if os.getppid() == self._parent:
            os.kill(self._parent, number)

    def printed_lines(self) -> list[str]:
        """What the session's program printed meanwhile, to be printed once the terminal is as it was."""
        rest = [self._rest.decode("utf-8", "replace")] if self._rest else []
        return [*([f".. {self._dropped} lines before these are left out"] if self._dropped else []), *self._kept, *rest]

    def _text(self) -> StyleAndTextTuples:
        size: Size = self.app.output.get_size()
        self.entry.follow(self.state)
        heard_s = asyncio.get_running_loop().time() - self._heard_s
        scene = Scene(self.state, self.entry, list(self._journal)[-size.rows :], heard_s, self._glyphs)
        out: StyleAndTextTuples = []
        for row in page(scene, size.columns, size.rows):
            out += [*row, ("", "\n")]
        return out[:-1]

    def _hear(self) -> None:
        try:
            for packet in self._post.received():
                self._take(packet)
        except Gone:
            self._leave()

    def _take(self, packet: tuple[object, ...]) -> None:
        if packet[0] == "state":
            assert isinstance(packet[1], DeskState)
            self.state, self._heard_s = packet[1], asyncio.get_running_loop().time()
        elif packet[0] == "say":
            self._note(str(packet[1]))
        else:
            self.left_well = True
            self._leave()
        self._dirty = True

    def _leave(self) -> None:
        if self.app.future is not None and not self.app.future.done():
            self.app.exit()

    def _hear_printed(self) -> None:
        for piece in pieces(self._printed):
            *lines, self._rest = (self._rest + piece).split(b"\n")
            for line in lines:
                text = line.decode("utf-8", "replace").rstrip("\r")
                self._dropped += len(self._kept) == PRINTED_LINES
                self._kept.append(text)
                if text.strip():
                    self._note(f"printed: {text}")

    def _note(self, text: str) -> None:
        self._journal.append(f"{clock(self.state.elapsed_s):>7}  {plain(text)}")
        self._dirty = True

    async def _keep_fresh(self) -> None:
        """Draw what is new, and once a second in any case: how long there was no news is news."""
        count = 0
        while True:
            await asyncio.sleep(REDRAW_S)
            count += 1
            if self._dirty or count % 10 == 0:
                self._dirty = False
                self.app.invalidate()

    def _come_back(self) -> None:
        """After a stop from outside (kill -STOP): the shell has had the terminal meanwhile."""
        raw_mode(0).__enter__()
        self.app.renderer.clear()
        self.app.invalidate()


def _behind_the_pictures() -> None:
    """Where there are few cores, this program waits for the session's: as SCHED_BATCH it does not push it aside whenever news arrive."""
    with contextlib.suppress(OSError, AttributeError):
        os.nice(NICE)
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def main(post_fd: str, printed_fd: str, parent: str) -> None:
    """The whole program; its arguments are file descriptors and the session's process id."""
    _behind_the_pictures()
    post = Post(socket.socket(fileno=int(post_fd)))
    os.set_blocking(int(printed_fd), False)
    screen = Screen(post, int(printed_fd), int(parent))
    status = 0
    try:
        asyncio.run(screen.run())
    except (EOFError, OSError) as error:
        status, why = 1, f"the terminal is gone: {error}".rstrip(": ")
    except Exception:
        status, why = 1, traceback.format_exc().strip().splitlines()[-1]
    if status:
        with contextlib.suppress(Gone):
            post.send("failed", why)
    for line in screen.printed_lines():
        with contextlib.suppress(OSError):
            print(line, file=sys.stderr)
    if not status and not screen.left_well:
        print(
            "hmdwarp: the session's program ended suddenly; every confirmed answer is in the store: go on with --resume",
            file=sys.stderr,
        )
    sys.exit(status)
