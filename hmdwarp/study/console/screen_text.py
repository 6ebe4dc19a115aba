"""What the screen of a console shows, and the entry of commands key by key, without a terminal."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping

import attrs
from rich.cells import cell_len
from rich.text import Text

from ..scales import number_text
from .line_console import (
    LONGEST_REMARK,
    ConsoleState,
    Question,
    Subject,
    answers_text,
    checked_answer,
    clock,
    refusal,
    subject_of,
)

KEYS = {
    "p": "pause", "c": "continue", "b": "break", "r": "again", "a": "answer", "k": "skip", "m": "remark",
    "g": "agree", "d": "decline", "s": "stop", "?": "help",
}  # fmt: skip
LONGEST_ANSWER = 12
NOTED_S = 10.0  # how long a note stays; later it would seem to be about something else
# A stray key must not do these: they are confirmed first. The same key again confirms a consent or
# a skipped question, but not the end.
CONFIRMATIONS = {
    "stop": "End the session now? Everything answered so far is kept. y ends it, any other key does not",
    "skip": "Leave this question without an answer? y or k leaves it, any other key does not",
    "agree": "Does the participant agree to the text? y or g: yes, any other key: not yet",
    "decline": "Does the participant decline? The session ends then. y or d: yes, any other key: not yet",
}
CONFIRMED_BY = {"stop": "y", "skip": "yk", "agree": "yg", "decline": "yd"}
DONE = {
    "pause": "pause requested", "continue": "going on", "break": "break requested", "skip": "left without an answer",
    "again": "the last question is asked once more", "agree": "agreed", "decline": "declined", "stop": "end requested",
    "remark": "the remark is in the journal",
}  # fmt: skip
LINES = ("answer", "sure", "remark")  # modes with an open line
Entered = tuple[str, object, Subject]  # command, its value, and what it is about


@attrs.define
class KeyEntry:
    """State of the experimenter's typing."""

    mode: str = "keys"  # "keys", "help", one of LINES ("sure": of an answer) or of CONFIRMATIONS
    text: str = ""  # typed so far
    note: str = ""  # what came of the last key
    loud: bool = False  # whether the note is a refusal
    _subject: Subject | None = None
    _in_words: bool = False  # whether the open answer is a text
    _noted: tuple[str, float] = ("", 0.0)  # the note, and when it appeared

    def key(self, key: str, state: ConsoleState) -> Entered | None:
        """Take a key and return the command it completes, if any.

        key: one character, or "enter", "escape", "backspace", "clear".
        """
        self.follow(state)
        if self.mode == "keys":
            return self._first(key, state)
        if key == "escape" or (self.mode == "help" and key in ("enter", "?")):
            self._back("")
            return None
        if self.mode == "help":
            return self._first(key, state)
        if self.mode in CONFIRMATIONS:
            name = self.mode
            confirmed = key.lower() in CONFIRMED_BY[name]
            self._back(DONE[name] if confirmed else "not done")
            return (name, None, subject_of(state)) if confirmed else None
        if key == "enter" or (self.mode == "sure" and key == "y"):
            return self._send(state)
        self._edit(key)
        return None

    def paste(self, text: str, state: ConsoleState) -> None:
        """Insert text from the clipboard into an open line; it never acts as keys."""
        self.follow(state)
        if self.mode in LINES:
            for character in " ".join(text.split()):
                self._edit(character)
        else:
            self._say("pasted text goes into an open line only: a for an answer, m for a remark", loud=True)

    def follow(self, state: ConsoleState) -> None:
        """Follow the session: a half-typed answer is void once its question is over."""
        if self.mode in ("answer", "sure", "skip", "agree", "decline") and self._subject != subject_of(state):
            typed = self.mode in ("answer", "sure")
            self._back("")
            self._say("that question is over: what was typed is dropped" if typed else "that is over", loud=True)
        elif self.mode == "stop" and state.phase == "over":
            self._back("")
        if self.note != self._noted[0]:
            self._noted = (self.note, state.elapsed_s)
        elif self.mode == "keys" and state.elapsed_s - self._noted[1] >= NOTED_S:
            self._say("")

    def prompt(self, question: Question | None) -> str:
        """Return the words before the typed text."""
        if self.mode == "sure" and question is not None:
            return f"{_answer_text(checked_answer(self.text, question))}? Enter again or y sends it >"
        return {"answer": "answer >", "remark": "remark >"}.get(self.mode, CONFIRMATIONS.get(self.mode, ""))

    def _first(self, key: str, state: ConsoleState) -> Entered | None:
        self.mode, self.text = "keys", ""
        if state.question is not None and (key.isdigit() or key in ("-", ".", ",")):
            self._open("answer", state)
            self._edit(key)
            return None
        if key in ("escape", "enter", "backspace", "clear"):
            self._say("")
            return None
        name = KEYS.get(key.lower(), "")
        if not name:
            self._say(f"{key!r} does nothing here: ? shows the keys", loud=True)
            return None
        if name == "pause" and state.phase in ("paused", "break"):
            name = "continue"
        return self._begin(name, state)

    def _begin(self, name: str, state: ConsoleState) -> Entered | None:
        why = "" if name == "help" else refusal(name, state)
        if why:
            self._say(why, loud=True)
        elif name in ("answer", "remark", "help") or name in CONFIRMATIONS:
            self._open(name, state)
        else:
            self._say(DONE[name])
            return name, None, subject_of(state)
        return None

    def _open(self, mode: str, state: ConsoleState) -> None:
        self.mode, self.text, self._subject = mode, "", subject_of(state)
        self._in_words = state.question is not None and state.question.in_words
        self._say("")

    def _edit(self, key: str) -> None:
        if self.mode == "sure":
            self.mode = "answer"
        if key == "backspace":
            self.text = self.text[:-1]
        elif key == "clear":
            self.text = ""
        elif len(key) == 1 and key.isprintable():
            most = LONGEST_ANSWER if self.mode == "answer" and not self._in_words else LONGEST_REMARK
            self.text = (self.text + key)[:most]
            self._say("" if len(self.text) < most else "the line is full", loud=True)

    def _send(self, state: ConsoleState) -> Entered | None:
        if self.mode == "remark":
            text = self.text.strip()
            self._back(DONE["remark"] if text else "")
            return ("remark", text, subject_of(state)) if text else None
        assert state.question is not None  # follow() has closed the line of a question that is over
        try:
            value = checked_answer(self.text, state.question)
        except ValueError as error:
            self.mode = "answer"
            self._say(str(error), loud=True)
            return None
        if self.mode == "answer":
            self.mode = "sure"
            self._say("")
            return None
        self._back(f"{_answer_text(value)} is the answer")
        return "answer", value, subject_of(state)

    def _back(self, note: str) -> None:
        self.mode, self.text, self._subject = "keys", "", None
        self._say(note)

    def _say(self, note: str, loud: bool = False) -> None:
        self.note, self.loud = note, loud and bool(note)


def _answer_text(value: float | str) -> str:
    return value if isinstance(value, str) else number_text(value)


STALE_S = 3.0  # without a new state
HINTS = {
    "reading": "g once they agree to the text, d if they decline.",
    "waiting": "The participant goes on when ready; c does it for them.",
    "showing": "The participant looks. Nothing to do.",
    "asking": "The participant answers. Said aloud: type it.",
    "break": "A break. c ends it.",
    "paused": "Everything waits. c continues.",
    "over": "The session is over.",
}
LABELS = {"again": "repeat"}  # of keys; the others have the command's name
LINE_KEYS = "Enter:sends  Esc:leaves the line  Ctrl-U:empties it"
HELP = (
    ("p c", "pause, and continue; what was on is shown or asked again"),
    ("b", "a break as soon as there may be one; c ends it"),
    ("r", "ask the last question again; the old answer is kept beside the new"),
    ("a, digits", "type the answer that the participant says; Enter, then Enter"),
    ("k", "leave the question without an answer"),
    ("m", "a remark for the journal of the session"),
    ("g, d", "the participant has read the text and agrees, or declines"),
    ("s", "stop now, without a reason; nothing is lost"),
    ("Ctrl-C", "stop the program; Esc: leave a line or this help"),
)
# The terminal's own sixteen colours, readable on any background. Black is never bold: xterm and
# others draw bold black as dark grey, which on cyan or yellow cannot be read.
PLAIN = {
    "loud": "bold reverse", "refused": "bold underline", "bar": "", "dim": "",
    **dict.fromkeys(("showing", "paused", "break", "asking", "reading", "waiting"), "bold reverse"),
}  # fmt: skip
COLOURED = {
    "loud": "bold white on red", "refused": "bold red", "bar": "green", "dim": "bright_black",
    "showing": "black on green", **dict.fromkeys(("paused", "break"), "black on yellow"),
    **dict.fromkeys(("asking", "reading", "waiting"), "black on cyan"),
}  # fmt: skip
_ESCAPES = re.compile(r"\x1b(\[[0-9;?]*[ -/]*[@-~]|\][^\x07\x1b]*(\x07|\x1b\\)?|.)")
_LOUD = re.compile(r"\b(PILOT|REHEARSAL|SIMULATED)\b")
_TICKS = (0.25, 0.5, 1, 2, 5, 10, 20, 25, 50, 100)
_CELLS_PER_TICK = 5  # a number of three digits, and room


@attrs.frozen
class Scene:
    """All that the screen shows."""

    state: ConsoleState
    entry: KeyEntry
    age_s: float = 0.0  # since the state came
    width: int = 80
    styles: Mapping[str, str] = attrs.field(factory=lambda: COLOURED)

    def parts(self) -> dict[str, Text]:
        """Return the text of every part of the screen by its name."""
        state = self.state
        return {**self._top(), **self._head(), **self._question(state.question), **self._bottom()}

    def _top(self) -> dict[str, Text]:
        state = self.state
        heading = plain(state.heading)
        loud = list(dict.fromkeys(_LOUD.findall(heading)))
        rest = re.sub(r"\s{2,}", " ", _LOUD.sub("", heading)).strip(" ,;:·-|()[]") if loud else heading
        # A break without a time ends at the experimenter's word.
        left_s = None if state.phase == "break" and not state.left_s else state.left_s
        left = f"   {clock(left_s)} left of this step" if left_s is not None else ""
        if state.seen_s is not None:
            left = f"   {clock(state.seen_s)} of this step so far, {left.strip()} at most"
        style = self.styles.get(state.phase, "bold reverse")
        return {
            "heading": Text(f" {rest}"),
            "loud": _styled(f" {' '.join(loud)} " if loud else "", self.styles["loud"]),
            "progress": self._progress(),
            "times": Text.assemble(f" {clock(state.elapsed_s)} since the start", (left, "bold")),
            "condition": Text(f"condition: {plain(state.condition)} " if state.condition else ""),
            "phase": _styled(f" {state.phase.upper() or 'STARTING'} ", style),
            "hint": Text(HINTS.get(state.phase, "")),
            "notice": self._notice(),
        }

    def _progress(self) -> Text:
        state = self.state
        share = min(1.0, max(0.0, state.done)) if math.isfinite(state.done) else 0.0
        step = plain(state.step)
        room = max(4, self.width - cell_len(step) - 12)
        full = math.floor(room * share)
        # The rest is not in the bar's green, in which it would look done.
        bar = (("█" * full, self.styles["bar"]), ("░" * (room - full), self.styles["dim"]))
        return Text.assemble((f" {step}  ", "bold"), *bar, f"  {math.floor(100 * share):3d} %")

    def _notice(self) -> Text:
        state = self.state
        if self.age_s >= STALE_S and state.phase not in ("", "over"):
            why = "the pictures stand still, or the program is busy"
            return Text.assemble(" ", (f" NO NEWS FOR {clock(self.age_s)}: {why} ", self.styles["loud"]))
        notice = plain(state.notice)
        return Text.assemble(" ", (f" {notice.upper()} ", self.styles["loud"])) if notice else Text()

    def _head(self) -> dict[str, Text]:
        state = self.state
        pictures = Text(f" pictures {state.rate_hz:5.1f}/s  missed {state.missed}")
        if state.position_m is None or state.angles_deg is None:
            return {"pictures": pictures, "head": Text(), "gauges": Text(" head: none yet")}
        x, y, z = state.position_m
        room = max(5, (self.width - 47) // 3 | 1)
        gauges = Text()
        # Turns to the left are positive, and stand on the left.
        for name, degrees, most in zip(("yaw", "pitch", "roll"), state.angles_deg, (-180.0, 90.0, -90.0), strict=True):
            gauges.append(f" {name} {degrees:+4.0f}° ").append(gauge(degrees, most, room), self.styles["bar"])
        return {"pictures": pictures, "head": Text(f"head {x:+.2f} {y:+.2f} {z:+.2f} m "), "gauges": gauges}

    def _question(self, question: Question | None) -> dict[str, Text]:
        if question is None:
            return {"question": Text("none now"), "scale": Text(), "entered": Text(), "anchors": Text()}
        number = question.entered
        entered = (
            "nothing entered"
            if number is None
            else f"entered {number_text(number)}"
            if isinstance(number, float | int)
            else "words entered"
        )
        anchors = "; ".join(f"{number_text(value)} {plain(text)}" for value, text in question.anchors)
        return {
            "question": _styled(plain(question.text), "bold"),
            "scale": Text(" ") + scale_line(question, self.width - 20),
            "entered": _styled(f" {entered} ", "bold"),
            "anchors": Text(anchors or answers_text(question)),
        }

    def _bottom(self) -> dict[str, Text]:
        entry, line = self.entry, Text()
        if entry.mode not in ("keys", "help"):
            prompt = f"{entry.prompt(self.state.question)} "
            line = _styled(prompt + end_of(entry.text, max(1, self.width - cell_len(prompt) - 3)), "bold")
            line.append(" ", "reverse")
        keys = Text(LINE_KEYS if entry.mode in LINES else keys_now(self.state))
        keys.highlight_regex(r"\S+(?=:)", "bold")
        note = _styled(plain(entry.note), self.styles["refused"] if entry.loud else "bold")
        return {"note": note, "line": line, "keys": keys}


def keys_now(state: ConsoleState) -> str:
    """Return the keys that do something now; all of them would not fit into 80 columns."""
    useful = {key: name for key, name in KEYS.items() if name == "help" or not refusal(name, state)}
    return "  ".join(f"{key}:{LABELS.get(name, name)}" for key, name in useful.items())


def help_text() -> Text:
    """Return all keys with what they do."""
    return Text("\n").join(Text.assemble((f" {keys:<10}", "bold"), words) for keys, words in HELP)


def plain(text: str) -> str:
    """Return the text without colours, bells and cursor movements, its blanks as spaces."""
    text = _ESCAPES.sub("", text)
    return "".join(" " if c in "\t\n\r" else c for c in text if c.isprintable() or c in "\t\n\r")


def end_of(text: str, width: int) -> str:
    """Return the last `width` cells: a line that is being typed shows its end."""
    if cell_len(text) <= width:
        return text
    while text and cell_len(text) > width - 1:
        text = text[1:]
    return f"…{text}"


def gauge(value: float, most: float, cells: int) -> str:
    """Draw a bar of `cells` (odd) from -most to most with a mark at the value.

    `most` may be negative; the mark of a value beyond the ends stays there.
    """
    place = round((min(1.0, max(-1.0, value / most)) + 1.0) / 2.0 * (cells - 1)) if math.isfinite(value) else -1
    return "".join("█" if k == place else "┼" if k == cells // 2 else "·" for k in range(cells))


def scale_line(question: Question, cells: int) -> Text:
    """Draw 1────2────3────4 with the entered value's cell in reverse."""
    span = question.most - question.least
    if span <= 0 or cells < 4:
        return Text()
    least = max(question.step, 1.0 if span >= 3 else 0.0)
    tick = next((t for t in _TICKS if t >= least and (cells - 1) * t / span >= _CELLS_PER_TICK), span)
    line = ["─"] * cells
    for k in range(math.floor(span / tick + 1e-9) + 1):
        text = number_text(question.least + k * tick)
        place = max(0, min(round(k * tick / span * (cells - 1)), cells - len(text)))
        line[place : place + len(text)] = text
    drawn = Text("".join(line))
    if isinstance(question.entered, float | int):
        at = round(min(1.0, max(0.0, (question.entered - question.least) / span)) * (cells - 1))
        drawn.stylize("reverse bold", at, at + 1)
    return drawn


def _styled(text: str, style: str) -> Text:
    # A span and not the style of the whole text: of that, textual takes "red" for a colour of CSS.
    return Text.assemble((text, style))
