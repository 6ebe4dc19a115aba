"""What a desk is, as a session sees it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Protocol

import attrs

if TYPE_CHECKING:
    from ...display import Command


@attrs.frozen
class Question:
    """What is being asked. text: in words. least, most, step: of an answer. anchors: words for some values. entered: what stands there
    until it is confirmed, None for nothing."""

    text: str
    least: float
    most: float
    step: float
    anchors: tuple[tuple[float, str], ...] = ()
    entered: float | None = None


@attrs.frozen(kw_only=True)
class DeskState:
    """What there is to see. It holds nothing that tells the condition unless the study is blind to nobody.

    heading: study, participant, session; PILOT, REHEARSAL or SIMULATED in it is made to stand out. step: "trial 3 of 12". done: share of
    the steps, 0 to 1. elapsed_s: of this sitting. left_s: of this step, None where nobody knows. phase: "reading" a text to
    agree to, "waiting" for somebody to begin, "showing", "asking", "break", "paused", "over". rate_hz, missed: of the pictures. position_m,
    turned_deg: the head, (x, y, z) and (yaw, pitch, roll); None before there is one. notice: "tracking lost". condition: "" where it is
    hidden.
    """

    heading: str = ""
    step: str = ""
    done: float = 0.0
    elapsed_s: float = 0.0
    left_s: float | None = None
    phase: str = ""
    question: Question | None = None
    rate_hz: float = 0.0
    missed: int = 0
    position_m: tuple[float, float, float] | None = None
    turned_deg: tuple[float, float, float] | None = None
    notice: str = ""
    condition: str = ""


class Desk(Protocol):
    """Used as a context manager around a session. No method waits for anybody: pictures come between two calls."""

    def __enter__(self) -> Desk: ...

    def __exit__(self, *_: object) -> None: ...

    def tell(self, state: DeskState) -> None:
        """What is going on now; called a few times a second."""

    def say(self, text: str) -> None:
        """A line for the journal on the screen."""

    def commands(self) -> Sequence[Command]:
        """What the experimenter asked for since the last time: "pause", "continue", "break", "again", "skip", "stop", "agree"; "answer"
        with a number, "remark" with a text."""
