"""What a session consists of, step by step: a plan and an order give the same steps every time, so going on is finding the first undone.

Each step has a key that stays: what is done is known by it, in the store and after a crash.
"""

from __future__ import annotations

import attrs

from .design import Condition, Design
from .scales import Item, Scale


@attrs.frozen
class Read:
    """Consent: a text that is agreed to, or not."""

    key: str
    text: str


@attrs.frozen
class Show:
    """A condition, for some seconds. trial: its number from 1 on, 0 for the practice. repeat: which time it is shown, from 1 on."""

    key: str
    trial: int
    condition: Condition
    seconds: float
    repeat: int = 1


@attrs.frozen
class Ask:
    """One item of a scale. phase: "before", "practice", "trial" or "after". trial: the one it is about, 0 for none. about: the key of the
    Show it is about, "" for none: what is asked must have been seen just before."""

    key: str
    scale: Scale
    item: Item
    phase: str
    trial: int = 0
    about: str = ""


@attrs.frozen
class Pause:
    """A break. seconds: at least."""

    key: str
    seconds: float


Step = Read | Show | Ask | Pause


def steps_of(design: Design, order: tuple[tuple[str, ...], ...], part: str) -> tuple[Step, ...]:
    """All steps of a session. order: names of the part's conditions, a tuple for each repeat."""
    conditions = design.part(part)
    steps: list[Step] = []
    if design.consent is not None:
        steps.append(Read("consent", design.consent.text))
    steps += [ask for scale in design.before for ask in _asks(scale, "before", "before")]
    if design.practice is not None:
        steps.append(Show("practice", 0, design.practice, design.practice_seconds))
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
    steps: list[Step] = [Show(key, trial, condition, design.seconds, repeat)]
    steps += [ask for scale in design.scales for ask in _asks(scale, key, "trial", trial)]
    if design.sickness is not None and trial % design.sickness.every == 0:
        steps += _sickness(design, key, trial)
    return steps


def _sickness(design: Design, key: str, trial: int) -> list[Step]:
    if design.sickness is None:
        return []
    return list(_asks(design.sickness.scale, key, "trial" if trial else "practice", trial))


def _asks(scale: Scale, key: str, phase: str, trial: int = 0) -> tuple[Ask, ...]:
    about = key if phase in ("trial", "practice") else ""
    return tuple(Ask(f"{key}/{scale.name}/{item.key}", scale, item, phase, trial, about) for item in scale.items)
