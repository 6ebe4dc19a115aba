"""What a plan comes to: how long a session takes, how its orders are balanced, and what to think of before anybody is invited."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence

import attrs

from ..scales import QUESTIONNAIRE, Scale
from .nouns import FIXED, RANDOM, WILLIAMS, Design, Part
from .orders import Order
from .steps import Ask, Pause, Read, Show, Step, steps_of

# Guesses for a plan, in seconds: an answer given by keys after a look at the scale, an item of a list, a word of a text that is read.
ANSWER_S, ITEM_S, WORD_S = 6.0, 4.0, 0.3
ALPHA = 0.05


@attrs.frozen
class Stretch:
    """Part of a session. steps: how many of the plan's. seconds: as expected."""

    name: str
    told: str
    steps: int
    seconds: float


@attrs.frozen
class Balance:
    """Over all orders: (fewest, most) times that a condition is in a place of its repeat, that an ordered pair of different conditions
    stands side by side within a repeat, and that one does across two repeats; None where there is no such place."""

    orders: int
    places: tuple[int, int]
    pairs: tuple[int, int] | None
    seams: tuple[int, int] | None
    repeated: int  # how often a condition follows itself across two repeats


def stretches(design: Design, part: str) -> tuple[Stretch, ...]:
    """A session of that part, from beginning to end."""
    names = tuple(one.name for one in design.part(part).conditions)
    steps = steps_of(design, (names,) * design.repeats, part)
    trials = len(names) * design.repeats
    asked = [scale.name for scale in design.scales]
    every = design.sickness.every if design.sickness is not None else 0
    sick = (
        []
        if design.sickness is None
        else [f"{design.sickness.scale.name}{'' if every == 1 else f' after every {every}'}"]
    )
    told = {
        "consent": "a text to read and to agree to",
        "before": ", ".join(f"{scale.name} ({len(scale.items)} items)" for scale in design.before),
        "practice": f"{design.practice_seconds:g} s, not scored",
        "trials": f"{trials} of {design.seconds:g} s, each rated: {', '.join(asked + sick)}",
        "breaks": f"{design.breaks.seconds:g} s at least, after every {design.breaks.every} trials",
        "after": ", ".join(f"{scale.name} ({len(scale.items)} items)" for scale in design.after),
    }
    found: dict[str, list[Step]] = {name: [] for name in told}
    for step in steps:
        found[_stretch(step)].append(step)
    return tuple(Stretch(name, told[name], len(of), sum(map(expected_s, of))) for name, of in found.items() if of)


def _stretch(step: Step) -> str:
    match step:
        case Read():
            return "consent"
        case Pause():
            return "breaks"
        case Ask(phase="before" | "after" | "practice" as phase):
            return phase
        case Show(trial=0):
            return "practice"
        case _:
            return "trials"


def expected_s(step: Step) -> float:
    """How long a step takes, roughly."""
    match step:
        case Read(text=text):
            return max(10.0, WORD_S * len(text.split()))
        case Show(seconds=seconds) | Pause(seconds=seconds):
            return seconds
        case Ask(scale=scale):
            return ITEM_S if scale.kind == QUESTIONNAIRE else ANSWER_S


def balance(orders: Sequence[Order], part: Part) -> Balance:
    """Of these orders of the part."""
    names = [one.name for one in part.conditions]
    rows = [row for order in orders for row in order]
    places = Counter((place, name) for row in rows for place, name in enumerate(row))
    pairs = Counter(pair for row in rows for pair in zip(row, row[1:], strict=False))
    seams = Counter((one[-1], other[0]) for order in orders for one, other in zip(order, order[1:], strict=False))
    unequal = [(a, b) for a in names for b in names if a != b]
    return Balance(
        len(orders),
        _range([places[place, name] for place in range(len(names)) for name in names]),
        _range([pairs[pair] for pair in unequal]) if unequal else None,
        _range([seams[pair] for pair in unequal]) if unequal and seams else None,
        sum(count for (a, b), count in seams.items() if a == b),
    )


def _range(counts: Sequence[int]) -> tuple[int, int]:
    return min(counts), max(counts)


def least_p(participants: int) -> float:
    """The smallest two-sided p that an exact Wilcoxon test of so many pairs can give: all differ in one direction."""
    return min(1.0, 2.0 / 2.0**participants)


def least_participants(comparisons: int) -> int:
    """With fewer, no comparison of a family of so many can fall below ALPHA after Holm's correction, whatever the answers are."""
    return math.ceil(math.log2(2 * comparisons / ALPHA))


def notes(design: Design) -> tuple[str, ...]:
    """What to think of before the study begins. None of it is an error."""
    return (
        *_of_order(design),
        *(note for part in design.parts for note in _of_part(design, part)),
        *_of_people(design),
    )


def _of_order(design: Design) -> list[str]:
    out = []
    if design.order == FIXED:
        out.append(
            "the order is the same for everybody: what comes late may be rated by habit or fatigue; order williams balances that"
        )
    elif design.order == RANDOM:
        out.append(
            "random orders are balanced only on average; order williams is balanced exactly, with few participants"
        )
    for part in design.parts:
        count = len(part.conditions)
        if design.order == WILLIAMS and count % 2:
            out.append(
                f"part {part.name}: {count} conditions, an odd number, need {2 * count} orders; {count + 1} would need {count + 1}"
            )
    return out


def _of_part(design: Design, part: Part) -> list[str]:
    out = []
    reference = next((one for one in part.conditions if one.reference), None)
    if reference is None:
        out.append(
            f"part {part.name}: no condition is a hidden reference (reference = true): nothing tells how each person uses a scale"
        )
    elif reference.settings.get("latency", 200.0):
        out.append(
            f"part {part.name}: the reference '{reference.name}' has a latency of its own; a reference usually has latency = 0"
        )
    if reference is not None and reference.settings.get("warp", "forward") != "none":
        out.append(
            f"part {part.name}: the reference '{reference.name}' is warped; a reference usually has warp = \"none\""
        )
    for number, one in enumerate(part.conditions):
        same = [other.name for other in part.conditions[:number] if other.settings == one.settings]
        if same:
            out.append(
                f"part {part.name}: '{one.name}' has the settings of '{same[0]}'; repeats in [trial] show the same again"
            )
        latency_s = float(one.settings.get("latency", 200.0)) * 1e-3  # type: ignore[arg-type]
        if latency_s * 3 > design.seconds:
            out.append(
                f"part {part.name}: '{one.name}' is {latency_s:g} s late, shown for {design.seconds:g} s: little time to see that"
            )
        if one.settings.get("fused") or one.settings.get("lens", "auto") not in ("auto", "none"):
            out.append(
                f"part {part.name}: '{one.name}' applies a lens, which a headset's runtime does by itself: it runs in a window only"
            )
    compared = {c.part for family in design.families for c in family.comparisons}
    if part.name not in compared:
        out.append(
            f"part {part.name}: no [[family]] says what will be compared; comparisons chosen afterwards prove nothing"
        )
    return out


def _of_people(design: Design) -> list[str]:
    out = []
    if design.sickness is None:
        out.append(
            "nobody is asked about sickness; [sickness] with scale and stop_at asks between trials and stops in time"
        )
    elif design.sickness.stop_at is None and design.sickness.rise is None:
        out.append("sickness has no stop rule: stop_at ends the session at an answer that bad")
    if design.practice is None:
        out.append("there is no [practice]: the first trial is also the first look, and is rated like that")
    if len({scale.low_is_good for scale in design.scales}) > 1:
        told = ", ".join(f"{scale.name}: {'low' if scale.low_is_good else 'high'}" for scale in design.scales)
        out.append(f"the scales go different ways ({told} is good): who rates one like the other will not notice")
    if design.consent is None:
        out.append("there is no [consent] text to agree to")
    for part in design.parts:
        minutes = sum(one.seconds for one in stretches(design, part.name)) / 60
        if minutes > 45:
            out.append(
                f"part {part.name}: about {minutes:.0f} minutes are long in a headset; fewer repeats, or several sessions"
            )
    return out


def every_scale(design: Design) -> tuple[Scale, ...]:
    """All that are asked, each once."""
    sickness = () if design.sickness is None else (design.sickness.scale,)
    return tuple({scale.name: scale for scale in (*design.scales, *sickness, *design.before, *design.after)}.values())
