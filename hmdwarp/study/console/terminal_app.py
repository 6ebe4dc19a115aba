"""Program that keeps the terminal of the full-screen console, on textual.

TerminalConsole starts it with the terminal as stdin and stdout. It ends when it is told to, when
the session's program is gone, or when the terminal is. It restores the terminal, then prints what
the session's program printed meanwhile.
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import signal
import socket
import sys
from collections import deque
from typing import ClassVar

from rich.text import Text
from textual import events
from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical
from textual.drivers.linux_driver import LinuxDriver
from textual.widgets import RichLog, Static

from ...platforms import has_hung_up, lower_priority, termios, unblock
from .line_console import ConsoleState, clock
from .message_socket import MessageSocket, PeerGone, pieces
from .screen_text import COLOURED, PLAIN, Entered, KeyEntry, Scene, help_text, plain

ROOMY = 24  # rows from which on there are blank ones between the blocks
REDRAW_S = 0.1  # of new states; keys are shown at once
JOURNAL_LINES = 500
PRINTED_LINES = 500
NICE = 5
NAMED = {"enter": "enter", "escape": "escape", "backspace": "backspace", "ctrl+u": "clear", "ctrl+w": "clear"}
ASCII = str.maketrans("█░─·┼…°", "#.-.+~ ")  # for terminals without Unicode


class AsciiDriver(LinuxDriver):
    """Terminal driver that writes ASCII alone."""

    def write(self, data: str) -> None:
        """Write, with the nearest ASCII character for each other one."""
        super().write(data.translate(ASCII).encode("ascii", "replace").decode())


class PrintedLines:
    """Lines that the session's program printed meanwhile."""

    def __init__(self) -> None:
        self._lines: deque[str] = deque(maxlen=PRINTED_LINES)
        self._dropped = 0
        self._rest = b""

    def feed(self, piece: bytes) -> list[str]:
        """Take what came out of the pipe. Returns the lines it completes."""
        *ended, self._rest = (self._rest + piece).split(b"\n")
        lines = [line.decode("utf-8", "replace").rstrip("\r") for line in ended]
        for line in lines:
            self._dropped += len(self._lines) == PRINTED_LINES
            self._lines.append(line)
        return lines

    def all(self) -> list[str]:
        """Return the newest lines, to be printed once the terminal is restored."""
        dropped = [f".. {self._dropped} lines before these are left out"] if self._dropped else []
        rest = [self._rest.decode("utf-8", "replace")] if self._rest else []
        return [*dropped, *self._lines, *rest]


class ConsoleApp(App[None], inherit_bindings=False):
    """Screen of the console, wherever its terminal is."""

    CSS = """
    Screen { background: ansi_default; color: ansi_default; overflow: hidden; }
    Static { height: 1; text-wrap: nowrap; text-overflow: ellipsis; }
    Horizontal { height: 1; }
    .left { width: 1fr; }
    .right, #phase { width: auto; }
    .wrapped { height: auto; max-height: 2; padding: 0 1; text-wrap: wrap; }
    .block { border-top: solid ansi_bright_black; border-title-color: ansi_bright_black; background: ansi_default; }
    .gap, #help, .help .numbers, .help #journal { display: none; }
    .roomy .gap, .help #help { display: block; }
    .numbers { height: auto; }
    #title { text-style: reverse; }
    #hint { padding-left: 2; }
    #asked { height: 5; }
    .roomy #asked { height: 6; }
    #journal, #help { height: 1fr; scrollbar-size: 0 0; padding: 0 1; }
    #bottom { height: 5; dock: bottom; }
    .typing #note { max-height: 1; }
    #keys { dock: bottom; height: 2; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [Binding("ctrl+l", "repaint", priority=True)]
    ENABLE_COMMAND_PALETTE = False

    def __init__(self, messages: MessageSocket) -> None:
        unicode = (sys.stdout.encoding or "").lower().replace("-", "") == "utf8"
        super().__init__(driver_class=None if unicode else AsciiDriver, ansi_color=True)
        self.theme = "ansi-dark"
        self.left_well = False  # whether the session ended it
        self._messages = messages
        self._state, self._entry = ConsoleState(), KeyEntry()
        self._state_s = 0.0  # when the newest state came
        self._drawn: dict[str, Text] = {}  # by part
        self._drawn_s = 0.0  # when they were drawn; 0 once something is new

    def compose(self) -> ComposeResult:
        """Lay out the parts of screen_text.Scene by their names."""
        yield Horizontal(Static(id="heading", classes="left"), Static(id="loud", classes="right"), id="title")
        yield Static(classes="gap")
        yield Static(id="progress")
        yield Horizontal(Static(id="times", classes="left"), Static(id="condition", classes="right"))
        yield Static(classes="gap")
        yield Horizontal(Static(id="phase"), Static(id="hint", classes="left"))
        yield Static(id="notice")
        with Vertical(classes="numbers"):
            yield Horizontal(Static(id="pictures", classes="left"), Static(id="head", classes="right"))
            yield Static(id="gauges")
            with Vertical(id="asked", classes="block") as asked:
                asked.border_title = "question"
                yield Static(id="question", classes="wrapped")
                yield Horizontal(Static(id="scale", classes="left"), Static(id="entered", classes="right"))
                yield Static(id="anchors", classes="wrapped")
        journal = RichLog(id="journal", classes="block", max_lines=JOURNAL_LINES, wrap=True, min_width=1)
        journal.border_title, journal.can_focus = "journal", False
        yield journal
        with Static(help_text(), id="help", classes="block") as help_block:
            help_block.border_title = "help, Esc closes it"
        lines = (Static(id=name, classes="wrapped") for name in ("note", "line", "keys"))
        yield Vertical(*lines, id="bottom", classes="block")

    def on_mount(self) -> None:
        """Start to listen to the session, and to draw what is new."""
        loop = asyncio.get_running_loop()
        self._state_s = loop.time()
        loop.add_reader(self._messages.fileno(), self._take_messages)
        self.set_interval(REDRAW_S, self._redraw)

    def on_resize(self, event: events.Resize) -> None:
        """Draw for the new size, once its layout is known."""
        self.screen.set_class(event.size.height >= ROOMY, "roomy")
        self.call_after_refresh(self._draw)

    def on_key(self, event: events.Key) -> None:
        """Take a key."""
        key = NAMED.get(event.key) or (event.character if event.is_printable else None)
        if key:
            self._send(self._entry.key(key, self._state))
            self._draw()

    def on_paste(self, event: events.Paste) -> None:
        """Take text from the clipboard."""
        self._entry.paste(event.text, self._state)
        self._draw()

    def action_repaint(self) -> None:
        """Draw everything anew."""
        self.refresh(repaint=True, layout=True)

    def _send(self, entered: Entered | None) -> None:
        if entered is not None:
            with contextlib.suppress(PeerGone):
                self._messages.send("command", *entered)

    def _take_messages(self) -> None:
        try:
            for kind, *content in self._messages.received():
                if kind == "state":
                    self._state, self._state_s = content[0], asyncio.get_running_loop().time()
                    self._drawn_s = 0.0
                elif kind == "say":
                    self._note(*content)
                else:
                    self.left_well = True
                    self._leave()
        except PeerGone:
            self._leave()

    def _leave(self, status: int = 0) -> None:
        asyncio.get_running_loop().remove_reader(self._messages.fileno())
        self.exit(return_code=status)

    def _note(self, text: str, at_s: float | None = None) -> None:
        """Add a line to the journal. at_s: when it was printed; None for now."""
        when = clock(self._state.elapsed_s if at_s is None else at_s)
        self.query_one("#journal", RichLog).write(Text(f"{when:>7}  {plain(text)}"))

    def _redraw(self) -> None:
        """Draw what is new, and once a second in any case: that no news came is news."""
        if has_hung_up(0):
            self._leave(1)
        elif asyncio.get_running_loop().time() - self._drawn_s >= 1.0:
            self._draw()

    def _draw(self) -> None:
        self._drawn_s = asyncio.get_running_loop().time()
        self._entry.follow(self._state)
        self.screen.set_class(self._entry.mode == "help", "help")
        styles = PLAIN if self.no_color else COLOURED
        age_s = self._drawn_s - self._state_s
        parts = Scene(self._state, self._entry, age_s, self.size.width, styles).parts()
        self.screen.set_class(bool(parts["line"]), "typing")
        for name, text in parts.items():
            if self._drawn.get(name) != text:
                self._drawn[name] = text
                self.query_one(f"#{name}", Static).update(text)


class TerminalApp(ConsoleApp):
    """Console in the terminal that the session was started from, whose prints it keeps."""

    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+c", "interrupt('SIGINT')", priority=True),
        Binding("ctrl+backslash", "interrupt('SIGQUIT')", priority=True),
    ]

    def __init__(self, messages: MessageSocket, printed_fd: int, session_pid: int) -> None:
        super().__init__(messages)
        self.printed = PrintedLines()
        self._printed_fd, self._session_pid = printed_fd, session_pid

    def on_mount(self) -> None:
        """Start to listen to what is printed; ConsoleApp's own on_mount runs too."""
        loop = asyncio.get_running_loop()
        self._raw_modes = termios.tcgetattr(0)
        loop.add_reader(self._printed_fd, self._take_printed)
        loop.add_signal_handler(signal.Signals["SIGCONT"], self._come_back)

    def action_interrupt(self, name: str) -> None:
        """Send the session's program the signal that the terminal would send it for this key."""
        if os.getppid() == self._session_pid:
            os.kill(self._session_pid, signal.Signals[name])

    def _take_printed(self) -> None:
        for piece in pieces(self._printed_fd):
            for line in self.printed.feed(piece):
                if line.strip():
                    self._note(f"printed: {line}")

    def _come_back(self) -> None:
        """Take the terminal again after a stop from outside (kill -STOP), when the shell had it."""
        termios.tcsetattr(0, termios.TCSANOW, self._raw_modes)
        self.action_repaint()


def step_back() -> None:
    """Let the session's program run first on a machine with few cores."""
    with contextlib.suppress(OSError):
        lower_priority(NICE, batch=True)


def main(messages_fd: int, printed_fd: int, error_fd: int, session_pid: int) -> None:
    """Run the program. error_fd: stderr of the session's program, for the last lines."""
    step_back()
    unblock(printed_fd)
    app = TerminalApp(MessageSocket(socket.socket(fileno=messages_fd)), printed_fd, session_pid)
    app.run(mouse=False)
    for piece in pieces(printed_fd):
        app.printed.feed(piece)
    lines = app.printed.all()
    if not app.return_code and not app.left_well:
        lines.append(
            "hmdwarp: the session's program ended suddenly; "
            "every confirmed answer is in the store: continue with --resume"
        )
    with contextlib.suppress(OSError), open(error_fd, "w", errors="replace") as stderr:  # noqa: PTH123 (a descriptor)
        for line in lines:
            print(line, file=stderr)
    sys.exit(app.return_code)
