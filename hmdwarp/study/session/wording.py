"""Names of steps, and the panels between them; none of it tells a condition."""

from __future__ import annotations

import math
from collections.abc import Sequence

import attrs

from ...geometry import Pose
from ...poses import Origin, PoseSample
from ...scenes import scenes
from ..design import Ask, Condition, Page, PageStep, Pause, Read, Show, Step
from ..dialogs.dialog_panels import InputHints, MessagePanel, message_panel, trial_panel
from ..store import COMPLETE, DECLINED, SICK, STOPPED, UNCONSENTED

# Below both, a trial counts as one in which the head hardly moved. A head that is held still sways
# by some 2 degrees and 2 cm; one that looks around turns by tens of degrees within seconds. A warp
# has next to nothing to correct below these, whatever the latency.
STILL_DEG, STILL_M = 5.0, 0.05


@attrs.define
class HeadRange:
    """Largest distances of a head from where it was first."""

    turn_deg: float = 0.0
    shift_m: float = 0.0
    _first: Pose | None = None

    def add(self, head: PoseSample) -> None:
        """Take a head; one held because tracking was lost is no motion."""
        if head.origin is Origin.HELD:
            return
        pose = head.pose
        if self._first is None:
            self._first = pose
            return
        near = abs(sum(a * b for a, b in zip(pose.unit_quaternion, self._first.unit_quaternion, strict=True)))
        self.turn_deg = max(self.turn_deg, math.degrees(2 * math.acos(min(near, 1.0))))
        self.shift_m = max(self.shift_m, math.dist(pose.position_m, self._first.position_m))

    @property
    def is_still(self) -> bool:
        return self.turn_deg < STILL_DEG and self.shift_m < STILL_M

    def figures(self) -> dict[str, float | bool | None]:
        """Return the figures of study/actual.py; None throughout where no head was seen."""
        if self._first is None:
            return {"head_turn_deg": None, "head_shift_m": None, "head_still": None}
        return {"head_turn_deg": self.turn_deg, "head_shift_m": self.shift_m, "head_still": self.is_still}


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
        names = {READY: "about to begin", STOP_RULE: "the session ends", END: "session finished"}
        return names.get(step.key, "consent")
    if isinstance(step, Ask) and not step.about:
        items, title = step.scale.items, step.scale.title
        return title if len(items) == 1 else f"{title}, item {items.index(step.item) + 1} of {len(items)}"
    turn = f", {step.turn}" if isinstance(step, Show) and step.turn else ""
    return f"trial {step.trial} of {_trials(steps)}{turn}" if step.trial else "practice"


def ready_panel(
    next_step: Step, steps: Sequence[Step], resumed: bool, hints: InputHints, own: Page | None = None
) -> MessagePanel:
    """Make the panel before the first step, and before the first trial, of a run of the program.

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


def scene_reacts(condition: Condition) -> bool:
    """Return whether the scene of a trial reacts to what people do."""
    name = condition.settings.get("scene")
    return name in scenes.names() and scenes.get(str(name)).reacts is not None


def number_panel(step: Show, steps: Sequence[Step], hints: InputHints) -> MessagePanel:
    """Make the panel before a trial; it says what to do in one, or how to end it."""
    reacts = scene_reacts(step.condition)
    confirm = (reacts and hints.done) or hints.confirm
    hint = f"Look around as long as you like. {confirm}: done" if step.until_done else ""
    return trial_panel(step.trial, _trials(steps), f"{hint}\n{hints.act if reacts else ''}".strip(), step.turn)


def sick_panel(asks_after: bool, hints: InputHints) -> MessagePanel:
    """Make the panel that the stop rule shows in place of the next trial."""
    left = "A few questions are left, if you like; each may be left out."
    text = "You do not feel well enough to go on, so this is the last of it. "
    text += left if asks_after else "There is nothing more to do."
    return message_panel("We stop here", text, f"{hints.confirm}: go on · {hints.menu}: menu")


def farewell_panel(status: str, own: Page | None, hints: InputHints) -> MessagePanel:
    """Make the last panel. own: the plan's words or picture in place of ours."""
    return message_panel(*_FAREWELL[status]) if own is None else page_panel(own, f"{hints.confirm}: close", own.text)


def page_panel(page: Page, hint: str, text: str) -> MessagePanel:
    """Make the panel of a page without buttons."""
    return attrs.evolve(message_panel(page.title, text, hint), picture=page.picture)


def _trials(steps: Sequence[Step]) -> int:
    """Count the trials, without the practice."""
    return max((step.trial for step in steps if isinstance(step, Show)), default=0)
