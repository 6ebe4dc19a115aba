"""Names of steps, and the panels between them; none of it tells a condition."""

from __future__ import annotations

from collections.abc import Sequence

import attrs

from ...report import counted
from ..design import Ask, Page, PageStep, Pause, Read, Show, Step
from ..dialogs import InputHints, MessagePanel, message_panel, trial_panel
from ..store import COMPLETE, DECLINED, SICK, STOPPED, UNCONSENTED
from .task_score import HeadRange

# Keys of what comes between the steps.
READY, MENU, REQUESTED_BREAK, STOP_RULE, END = ("ready", "menu", "asked-break", "sick", "end")
_NO_PART = ("Thank you", "You are not taking part. Nothing was asked or shown.")
_FAREWELL = {
    COMPLETE: ("Thank you", "That was all. You may take off the headset."),
    STOPPED: ("Thank you", "The session has ended. What you answered is kept."),
    DECLINED: _NO_PART,
    UNCONSENTED: _NO_PART,
    SICK: ("Thank you", "The session has ended. Take your time, have some water, and tell us how you feel."),
}


def step_name(step: Step, steps: Sequence[Step]) -> str:
    """Return "trial 3 of 12", and the like."""
    if isinstance(step, Pause):
        return "break"
    if isinstance(step, PageStep):
        return "instructions"
    if isinstance(step, Read):
        return {READY: "about to begin", STOP_RULE: "the session ends", END: "session finished"}.get(
            step.key, "consent"
        )
    if isinstance(step, Ask) and not step.about:
        items, title = step.scale.items, step.scale.title
        return title if len(items) == 1 else f"{title}, item {items.index(step.item) + 1} of {len(items)}"
    turn = f", {step.turn}" if isinstance(step, Show) and step.turn else ""
    return f"trial {step.trial} of {_trials(steps)}{turn}" if step.trial else "practice"


def ready_panel(
    next_step: Step, steps: Sequence[Step], resumed: bool, hints: InputHints, own: Page | None = None
) -> MessagePanel:
    """Make the panel before the first step and the first trial of a run of the program.

    Nothing begins before the participant sits right, and no trial before they know how to look.
    own: the plan's words or picture in place of ours.
    """
    next_name = "a break" if isinstance(next_step, Pause) else step_name(next_step, steps)
    resumes = f"We go on with {next_name}. " if resumed else ""
    look = f"{hints.look} " if isinstance(next_step, Show) else ""
    begin = f"{hints.confirm}: begin"
    if own is not None:
        keys = f"{look}{hints.menu}: menu, break, stop\n{begin}"
        return page_panel(own, keys, f"{resumes}{own.text}")
    menu = f"{hints.menu} opens a menu at any time: to have a break, or to stop without a reason."
    return message_panel("Ready?", f"{resumes}Sit comfortably. {look}{menu}", begin)


def still_text(head: HeadRange) -> str:
    """Return what the experimenter should know of a trial in which the head hardly moved."""
    moved = f"{head.turn_deg:.1f} degrees, {head.shift_m * 100:.1f} cm"
    return f"the head hardly moved ({moved}): what was rated is almost a still picture"


def number_panel(
    step: Show, steps: Sequence[Step], hints: InputHints, found: tuple[int, int] | None = None
) -> MessagePanel:
    """Make the panel before a trial; it says what to do in one, or how to end it.

    found: targets found in the trial before, and all of them.
    """
    before = "" if found is None else f"{found[0]} of {found[1]} found.\n"
    if step.task is not None:
        balls = counted(step.task.count, "pink ball")
        hint = f"{before}Find {balls}: bring one to the middle of your view. {hints.confirm}: select"
    else:
        hint = before + (f"Look around as long as you like. {hints.confirm}: done" if step.until_done else "")
    return trial_panel(step.trial, _trials(steps), hint.rstrip(), step.turn)


def sick_panel(asks_after: bool, hints: InputHints) -> MessagePanel:
    """Make the panel that the stop rule shows in place of the next trial."""
    rest = (
        "A few questions are left, if you like; each may be left out." if asks_after else "There is nothing more to do."
    )
    keys = f"{hints.confirm}: go on · {hints.menu}: menu"
    return message_panel(
        "We stop here", f"You do not feel well enough to go on, so this is the last of it. {rest}", keys
    )


def farewell_panel(status: str, own: Page | None, hints: InputHints) -> MessagePanel:
    """Make the last panel. own: the plan's words or picture in place of ours."""
    if own is not None:
        return page_panel(own, f"{hints.confirm}: close", own.text)
    return message_panel(*_FAREWELL[status])


def page_panel(page: Page, hint: str, text: str) -> MessagePanel:
    """Make the panel of a page without buttons."""
    return attrs.evolve(message_panel(page.title, text, hint), picture=page.picture)


def _trials(steps: Sequence[Step]) -> int:
    """Count the trials, without the practice."""
    return max((step.trial for step in steps if isinstance(step, Show)), default=0)
