"""Entry of commands key by key, without a terminal, so that every key can be tested."""

from __future__ import annotations

import attrs

from ..scales import number_text
from ._base import ConsoleState, Question
from .console_commands import LONGEST_REMARK, Subject, checked_answer, refusal, subject_of

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
            return self._confirm(key, state)
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

    def _confirm(self, key: str, state: ConsoleState) -> Entered | None:
        name = self.mode
        confirmed = key.lower() in CONFIRMED_BY[name]
        self._back(DONE[name] if confirmed else "not done")
        return (name, None, subject_of(state)) if confirmed else None

    def _back(self, note: str) -> None:
        self.mode, self.text, self._subject = "keys", "", None
        self._say(note)

    def _say(self, note: str, loud: bool = False) -> None:
        self.note, self.loud = note, loud and bool(note)


def _answer_text(value: float | str) -> str:
    return value if isinstance(value, str) else number_text(value)
