"""Signature of a plan: the settings that must not change between sessions of one part.

With equal signatures ratings are comparable, whatever else of the file was edited meanwhile.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..design import ONE, Condition, Design
from ..scales import Item, Scale


def plan_signature(design: Design, part: str) -> dict[str, Any]:
    """Return the signature as JSON data.

    Titles, comments, breaks, the consent's text, families and other parts are not in it: they may
    change. So may the folder of the file, together with the files beside it.
    """
    folder = f"{Path(design.path).parent.absolute()}{os.sep}"
    rule = design.sickness
    return {
        "conditions": [_condition(condition, folder) for condition in design.part(part).conditions],
        "seconds": ["until done", float(design.seconds)] if design.until_done else float(design.seconds),
        "repeats": design.repeats,
        "order": design.order,
        "seed": design.seed,
        "scales": [_scale(scale) for scale in design.scales],
        "practice": None
        if design.practice is None
        else [_condition(design.practice, folder), float(design.practice_seconds)],
        "sickness": (
            None
            if rule is None
            else {"scale": _scale(rule.scale), "every": rule.every, "stop_at": rule.stop_at, "rise": rule.rise}
        ),
        "before": [_scale(scale) for scale in design.before],
        "after": [_scale(scale) for scale in design.after],
        **_shows(design),
    }


def _shows(design: Design) -> dict[str, Any]:
    """Return what a trial shows; nothing for one condition, as older sessions have it."""
    return {} if design.shows == ONE else {"shows": design.shows}


def _condition(condition: Condition, folder: str) -> dict[str, Any]:
    settings = {
        name: value.removeprefix(folder) if isinstance(value, str) else value
        for name, value in sorted(condition.settings.items())
    }
    return {"name": condition.name, "settings": settings, "reference": condition.reference}


def _scale(scale: Scale) -> dict[str, Any]:
    """Return the questions in their words, and the possible answers."""
    return {
        "name": scale.name,
        "asked": [scale.prompt, *([item.key, item.text, *_own(item)] for item in scale.items)],
        "range": [scale.least, scale.most, scale.step],
        "anchors": {f"{value:g}": words for value, words in sorted(scale.anchors.items())},
        "low_is_good": scale.low_is_good,
    }


def _own(item: Item) -> list[Any]:
    """Return the answers of a question that has its own, or its own words for some."""
    if item.anchors:
        return [{f"{value:g}": words for value, words in item.anchors.items()}]
    return [item.answer, list(item.choices), item.least, item.most, item.step] if item.answer else []


def signature_changes(before: Mapping[str, Any], now: Mapping[str, Any]) -> list[str]:
    """Describe what differs between two signatures, both decoded from JSON."""
    changed = [key for key in {**before, **now} if before.get(key) != now.get(key)]
    return [_conditions(before[key], now[key]) if key == "conditions" else key for key in changed]


def _conditions(before: list[dict[str, Any]], now: list[dict[str, Any]]) -> str:
    was, is_ = ({condition["name"]: condition for condition in side} for side in (before, now))
    words = [f"'{name}' is new" for name in is_ if name not in was] + [
        f"'{name}' is gone" for name in was if name not in is_
    ]
    words += [f"'{name}' changed" for name in is_ if name in was and was[name] != is_[name]]
    return f"conditions ({', '.join(words) or 'in another order'})"
