"""A plan as one JSON object: what `hmdwarp study plan --json` prints."""

from __future__ import annotations

import math

import attrs

from ..scales import Scale
from .definitions import Design, Page, Part, every_scale
from .orders import presented, rows_for
from .outline import balance, notes, session_phases


def design_as_json(design: Design) -> dict[str, object]:
    """Return the whole plan; times in seconds, orders as lists of names for each repeat."""
    return {
        "name": design.name,
        "title": design.title,
        "path": design.path,
        "seed": design.seed,
        "blind": design.blind,
        "order": design.order,
        "shows": design.shows,
        "repeats": design.repeats,
        "trial_seconds": design.seconds,
        "trial_until_done": design.until_done,
        "task": None if design.task is None else attrs.asdict(design.task),
        "practice": None
        if design.practice is None
        else {"seconds": design.practice_seconds, "settings": dict(design.practice.settings)},
        "breaks": attrs.asdict(design.breaks),
        "sickness": _sickness_json(design),
        "consent_version": None if design.consent is None else design.consent.version,
        **{key: _page_json(getattr(design, key)) for key in ("instructions", "ready", "thanks")},
        "scales": [_scale_json(scale) for scale in every_scale(design)],
        "asked": {key: [scale.name for scale in getattr(design, key)] for key in ("scales", "before", "after")},
        "parts": [_part_json(design, part) for part in design.parts],
        "families": [attrs.asdict(family) for family in design.families],
        "notes": list(notes(design)),
    }


def _page_json(page: Page | None) -> dict[str, object] | None:
    return None if page is None else attrs.asdict(page)


def _sickness_json(design: Design) -> dict[str, object] | None:
    asked = design.sickness
    return (
        None
        if asked is None
        else {"scale": asked.scale.name, "every": asked.every, "stop_at": asked.stop_at, "rise": asked.rise}
    )


def _scale_json(scale: Scale) -> dict[str, object]:
    return attrs.asdict(scale) | {"anchors": {f"{value:g}": words for value, words in scale.anchors.items()}}


def _part_json(design: Design, part: Part) -> dict[str, object]:
    rows, session = rows_for(design, part.name), session_phases(design, part.name)
    return {
        "name": part.name,
        "conditions": [attrs.asdict(one) for one in part.conditions],
        "session": [
            {
                "name": one.name,
                "told": one.content,
                "steps": one.steps,
                "seconds": one.seconds,
                "at_most": one.at_most,
            }
            for one in session
        ],
        "session_seconds": math.fsum(one.seconds for one in session),
        "orders": rows,
        "balance": attrs.asdict(balance(rows, presented(design, part.name))) if rows else None,
    }
