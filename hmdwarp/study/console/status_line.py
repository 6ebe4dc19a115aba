"""Last line of a terminal, redrawn in place: how the session goes, and what is being typed."""

from __future__ import annotations

import codecs
import os
import re
import shutil
import sys
from contextlib import suppress

from ...platforms import in_foreground, termios

ERASE = "\r\x1b[K"  # the line that the cursor is on
LONGEST_LINE = 1 << 16  # letters without a line end: a sender of that sends no commands
_LEAST_HEAD = 24  # cells that a long typed line leaves to the words before it
_ESCAPES = re.compile(r"\x1b(\[[0-9;?]*[ -/]*[@-~]|O.|.)")  # arrow keys and the like


class TypedLine:
    """Line that comes in pieces, from a terminal or a pipe."""

    def __init__(self) -> None:
        self.text = ""
        self._decoder = codecs.getincrementaldecoder("utf-8")("replace")

    def feed(self, data: bytes) -> list[str]:
        """Take bytes, and return the lines that they complete. Ctrl-U and Ctrl-W empty the line."""
        lines = []
        for letter in _ESCAPES.sub("", self._decoder.decode(data)):
            if letter in "\r\n":
                lines.append(self.text)
                self.text = ""
            elif letter in "\b\x7f":
                self.text = self.text[:-1]
            elif letter in "\x15\x17":
                self.text = ""
            elif letter.isprintable() or letter == "\t":
                self.text = (self.text + letter.replace("\t", " "))[:LONGEST_LINE]
        return lines


class RawKeys:
    """Takes the keys of a terminal as they are typed, without its echo, until restore().

    Ctrl-C and Ctrl-Z keep their signals. A program in the background changes no terminal.
    """

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._modes: list[int | list[bytes | int]] | None = None

    def take(self) -> None:
        """Take them; again after a stop, when the shell had the terminal."""
        with suppress(OSError, termios.error):
            if not in_foreground(self._descriptor):
                return
            modes = termios.tcgetattr(self._descriptor)
            if modes[3] & termios.ICANON:
                self._modes = self._modes or termios.tcgetattr(self._descriptor)
                modes[3] &= ~(termios.ICANON | termios.ECHO)
                termios.tcsetattr(self._descriptor, termios.TCSANOW, modes)

    def restore(self) -> None:
        """Give the terminal back as it was. May be called twice."""
        with suppress(OSError, termios.error):
            if self._modes is not None and in_foreground(self._descriptor):
                termios.tcsetattr(self._descriptor, termios.TCSANOW, self._modes)
                self._modes = None


def can_redraw() -> bool:
    """Return whether there is a terminal whose last line can be redrawn."""
    streams = (sys.stdout, sys.stderr)
    if termios is None or os.environ.get("TERM", "dumb") in ("", "dumb"):
        return False
    return all(stream is not None and not stream.closed and stream.isatty() for stream in streams)


def fitted(head: str, typed: str) -> str:
    """Return a line no wider than the terminal: the beginning of `head`, the end of `typed`."""
    from rich.cells import cell_len, set_cell_size

    columns = shutil.get_terminal_size().columns
    with suppress(OSError, ValueError):  # the terminal's own width: COLUMNS of the environment may be another one's
        columns = os.get_terminal_size(sys.stdout.fileno()).columns or columns
    room = max(columns - 4, 8)  # " > ", and the last column, which would wrap
    head, typed = ("".join(filter(str.isprintable, text)) for text in (head, typed))
    while typed and cell_len(typed) > max(room - _LEAST_HEAD, room // 2):
        typed = typed[1:]
    head = set_cell_size(head, min(cell_len(head), room - cell_len(typed)))
    return f"{head} > {typed}"
