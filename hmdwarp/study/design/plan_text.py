"""A plan as `hmdwarp study plan` prints it: in rows of a name and its text, or as JSON data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from statistics import NormalDist
from typing import Any

import attrs

from ...report import counted, listed, pair_text
from ..scales import Scale
from ..statistics import JOD_SPREAD, people_for_sign, people_for_signed_rank, sign_power, signed_rank_power, smallest_p
from .definitions import (
    BOTH,
    FIXED,
    PAIR,
    PARTICIPANT,
    WILLIAMS,
    Condition,
    Design,
    Family,
    Part,
    every_scale,
    resolved,
)
from .orders import pair_name, presented, rows_for
from .outline import balance, least_participants, notes, session_phases

MOST_ORDERS = 40  # printed; the JSON data has them all
Rows = list[tuple[str, str]]


def head_rows(design: Design) -> Rows:
    """Describe the study, what is hidden, the order, and what surrounds the trials."""
    rows = [
        ("Study", f"{design.name}: {design.path} is valid"),
        ("Hidden", _HIDDEN.get(design.blind, "nothing: participant and experimenter see the condition")),
        ("Order", _order(design)),
    ]
    if design.practice is not None:
        settings = ", ".join(_settings(design.practice.settings))
        rows.append(("Practice", f"{design.practice_seconds:g} s first, not scored: {settings}"))
    if design.sickness is not None:
        rule = design.sickness
        often = "every trial" if rule.every == 1 else f"every {rule.every} trials"
        ends = []
        if rule.stop_at is not None:
            ends.append(f"{rule.stop_at:g} or {'more' if rule.scale.low_is_good else 'less'}")
        if rule.rise is not None:
            ends.append(f"{rule.rise:g} worse than at first")
        ending = f"ends the session at {' or at '.join(ends)}" if ends else "never ends the session"
        rows.append(("Sickness", f"{rule.scale.name} after {often}; {ending}"))
    if design.consent is not None:
        words = counted(len(design.consent.text.split()), "word")
        rows.append(("Consent", f"text version {design.consent.version}, {words}"))
    return rows


_HIDDEN = {
    BOTH: "the condition, from participant and experimenter: both see only numbers of trials",
    PARTICIPANT: "the condition, from the participant; the experimenter sees it",
}


def _order(design: Design) -> str:
    if design.order == FIXED:
        return "fixed: as in the file, the same for all participants"
    what = "pair" if design.shows == PAIR else "condition"
    again = f"; each {what} {design.repeats} times, each round in another order" if design.repeats > 1 else ""
    if design.order == WILLIAMS:
        return f"Williams design, seed {design.seed}: each session gets the order used least so far{again}"
    return f"random, seed {design.seed}: another one for each participant{again}"


def _settings(settings: Mapping[str, object]) -> list[str]:
    return [f"{name} {_value(value)}" for name, value in settings.items()]


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def _defaults(condition: Condition) -> str:
    """Name the defaults of a condition: a reference that names no warp has one."""
    values = resolved(condition.settings)
    texts = _settings({name: value for name, value in values.items() if name not in condition.settings})
    return f"; by default {', '.join(texts)}" if texts else ""


def condition_rows(part: Part) -> Rows:
    """Describe the conditions of a part, what they share last."""
    first, *others = part.conditions
    shared = {
        name: value
        for name, value in first.settings.items()
        if others and all(name in condition.settings and condition.settings[name] == value for condition in others)
    }
    rows = []
    for number, condition in enumerate(part.conditions, 1):
        own = ", ".join(_settings({name: value for name, value in condition.settings.items() if name not in shared}))
        reference = " (the hidden reference)" if condition.reference else ""
        rows.append((f"{number}  {condition.name}", (own or "as all") + _defaults(condition) + reference))
    return [*rows, ("   all", ", ".join(_settings(shared)))] if shared else rows


def session_rows(design: Design, part: Part) -> tuple[str, Rows]:
    """Describe a session of a part as a whole, and its phases."""
    session = session_phases(design, part.name)
    about = f"{'at most ' if any(phase.at_most for phase in session) else ''}about"
    whole = f"{sum(phase.steps for phase in session)} steps, {about} {_time(sum(phase.seconds for phase in session))}"
    return whole, [(phase.name, f"{_time(phase.seconds):>7}  {phase.content}") for phase in session]


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


def balance_rows(design: Design, part: Part) -> Rows:
    """Describe how the orders of a part are balanced."""
    if design.order == FIXED:
        return [("balanced", "no: there is one order")]
    found = balance(rows_for(design, part.name), presented(design, part.name))
    what = "pair" if design.shows == PAIR else "condition"
    lines = [("places", f"each {what} in each place {_times(found.places)}")]
    if found.pairs is not None:
        lines.append(("neighbours", f"each {what} right after each other one {_times(found.pairs)}"))
    if found.seams is not None:
        often = f"{_times((found.repeated,) * 2)} a condition" if found.repeated else "none"
        again = f"{often} follows itself"
        lines.append(("seams", f"between two rounds, each right after each other one {_times(found.seams)}; {again}"))
    if design.order == WILLIAMS:
        count = found.orders
        lines.append(("people", f"balanced with {count}, {2 * count}, {3 * count} .. complete sessions"))
    return lines


def _times(counts: tuple[int, int]) -> str:
    least, most = counts
    if least != most:
        return f"{least} to {most} times"
    return "once" if least == 1 else f"{least} times"


def order_rows(design: Design, part: Part) -> Rows:
    """List the orders of a part by the numbers of the conditions, MOST_ORDERS at most."""
    numbers = {condition.name: str(number) for number, condition in enumerate(part.conditions, 1)}
    numbers |= {pair_name(a, b): f"{numbers[a]}/{numbers[b]}" for a in list(numbers) for b in list(numbers)}
    return [
        (f"order {number}:", " | ".join(" ".join(numbers[name] for name in names) for names in order))
        for number, order in enumerate(rows_for(design, part.name)[:MOST_ORDERS], 1)
    ]


def scale_text(scale: Scale) -> str:
    """Describe a scale."""
    if not scale.has_answers:
        return f"{scale.title}: {', '.join(item.key for item in scale.items)}, each with its own answers"
    anchors = "; ".join(f"{value:g} = {words}" for value, words in scale.anchors.items())
    items = f" {len(scale.items)} items." if len(scale.items) > 1 else ""
    range_ = f"{scale.least:g} to {scale.most:g} in steps of {scale.step:g}"
    return f"{scale.title}: {range_}, {scale.direction}.{items} {anchors}"


def family_text(family: Family) -> str:
    """List the comparisons of a family, and say how few people can show nothing."""
    pairs = ", ".join(pair_text(comparison.baseline, comparison.better) for comparison in family.comparisons)
    count = len(family.comparisons)
    need = least_participants(count)
    best = f"{count} x {smallest_p(need):.2g} at best with {need}"
    return f"{pairs}\np below 0.05 is out of reach with fewer than {need} people ({best})"


_EFFECTS = {"sd": (0.5, 0.8, 1.2), "JOD": (0.5, 1.0, 1.5)}
_TESTS = {"sd": "exact signed-rank test", "JOD": "exact sign test"}
_ASSUMED = {
    "sd": "independent people, each with both ratings; an effect is the mean difference over the standard deviation "
    "of one person's difference, which is normal, without steps and ends of a scale",
    "JOD": "independent people, each with one choice; of an effect of 1 JOD, 75% of all choices go to the better one",
}


def power_as_json(design: Design, people: int) -> list[dict[str, Any]]:
    """Return the power of one comparison for so many people, for each size of a family."""
    unit, found = "JOD" if design.shows == PAIR else "sd", []
    for count in sorted({len(family.comparisons) for family in design.families}):
        alpha, rows = 0.05 / count, []
        for effect in _EFFECTS[unit]:
            if unit == "sd":
                power, least = signed_rank_power(people, effect, alpha), people_for_signed_rank(effect, alpha)
            else:
                share = NormalDist().cdf(effect / JOD_SPREAD)
                power, least = sign_power(people, share, alpha), people_for_sign(share, alpha)
            rows.append({"effect": effect, "power": power, "people_for_80_percent": least})
        names = [family.name for family in design.families if len(family.comparisons) == count]
        about = {"families": names, "comparisons": count, "alpha": alpha, "people": people, "effects": rows}
        found.append({**about, "unit": unit, "test": _TESTS[unit], "assumed": _ASSUMED[unit]})
    return found


def power_rows(found: Mapping[str, Any]) -> Rows:
    """Describe one entry of power_as_json."""
    strict = f" / {found['comparisons']} (Holm's strictest step)" if found["comparisons"] > 1 else ""
    rows = [
        (
            f"{row['effect']:g} {found['unit']}",
            f"{row['power']:.0%} with {found['people']} people, 80% with {row['people_for_80_percent']}",
        )
        for row in found["effects"]
    ]
    test = f"{found['test']}, p below 0.05{strict}: {listed(found['families'])}"
    return [("test", test), *rows, ("assumed", found["assumed"])]


def design_as_json(design: Design) -> dict[str, object]:
    """Return the whole plan; times in seconds, orders as lists of names for each repeat."""
    rule = design.sickness
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
        "practice": None
        if design.practice is None
        else {"seconds": design.practice_seconds, "settings": dict(design.practice.settings)},
        "breaks": attrs.asdict(design.breaks),
        "sickness": None if rule is None else attrs.asdict(rule, recurse=False) | {"scale": rule.scale.name},
        "consent_version": None if design.consent is None else design.consent.version,
        **{
            key: None if getattr(design, key) is None else attrs.asdict(getattr(design, key))
            for key in ("instructions", "ready", "thanks")
        },
        "scales": [
            attrs.asdict(scale) | {"anchors": {f"{value:g}": words for value, words in scale.anchors.items()}}
            for scale in every_scale(design)
        ],
        "asked": {key: [scale.name for scale in getattr(design, key)] for key in ("scales", "before", "after")},
        "parts": [_part_json(design, part) for part in design.parts],
        "families": [attrs.asdict(family) for family in design.families],
        "notes": list(notes(design)),
    }


def _part_json(design: Design, part: Part) -> dict[str, object]:
    rows, session = rows_for(design, part.name), session_phases(design, part.name)
    return {
        "name": part.name,
        "conditions": [attrs.asdict(condition) for condition in part.conditions],
        "session": [
            {"told" if name == "content" else name: value for name, value in attrs.asdict(phase).items()}
            for phase in session
        ],
        "session_seconds": math.fsum(phase.seconds for phase in session),
        "orders": rows,
        "balance": attrs.asdict(balance(rows, presented(design, part.name))),
    }
