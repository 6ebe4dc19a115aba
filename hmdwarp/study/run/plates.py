"""What the participant reads between the steps, in kind and short words. None of it tells a condition."""

from __future__ import annotations

from ..asking import Card, Hints, card, trial_card
from ..design import Pause, Show, Step
from ..store import COMPLETE, SICK, STOPPED
from .telling import told, trials

_FAREWELL = {
    COMPLETE: ("Thank you", "That was all. You may take off the headset."),
    STOPPED: ("Thank you", "The session has ended. What you answered is kept."),
    SICK: ("Thank you", "The session has ended. Take your time, have some water, and tell us how you feel."),
}


def ready(next_step: Step, steps: tuple[Step, ...], resumed: bool, hints: Hints) -> Card:
    """Before anything else, so that nothing begins before somebody sits right."""
    goes_on = (
        f"We go on with {'a break' if isinstance(next_step, Pause) else told(next_step, steps)}. " if resumed else ""
    )
    text = f"{goes_on}Sit comfortably. {hints.menu} opens a menu at any time: to have a break, or to stop without a reason."
    return card("Ready?", text, f"{hints.confirm}: begin")


def number_of(step: Show, steps: tuple[Step, ...]) -> Card:
    """Before a trial."""
    return trial_card(step.trial, trials(steps))


def sick(asks_after: bool, hints: Hints) -> Card:
    """At the stop rule, in place of the next trial."""
    rest = (
        "A few questions are left, if you like; each may be left out." if asks_after else "There is nothing more to do."
    )
    keys = f"{hints.confirm}: go on · {hints.menu}: menu"
    return card("We stop here", f"You do not feel well enough to go on, so this is the last of it. {rest}", keys)


def farewell(status: str) -> Card:
    """At the end."""
    return card(*_FAREWELL[status])
