"""Console as a session sees it, commands that experimenters type, and the console of lines."""

from __future__ import annotations

import codecs
import math
import os
import queue
import re
import select
import shutil
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from typing import Self

import attrs

from ..base import in_foreground, termios
from ..display import Command
from .scales import Stepped, number_text, range_text

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
            if letter in "\r\n\x15\x17":
                self.text = ""
            elif letter in "\b\x7f":
                self.text = self.text[:-1]
            elif letter.isprintable() or letter == "\t":
                self.text = (self.text + letter.replace("\t", " "))[:LONGEST_LINE]
        return lines


class _RawKeys:
    """Takes a terminal's keys as they are typed, until restore(); not in the background."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor = descriptor
        self._modes: list[int | list[bytes | int]] | None = None

    def take(self) -> None:
        """Take them; again after a stop, when the shell had the terminal."""
        with suppress(OSError, termios.error):
            if in_foreground(self._descriptor):
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


KINDS = (LINES, NONE) = ("lines", "none")


@attrs.frozen
class Question(Stepped):
    """Question that the participant answers now."""

    text: str
    least: float  # lowest answer
    most: float  # highest answer
    step: float  # distance between two answers
    anchors: tuple[tuple[float, str], ...] = ()  # (value, words) of some answers
    entered: float | str | None = None  # answer so far, before it is confirmed; None for nothing
    scale: str = ""  # title of its scale: two scales may ask the same in the same words
    in_words: bool = False  # whether the answer is a text and no number


@attrs.frozen(kw_only=True)
class ConsoleState:
    """All that a console shows. It hides the condition unless the experimenter may know it."""

    heading: str = ""  # study, participant, session; PILOT and SIMULATED stand out
    participant: str = ""  # code, with PILOT or SIMULATED
    step: str = ""  # "trial 3 of 12"
    elapsed_s: float = 0.0  # since this run of the program began
    left_s: float | None = None  # of this step; None where unknown
    seen_s: float | None = None  # of a trial that the participant ends; None for any other step
    # "reading" (consent), "waiting" (to begin), "showing", "asking", "break", "paused" or "over"
    phase: str = ""
    question: Question | None = None
    rate_hz: float = 0.0  # frames per second
    missed: int = 0  # refreshes without a new frame
    notice: str = ""  # "tracking lost"
    condition: str = ""  # "" where it is hidden


COMMANDS = {
    "pause": "hold everything until it is continued",
    "continue": "go on, after a pause or a break",
    "break": "a break after this trial",
    "again": "ask the last question once more",
    "answer": "what the participant says: answer 3.25",
    "skip": "leave this question without an answer",
    "remark": "a line for the journal: remark the strap slipped",
    "agree": "the participant has read the text and agrees",
    "decline": "the participant does not agree: the session ends, and counts nowhere",
    "stop": "end the session; answers are kept",
}
_LONGEST_REMARK = 1000
BOUND = ("answer", "skip", "agree", "decline")  # belong to their subject, and must not reach the step after it
_Subject = tuple[str, str, str, bool]  # step, scale, question, whether it is the consent


def clock(seconds: float) -> str:
    """Return 1:05, or 1:02:03 from an hour on; whole seconds, rounded down."""
    whole = max(0, math.floor(seconds))
    hours, minutes = whole // 3600, whole % 3600 // 60
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"


def checked_answer(text: str, question: Question) -> float | str:
    """Return the typed answer, which may have a decimal comma. Errors: ValueError."""
    text, wanted = text.strip(), "" if question.in_words else f"answers go from {range_text(question)}"
    if question.in_words:
        if not text:
            raise ValueError("nothing was typed: this question is answered in words; skip leaves it without an answer")
        return text
    try:
        number = float(text.replace(",", ".").encode("ascii"))
    except ValueError:
        raise ValueError(f"{f'{text!r} is no number' if text else 'nothing was typed'}: {wanted}") from None
    if not question.least <= number <= question.most:  # refuses NaN too
        raise ValueError(f"{text} is not on the scale: {wanted}")
    if (value := question.value_of(number)) is None:
        raise ValueError(f"{text} lies between two steps: {wanted}")
    return value


def refusal(name: str, state: ConsoleState) -> str:
    """Return why a command has no meaning now, "" where it has one."""
    if state.phase == "over" and name != "remark":
        return "the session is over"
    asks, reads = state.question is not None, state.phase == "reading"
    goes_on = state.phase not in ("paused", "break", "waiting")
    refusals = {
        "skip": (not asks, "nothing is being asked now"),
        "answer": (not asks, "nothing is being asked now"),
        "agree": (not reads, "there is no text to agree to now"),
        "decline": (not reads, "there is no text to decline now"),
        "continue": (goes_on, "it is going on already: there is no pause and no break"),
        "pause": (state.phase == "paused", "it is paused already"),
        "break": (state.phase == "break", "it is a break already"),
    }
    holds, why = refusals.get(name, (False, ""))
    return why if holds else ""


def subject_of(state: ConsoleState) -> _Subject:
    """Return the subject of an answer typed now; once it has changed, the answer is void."""
    scale, text = ("", "") if state.question is None else (state.question.scale, state.question.text)
    return state.step, scale, text, state.phase == "reading"


def parse_line(line: str, state: ConsoleState) -> tuple[str, object] | None:
    """Parse a command and its value; None for an empty line. Errors: ValueError."""
    name, _, rest = line.strip().partition(" ")
    name, rest = name.lower(), rest.strip()
    if not name:
        return None
    if name not in COMMANDS:
        raise ValueError(f"{name!r} is no command: there are {', '.join(COMMANDS)} and help")
    if why := refusal(name, state):
        raise ValueError(why)
    if name == "answer":
        assert state.question is not None
        return name, checked_answer(rest, state.question)
    if name == "remark" and not rest:
        raise ValueError("a remark needs words: remark the strap slipped")
    if rest and name != "remark":
        raise ValueError(f"{name!r} takes no value: {rest!r} means nothing")
    return name, rest[:_LONGEST_REMARK] or None


_LAST_LINES_S = 1.0


class LineConsole:
    """Console of lines on stderr: a context manager around a session, which may be left twice.

    stdin may be a terminal, a pipe, a file or absent; at its end commands end, and the session goes
    on. On a terminal the last line shows how the session goes, and what is being typed. No method
    blocks: a thread of its own writes, so that a terminal held by Ctrl-S, or a full pipe, delays no
    frame.
    """

    def __init__(self, title: str, *, kind: str = LINES, quiet: bool = False) -> None:
        """Make one that says `title` until a state comes. kind: NONE shows and reads nothing."""
        self._kind = kind
        self._quiet = quiet or kind == NONE  # whether only the answers to commands are written
        self._state = ConsoleState(heading=title)
        self._shown = ConsoleState()
        self._lines: queue.SimpleQueue[str | None] = queue.SimpleQueue()  # "" draws the last line, None ends the thread
        self._thread = threading.Thread(target=self._write_on, name="console", daemon=True)
        self._input = -1
        self._typed = TypedLine()
        self._typed_for = subject_of(self._state)  # what a half-typed line is about
        self._redraws = False
        self._keys: _RawKeys | None = None

    def __enter__(self) -> Self:
        if self._kind == LINES:
            with suppress(OSError, ValueError, AttributeError):  # no stdin at all
                self._input = sys.stdin.fileno()
        streams, term = (sys.stdout, sys.stderr), os.environ.get("TERM", "dumb")
        can_redraw = termios is not None and term not in ("", "dumb")
        can_redraw &= all(stream is not None and not stream.closed and stream.isatty() for stream in streams)
        self._redraws = not self._quiet and can_redraw
        if self._redraws and self._input >= 0 and os.isatty(self._input):
            self._keys = _RawKeys(self._input)
            self._keys.take()
        self._thread.start()
        if self._input >= 0:
            self.say("commands are read from stdin, one in a line; 'help' lists them")
        return self

    def __exit__(self, *_: object) -> None:
        self._lines.put(None)
        self._thread.join(_LAST_LINES_S)
        if self._keys is not None:
            self._keys.restore()

    def tell(self, state: ConsoleState) -> None:
        """Show a new state; called a few times a second."""
        self._state = state
        for line in news(self._shown, state):
            self.say(line)
        self._shown = state
        if self._keys is not None:
            self._keys.take()
        self._draw()

    def say(self, text: str) -> None:
        """Write a line of the journal, unless the console is quiet."""
        if not self._quiet:
            self._lines.put(text)

    def commands(self) -> Sequence[Command]:
        """Return the experimenter's commands since the last call; 2 us where none came.

        "pause", "continue", "break", "again", "skip", "stop", "agree" and "decline" have no value;
        "answer" has a number, or a text for a question in words, "remark" a text.
        """
        if self._input < 0:
            return ()
        try:  # reading its terminal would stop a background program
            ready = select.select([self._input], [], [], 0)[0]
            if not ready or (os.isatty(self._input) and not in_foreground(self._input)):
                return ()
        except (OSError, ValueError):
            self._input = -1
            return ()
        try:
            data = os.read(self._input, 1 << 12)
        except OSError:
            data = b""
        if not data:
            self._input = -1
        if not self._typed.text:
            self._typed_for = subject_of(self._state)
        commands = [self._command(line) for line in self._typed.feed(data or b"\n")]
        self._draw()
        return [command for command in commands if command is not None]

    def _command(self, line: str) -> Command | None:
        if line.strip().lower() in ("help", "?"):
            for name, words in COMMANDS.items():
                self._lines.put(f"  {name:<9} {words}")
            return None
        try:
            command = parse_line(line, self._state)
            if command is not None and command[0] in BOUND and self._typed_for != subject_of(self._state):
                raise ValueError(f"{line.strip()!r} is dropped: what it was typed for is over")
        except ValueError as error:
            self._lines.put(str(error))
            return None
        return Command(*command) if command is not None else None

    def _draw(self) -> None:
        if self._redraws and self._lines.empty():
            self._lines.put("")

    def _write_on(self) -> None:
        while True:
            line = self._lines.get()
            text = f"console: {line}\n" if line else ""
            if self._redraws:
                last = "" if line is None else fitted(status(self._state), self._typed.text)
                text = f"{ERASE}{text}{last}"
            with suppress(OSError, ValueError):  # a closed stderr must not end the session
                print(text, end="", file=sys.stderr, flush=True)
            if line is None:
                return


def status(state: ConsoleState) -> str:
    """Return participant, step, state and time in one line."""
    phase, entered = state.phase, state.question.entered if state.question is not None else None
    if isinstance(entered, float | int):
        phase += f" ({number_text(entered)} entered)"
    if state.seen_s is not None:
        phase += f", {clock(state.seen_s)} so far"
    if state.left_s:
        phase += f", {clock(state.left_s)} left"
    rate = f"{state.rate_hz:.1f}/s, {state.missed} missed" if state.rate_hz else ""
    parts = (state.participant or state.heading, state.step, phase, state.condition, clock(state.elapsed_s), rate)
    return " | ".join(filter(None, (f"! {state.notice}" if state.notice else "", *parts)))


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
        answers = "in words" if question.in_words else range_text(question)
        lines.append(f"{asked} ({answers}{'; ' + anchors if anchors else ''})")
    return lines
