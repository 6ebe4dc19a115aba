"""What experimenters type, checked: the same for the desk with a screen and for the one with lines."""

from __future__ import annotations

import math

from ._base import DeskState, Question

ALL = {
    "pause": "hold everything until it is continued",
    "continue": "go on, after a pause or a break",
    "break": "a break after this trial",
    "again": "ask the last question once more",
    "answer": "what the participant says: answer 3.25",
    "skip": "leave this question without an answer",
    "remark": "a line for the journal: remark the strap slipped",
    "agree": "the participant has read the text and agrees",
    "stop": "end the session; what was answered stays",
}
LONGEST_REMARK = 1000
ON_STEP = 1e-6  # of a step: 3.35 typed for steps of 0.05 is off by 1e-14 of one
About = tuple[str, str, bool]


def clock(seconds: float) -> str:
    """1:05, or 1:02:03 from an hour on; whole seconds, rounded down."""
    whole = max(0, math.floor(seconds))
    hours, minutes = whole // 3600, whole % 3600 // 60
    return f"{hours}:{minutes:02d}:{whole % 60:02d}" if hours else f"{minutes}:{whole % 60:02d}"


def number(value: float) -> str:
    """As short as it goes: 3, 3.25."""
    return f"{value:.6g}"


def span(question: Question) -> str:
    """Which answers there are: "1 to 6 in steps of 0.25"."""
    return f"{number(question.least)} to {number(question.most)} in steps of {number(question.step)}"


def checked_answer(text: str, question: Question) -> float:
    """The number typed as an answer; a comma will do for the point. Errors: ValueError, with a sentence that says what is wanted."""
    wanted = f"answers go from {span(question)}"
    try:
        value = float(text.strip().replace(",", "."))
    except ValueError:
        raise ValueError(
            f"{text.strip()!r} is no number: {wanted}" if text.strip() else f"nothing was typed: {wanted}"
        ) from None
    if not question.least <= value <= question.most:  # NaN is not either
        raise ValueError(f"{text.strip()} is not on the scale: {wanted}")
    steps = (value - question.least) / question.step
    if abs(steps - round(steps)) > ON_STEP:
        raise ValueError(f"{text.strip()} lies between two steps: {wanted}")
    return round(question.least + round(steps) * question.step, 9)


def refusal(name: str, state: DeskState) -> str:
    """Why a command has no meaning now, "" where it has one."""
    if state.phase == "over" and name != "remark":
        return "the session is over"
    without_meaning = {
        "skip": (state.question is None, "nothing is being asked now"),
        "answer": (state.question is None, "nothing is being asked now"),
        "agree": (state.phase != "reading", "there is no text to agree to now"),
        "continue": (
            state.phase not in ("paused", "break", "waiting"),
            "it is going on already: there is no pause and no break",
        ),
        "pause": (state.phase == "paused", "it is paused already"),
        "break": (state.phase == "break", "it is a break already"),
    }
    holds, why = without_meaning.get(name, (False, ""))
    return why if holds else ""


def about(state: DeskState) -> About:
    """What an answer typed now would be about. Where it has changed by the time the answer arrives, the answer is to nothing."""
    return state.step, state.question.text if state.question is not None else "", state.phase == "reading"


def bound(name: str) -> bool:
    """Whether a command is about what is on just now, and must not reach the step after it."""
    return name in ("answer", "skip", "agree")


def typed(line: str, state: DeskState) -> tuple[str, object] | None:
    """A command and its value from a line: "answer 3.25", "pause"; None for an empty line. Errors: ValueError, with a sentence."""
    name, _, rest = line.strip().partition(" ")
    name, rest = name.lower(), rest.strip()
    if not name:
        return None
    if name not in ALL:
        raise ValueError(f"{name!r} is no command: there are {', '.join(ALL)} and help")
    why = refusal(name, state)
    if why:
        raise ValueError(why)
    if name == "answer":
        assert state.question is not None
        return name, checked_answer(rest, state.question)
    if name == "remark":
        if not rest:
            raise ValueError("a remark wants words: remark the strap slipped")
        return name, rest[:LONGEST_REMARK]
    if rest:
        raise ValueError(f"{name!r} stands alone: {rest!r} behind it means nothing")
    return name, None
