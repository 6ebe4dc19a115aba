"""Steps and heads in words and numbers, for the title, the desk and the plates. None of it tells a condition."""

from __future__ import annotations

import math
from collections.abc import Sequence

from ...geometry import Pose
from ..design import Ask, Pause, Read, Show, Step

READY, MENU, ASKED_BREAK, SICK, END = (
    "ready",
    "menu",
    "asked-break",
    "sick",
    "end",
)  # keys of what comes between the steps


def told(step: Step, steps: Sequence[Step]) -> str:
    """ "trial 3 of 12", and the like."""
    if isinstance(step, Pause):
        return "break"
    if isinstance(step, Read):
        return {READY: "about to begin", SICK: "the session ends", END: "over"}.get(step.key, "consent")
    if isinstance(step, Ask) and not step.about:
        return _of_questionnaire(step, steps)
    return f"trial {step.trial} of {trials(steps)}" if step.trial else "practice"


def trials(steps: Sequence[Step]) -> int:
    """How many there are, the practice apart."""
    return max((step.trial for step in steps if isinstance(step, Show)), default=0)


def _of_questionnaire(ask: Ask, steps: Sequence[Step]) -> str:
    items = ask.scale.items
    return (
        ask.scale.title if len(items) == 1 else f"{ask.scale.title}, item {items.index(ask.item) + 1} of {len(items)}"
    )


def turned_deg(pose: Pose) -> tuple[float, float, float]:
    """Yaw (to the left), pitch (up) and roll (to the left), of a head that first turns, then nods, then tilts."""
    m = pose.rotation_matrix
    angles = math.atan2(m[0][2], m[2][2]), math.asin(min(max(-m[1][2], -1.0), 1.0)), math.atan2(m[1][0], m[1][1])
    return tuple(map(math.degrees, angles))  # type: ignore[return-value]
