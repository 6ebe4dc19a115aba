"""What the experimenter is typing, key by key: no terminal here, so that every key can be tried without one."""

from __future__ import annotations

import attrs

from ._base import DeskState, Question
from .words import LONGEST_REMARK, About, about, checked_answer, number, refusal

KEYS = {
    "p": "pause", "c": "continue", "b": "break", "r": "again", "a": "answer", "k": "skip", "m": "remark", "g": "agree", "s": "stop",
    "?": "help",
}  # fmt: skip
LONGEST_ANSWER = 12
NOTED_S = 10.0  # how long what came of a key stays: after that it seems to be about what is on now
# What a stray key must not do is asked about first. The same key again confirms a consent or a question left out, but not an end.
SURE = {
    "stop": "End the session now? Everything answered so far is kept. y ends it, any other key does not",
    "skip": "Leave this question without an answer? y or k leaves it, any other key does not",
    "agree": "Does the participant agree to the text? y or g: yes, any other key: not yet",
}
AGAIN = {"stop": "y", "skip": "yk", "agree": "yg"}
DONE = {
    "pause": "pause asked for", "continue": "going on", "break": "break asked for", "again": "the last question is asked once more",
    "skip": "left without an answer", "agree": "agreed", "stop": "the end is asked for", "remark": "the remark is in the journal",
}  # fmt: skip
Asked = tuple[str, object, About]


@attrs.define
class Entry:
    """mode: "keys", "answer", "sure" (of an answer), "remark", "help", or one of SURE. text: typed so far. note: what came of the last key.
    loud: whether the note is a refusal."""

    mode: str = "keys"
    text: str = ""
    note: str = ""
    loud: bool = False
    _was: About | None = None
    _noted: tuple[str, float] = ("", 0.0)  # the note, and when it was first there

    def key(self, key: str, state: DeskState) -> Asked | None:
        """A key: one character, or "enter", "escape", "backspace", "clear". What is asked for, once that is complete: a command, its value,
        and what it is about."""
        self.follow(state)
        if self.mode == "keys":
            return self._first(key, state)
        if key == "escape":
            return self._back("")
        if self.mode == "help":
            return self._back("") if key in ("enter", "?") else self._first(key, state)
        if self.mode in SURE:
            return self._sure(key, state)
        if self.mode == "sure" and key == "y":
            key = "enter"
        return self._send(state) if key == "enter" else self._edit(key)

    def paste(self, text: str, state: DeskState) -> None:
        """Text from the clipboard, into a line that is open; never a row of keys. State as of now."""
        self.follow(state)
        if self.mode in ("answer", "sure", "remark"):
            for character in " ".join(text.split()):
                self._edit(character)
        else:
            self._say("pasted text goes into an open line only: a for an answer, m for a remark", loud=True)

    def follow(self, state: DeskState) -> None:
        """The state may have moved on: an answer half typed is not one to the next question."""
        bound_to_it = self.mode in ("answer", "sure", "skip", "agree")
        if bound_to_it and self._was != about(state):
            was = self.mode
            self._back("")
            self._say(
                "that question is over: what was typed is dropped" if was in ("answer", "sure") else "that is over",
                loud=True,
            )
        elif self.mode == "stop" and state.phase == "over":
            self._back("")
        self._fade(state)

    def _fade(self, state: DeskState) -> None:
        if self.note != self._noted[0]:
            self._noted = (self.note, state.elapsed_s)
        elif self.mode == "keys" and state.elapsed_s - self._noted[1] >= NOTED_S:
            self._say("")

    def prompt(self, question: Question | None) -> str:
        """What stands before the text. question: as asked now."""
        if self.mode == "sure" and question is not None:
            return f"{number(checked_answer(self.text, question))}? Enter again or y sends it >"
        return {"answer": "answer >", "remark": "remark >"}.get(self.mode, SURE.get(self.mode, ""))

    def _first(self, key: str, state: DeskState) -> Asked | None:
        self.mode, self.text = "keys", ""
        if state.question is not None and (key.isdigit() or key in ("-", ".", ",")):
            self._open("answer", state)
            return self._edit(key)
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

    def _begin(self, name: str, state: DeskState) -> Asked | None:
        why = "" if name == "help" else refusal(name, state)
        if why:
            self._say(why, loud=True)
        elif name in ("answer", "remark", "help") or name in SURE:
            self._open(name, state)
        else:
            self._say(DONE[name])
            return name, None, about(state)
        return None

    def _open(self, mode: str, state: DeskState) -> None:
        self.mode, self.text, self._was = mode, "", about(state)
        self._say("")

    def _edit(self, key: str) -> None:
        if self.mode == "sure":
            self.mode = "answer"
        if key == "backspace":
            self.text = self.text[:-1]
        elif key == "clear":
            self.text = ""
        elif len(key) == 1 and key.isprintable():
            most = LONGEST_REMARK if self.mode == "remark" else LONGEST_ANSWER
            self.text = (self.text + key)[:most]
            self._say("" if len(self.text) < most else "the line is full", loud=True)

    def _send(self, state: DeskState) -> Asked | None:
        if self.mode == "remark":
            text = self.text.strip()
            self._back(DONE["remark"] if text else "")
            return ("remark", text, about(state)) if text else None
        if state.question is None:  # follow() has seen to it: a line open for an answer is open for a question
            return self._back("")
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
        self._back(f"{number(value)} is the answer")
        return "answer", value, about(state)

    def _sure(self, key: str, state: DeskState) -> Asked | None:
        name = self.mode
        if key.lower() not in AGAIN[name]:
            return self._back("not done")
        self._back(DONE[name])
        return name, None, about(state)

    def _back(self, note: str) -> None:
        self.mode, self.text, self._was = "keys", "", None
        self._say(note)

    def _say(self, note: str, loud: bool = False) -> None:
        self.note, self.loud = note, loud and bool(note)
