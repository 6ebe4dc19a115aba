"""Console as a session sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol, Self

import attrs

from ...display import Command

KINDS = (AUTO, TERMINAL, BROWSER, LINES, NONE) = ("auto", "terminal", "browser", "lines", "none")


@attrs.frozen
class Question:
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

    heading: str = ""  # study, participant, session; PILOT, REHEARSAL and SIMULATED stand out
    step: str = ""  # "trial 3 of 12"
    done: float = 0.0  # share of the steps, 0 to 1
    elapsed_s: float = 0.0  # since this run of the program began
    left_s: float | None = None  # of this step; None where unknown
    seen_s: float | None = None  # of a trial that the participant ends; None for any other step
    # "reading" (consent), "waiting" (to begin), "showing", "asking", "break", "paused" or "over"
    phase: str = ""
    question: Question | None = None
    rate_hz: float = 0.0  # frames per second
    missed: int = 0  # refreshes without a new frame
    position_m: tuple[float, float, float] | None = None  # head (x, y, z); None before there is one
    angles_deg: tuple[float, float, float] | None = None  # head (yaw, pitch, roll)
    notice: str = ""  # "tracking lost"
    condition: str = ""  # "" where it is hidden


class Console(Protocol):
    """Context manager around a session. No method blocks: frames are due between two calls."""

    def __enter__(self) -> Self: ...

    def __exit__(self, *_: object) -> None: ...

    def tell(self, state: ConsoleState) -> None:
        """Show a new state; called a few times a second."""

    def say(self, text: str) -> None:
        """Add a line to the journal."""

    def commands(self) -> Sequence[Command]:
        """Return the experimenter's commands since the last call.

        "pause", "continue", "break", "again", "skip", "stop", "agree" and "decline" have no value;
        "answer" has a number, or a text for a question in words, "remark" a text.
        """


class NoConsole:
    """Console that shows nothing and sends nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def tell(self, state: ConsoleState) -> None:
        """Do nothing."""

    def say(self, text: str) -> None:
        """Do nothing."""

    def commands(self) -> Sequence[Command]:
        """Return nothing."""
        return ()
