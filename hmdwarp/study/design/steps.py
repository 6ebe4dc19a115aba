"""Steps of a session, made from a plan and an order.

The same plan and order give the same steps every time, and each step has a fixed key under which
the store keeps it. Resuming a session, after a crash too, means finding the first undone step.
"""

from __future__ import annotations

import attrs

from ..scales import Item, Scale
from .definitions import Condition, Design, Page, Task


@attrs.frozen
class Read:
    """Consent: a text that the participant agrees to or refuses."""

    key: str
    text: str


@attrs.frozen
class PageStep:
    """Page that the participant reads or looks at."""

    key: str
    page: Page


@attrs.frozen
class Show:
    """One presentation of a condition."""

    key: str
    trial: int  # from 1 on; 0 for the practice
    condition: Condition
    seconds: float  # at most, where it is shown until the participant is done
    repeat: int = 1  # from 1 on
    block: int = 1  # of trials between two planned breaks, from 1 on; 0 for the practice
    until_done: bool = False  # whether the participant ends it; with a task the last target does
    task: Task | None = None


@attrs.frozen
class Ask:
    """One item of a scale."""

    key: str
    scale: Scale
    item: Item
    phase: str  # "before", "practice", "trial" or "after"
    trial: int = 0  # the trial it is about; 0 for none
    about: str = ""  # key of the Show that must have been seen just before; "" for none


@attrs.frozen
class Pause:
    """A break."""

    key: str
    seconds: float  # at least


Step = Read | PageStep | Show | Ask | Pause


def steps_of(design: Design, order: tuple[tuple[str, ...], ...], part: str) -> tuple[Step, ...]:
    """Return all steps of a session.

    order: names of the part's conditions, one tuple per repeat.
    """
    conditions = design.part(part)
    steps: list[Step] = []
    if design.consent is not None:
        steps.append(Read("consent", design.consent.text))
    steps += [ask for scale in design.before for ask in _asks(scale, "before", "before")]
    if design.instructions is not None:
        steps.append(PageStep("instructions", design.instructions))
    if design.practice is not None:
        steps.append(Show("practice", 0, design.practice, design.practice_seconds, block=0, task=design.task))
        steps += _sickness(design, "practice", 0)
    shown = [(name, repeat) for repeat, names in enumerate(order, 1) for name in names]
    for trial, (name, repeat) in enumerate(shown, 1):
        steps += _trial(design, trial, conditions.condition(name), repeat)
        if design.breaks.every and trial % design.breaks.every == 0 and trial < len(shown):
            steps.append(Pause(f"break/{trial // design.breaks.every}", design.breaks.seconds))
    steps += [ask for scale in design.after for ask in _asks(scale, "after", "after")]
    return tuple(steps)


def _trial(design: Design, trial: int, condition: Condition, repeat: int) -> list[Step]:
    key = f"trial/{trial}"
    block = 1 + (trial - 1) // design.breaks.every if design.breaks.every else 1
    task = design.task
    if task is not None and task.conditions and condition.name not in task.conditions:
        task = None
    steps: list[Step] = [Show(key, trial, condition, design.seconds, repeat, block, design.until_done, task)]
    steps += [ask for scale in design.scales for ask in _asks(scale, key, "trial", trial)]
    if design.sickness is not None and trial % design.sickness.every == 0:
        steps += _sickness(design, key, trial)
    return steps


def _sickness(design: Design, key: str, trial: int) -> tuple[Ask, ...]:
    if design.sickness is None:
        return ()
    return _asks(design.sickness.scale, key, "trial" if trial else "practice", trial)


def _asks(scale: Scale, key: str, phase: str, trial: int = 0) -> tuple[Ask, ...]:
    about = key if phase in ("trial", "practice") else ""
    return tuple(Ask(f"{key}/{scale.name}/{item.key}", scale, item, phase, trial, about) for item in scale.items)
