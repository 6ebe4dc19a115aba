"""Commands that experimenters type, checked in the same way for every console."""

from __future__ import annotations

import math

from ..scales import range_text
from ._base import ConsoleState, Question

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
LONGEST_REMARK = 1000
ON_STEP = 1e-6  # of a step: 3.35 typed for steps of 0.05 is off by 1e-14 of one
Subject = tuple[str, str, str, bool]  # step, scale, question, whether it is the consent


def clock(seconds: float) -> str:
    """Return 1:05, or 1:02:03 from an hour on; whole seconds, rounded down."""
    whole = max(0, math.floor(seconds))
    hours, minutes = whole // 3600, whole % 3600 // 60
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"


def answers_text(question: Question) -> str:
    """Return which answers there are."""
    return "in words" if question.in_words else range_text(question)


def checked_answer(text: str, question: Question) -> float | str:
    """Return the typed answer; a comma may stand for the point of a number.

    Errors: ValueError with a sentence that says which answers there are.
    """
    if question.in_words:
        if not text.strip():
            raise ValueError("nothing was typed: this question is answered in words; skip leaves it without an answer")
        return text.strip()
    wanted = f"answers go from {range_text(question)}"
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        found = f"{text.strip()!r} is no number" if text.strip() else "nothing was typed"
        raise ValueError(f"{found}: {wanted}") from None
    if not question.least <= value <= question.most:  # refuses NaN too
        raise ValueError(f"{text.strip()} is not on the scale: {wanted}")
    steps = (value - question.least) / question.step
    if abs(steps - round(steps)) > ON_STEP:
        raise ValueError(f"{text.strip()} lies between two steps: {wanted}")
    return round(question.least + round(steps) * question.step, 9)


def refusal(name: str, state: ConsoleState) -> str:
    """Return why a command has no meaning now, "" where it has one."""
    if state.phase == "over" and name != "remark":
        return "the session is over"
    without_meaning = {
        "skip": (state.question is None, "nothing is being asked now"),
        "answer": (state.question is None, "nothing is being asked now"),
        "agree": (state.phase != "reading", "there is no text to agree to now"),
        "decline": (state.phase != "reading", "there is no text to decline now"),
        "continue": (
            state.phase not in ("paused", "break", "waiting"),
            "it is going on already: there is no pause and no break",
        ),
        "pause": (state.phase == "paused", "it is paused already"),
        "break": (state.phase == "break", "it is a break already"),
    }
    holds, why = without_meaning.get(name, (False, ""))
    return why if holds else ""


def subject_of(state: ConsoleState) -> Subject:
    """Return the subject of an answer typed now; once it has changed, the answer is void."""
    scale, text = ("", "") if state.question is None else (state.question.scale, state.question.text)
    return state.step, scale, text, state.phase == "reading"


def is_bound(name: str) -> bool:
    """Return whether a command belongs to its subject, and must not reach the step after it."""
    return name in ("answer", "skip", "agree", "decline")


def parse_line(line: str, state: ConsoleState) -> tuple[str, object] | None:
    """Parse a command and its value ("answer 3.25", "pause"); None for an empty line.

    Errors: ValueError with a sentence.
    """
    name, _, rest = line.strip().partition(" ")
    name, rest = name.lower(), rest.strip()
    if not name:
        return None
    if name not in COMMANDS:
        raise ValueError(f"{name!r} is no command: there are {', '.join(COMMANDS)} and help")
    why = refusal(name, state)
    if why:
        raise ValueError(why)
    if name == "answer":
        assert state.question is not None
        return name, checked_answer(rest, state.question)
    if name == "remark":
        if not rest:
            raise ValueError("a remark needs words: remark the strap slipped")
        return name, rest[:LONGEST_REMARK]
    if rest:
        raise ValueError(f"{name!r} takes no value: {rest!r} means nothing")
    return name, None
