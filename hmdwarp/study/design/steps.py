"""Steps of a session, made from a plan and an order.

The same plan and order give the same steps every time, and each step has a fixed key under which
the store keeps it. Resuming a session, after a crash too, means finding the first undone step.
"""

from __future__ import annotations

import attrs

from ..scales import Item, Scale
from .definitions import ONE, PAIR, REFERENCE_FIRST, Condition, Design, Page, Part, Task
from .orders import pair_of

# Names of a trial's showings, by what it shows; the questions are about the last one.
TURNS = {ONE: ("",), PAIR: ("first", "second"), REFERENCE_FIRST: ("reference", "second")}


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
    turn: str = ""  # which showing of its trial: as TURNS has it
    after: str = ""  # key of the Show that must have been seen just before; "" for none


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
        steps += _sickness(design, "practice", 0, "practice")
    shown = [(name, repeat) for repeat, names in enumerate(order, 1) for name in names]
    for trial, (name, repeat) in enumerate(shown, 1):
        steps += _trial(
            design, trial, [conditions.condition(shown_name) for shown_name in _shown(design, conditions, name)], repeat
        )
        if design.breaks.every and trial % design.breaks.every == 0 and trial < len(shown):
            steps.append(Pause(f"break/{trial // design.breaks.every}", design.breaks.seconds))
    steps += [ask for scale in design.after for ask in _asks(scale, "after", "after")]
    return tuple(steps)


def _shown(design: Design, part: Part, name: str) -> tuple[str, ...]:
    """Return the names of the conditions that a trial shows, in order. name: of it in the order."""
    if design.shows == PAIR:
        return pair_of(name)
    return (
        *(condition.name for condition in part.conditions if condition.reference and design.shows == REFERENCE_FIRST),
        name,
    )


def _trial(design: Design, trial: int, conditions: list[Condition], repeat: int) -> list[Step]:
    key = f"trial/{trial}"
    block = 1 + (trial - 1) // design.breaks.every if design.breaks.every else 1
    task = design.task
    if task is not None and task.conditions and conditions[-1].name not in task.conditions:
        task = None
    shows: list[Show] = []
    for condition, turn in zip(conditions, TURNS[design.shows], strict=True):
        after = shows[-1].key if shows else ""
        at = f"{key}/{turn}" if turn else key
        shows.append(Show(at, trial, condition, design.seconds, repeat, block, design.until_done, task, turn, after))
    steps: list[Step] = [*shows]
    about = shows[-1].key
    steps += [ask for scale in design.scales for ask in _asks(scale, key, "trial", trial, about)]
    if design.sickness is not None and trial % design.sickness.every == 0:
        steps += _sickness(design, key, trial, about)
    return steps


def _sickness(design: Design, key: str, trial: int, about: str) -> tuple[Ask, ...]:
    if design.sickness is None:
        return ()
    return _asks(design.sickness.scale, key, "trial" if trial else "practice", trial, about)


def _asks(scale: Scale, key: str, phase: str, trial: int = 0, about: str = "") -> tuple[Ask, ...]:
    return tuple(Ask(f"{key}/{scale.name}/{item.key}", scale, item, phase, trial, about) for item in scale.items)
