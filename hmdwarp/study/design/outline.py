"""Steps of a session, its duration, the balance of the orders, and hints before it begins.

The same plan and order give the same steps every time, and each step has a fixed key under which
the store keeps it. Resuming a session, after a crash too, means finding the first undone step.
"""

from __future__ import annotations

import json
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence

import attrs

from ...report import counted
from ..scales import QUESTIONNAIRE, Item, Scale
from .definitions import (
    FIXED,
    ONE,
    PAIR,
    RANDOM,
    REFERENCE_FIRST,
    WILLIAMS,
    Condition,
    Design,
    Page,
    Part,
    default_of,
    resolved,
)
from .orders import Order, pair_of, presented, trials_of, turned

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
    until_done: bool = False  # whether the participant ends it
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
        steps.append(Show("practice", 0, design.practice, design.practice_seconds, block=0))
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
    shows: list[Show] = []
    for condition, turn in zip(conditions, TURNS[design.shows], strict=True):
        after = shows[-1].key if shows else ""
        at = f"{key}/{turn}" if turn else key
        shows.append(Show(at, trial, condition, design.seconds, repeat, block, design.until_done, turn, after))
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


# Estimates in seconds: an answer by keys after a look at the scale, an item of a list, a word to
# read.
ANSWER_S, ITEM_S, WORD_S = 6.0, 4.0, 0.3
ALPHA = 0.05


@attrs.frozen
class SessionPhase:
    """Phase of a session, such as the trials or the questionnaires before them."""

    name: str
    content: str  # in words
    steps: int
    seconds: float  # expected
    at_most: bool = False  # whether it may be over before, as its trials end when the participant is done


@attrs.frozen
class Balance:
    """Counts (fewest, most) over all orders of a part."""

    orders: int
    places: tuple[int, int]  # of a condition in a place of its repeat
    pairs: tuple[int, int] | None  # of an ordered pair of different conditions within a repeat
    seams: tuple[int, int] | None  # of such a pair across two repeats; None for a single repeat
    repeated: int  # how often a condition follows itself across two repeats


def session_phases(design: Design, part: str) -> tuple[SessionPhase, ...]:
    """Return the phases of a session of that part, from beginning to end."""
    trials = trials_of(design, part)
    steps = steps_of(design, (presented(design, part),) * design.repeats, part)
    asked = [scale.name for scale in design.scales]
    every = design.sickness.every if design.sickness is not None else 0
    sick = (
        []
        if design.sickness is None
        else [f"{design.sickness.scale.name}{'' if every == 1 else f' after every {_nth(every)}'}"]
    )
    content = {
        "consent": "a text to read and to agree to",
        "before": ", ".join(_asked(scale) for scale in design.before),
        "instructions": "a page to read",
        "practice": f"{design.practice_seconds:g} s, not scored",
        "trials": f"{trials} {_lasting(design)}, {_asked_after(design, trials)}: {', '.join(asked + sick)}",
        "breaks": f"{design.breaks.seconds:g} s at least, after every {_nth(design.breaks.every)}",
        "after": ", ".join(_asked(scale) for scale in design.after),
    }
    found: dict[str, list[Step]] = {name: [] for name in content}
    for step in steps:
        found[_phase(step)].append(step)
    return tuple(
        SessionPhase(name, content[name], len(of), sum(map(expected_s, of)), name == "trials" and design.until_done)
        for name, of in found.items()
        if of
    )


def _lasting(design: Design) -> str:
    lasting = f"until done, at most {design.seconds:g} s" if design.until_done else f"of {design.seconds:g} s"
    if design.shows == PAIR:
        return f"pairs, each condition {lasting.removeprefix('of ')}"
    if design.shows == REFERENCE_FIRST:
        return f"of the reference and a condition, each {lasting.removeprefix('of ')}"
    return lasting


def _asked_after(design: Design, trials: int) -> str:
    return f"{'each ' if trials > 1 else ''}{'compared' if design.shows == PAIR else 'rated'}"


def _asked(scale: Scale) -> str:
    return f"{scale.name} ({counted(len(scale.items), 'item')})"


def _nth(every: int) -> str:
    return "trial" if every == 1 else counted(every, "trial")


def _phase(step: Step) -> str:
    match step:
        case Read():
            return "consent"
        case PageStep():
            return "instructions"
        case Pause():
            return "breaks"
        case Ask(phase="before" | "after" | "practice" as phase):
            return phase
        case Show(trial=0):
            return "practice"
        case _:
            return "trials"


def expected_s(step: Step) -> float:
    """Return the expected duration of a step, and the longest of one that the participant ends."""
    match step:
        case Read(text=text):
            return reading_s(text)
        case PageStep(page=page):
            return reading_s(page.text)
        case Show(seconds=seconds) | Pause(seconds=seconds):
            return seconds
        case Ask(scale=scale):
            return ITEM_S if scale.kind == QUESTIONNAIRE else ANSWER_S


def reading_s(text: str) -> float:
    """Return how long a text, or a picture without words, is read."""
    return max(10.0, WORD_S * len(text.split()))


def balance(orders: Sequence[Order], names: Sequence[str]) -> Balance:
    """Count how these orders of a part are balanced.

    names: what they order, as orders.presented; of a pair it does not matter which one is first.
    """
    orders = [tuple(tuple(map(_unturned(names), row)) for row in order) for order in orders]
    rows = [row for order in orders for row in order]
    places = Counter((place, name) for row in rows for place, name in enumerate(row))
    pairs = Counter(pair for row in rows for pair in zip(row, row[1:], strict=False))
    seams = Counter((before[-1], after[0]) for order in orders for before, after in zip(order, order[1:], strict=False))
    unequal = [(a, b) for a in names for b in names if a != b]
    return Balance(
        len(orders),
        _range([places[place, name] for place in range(len(names)) for name in names]),
        _range([pairs[pair] for pair in unequal]) if unequal else None,
        _range([seams[pair] for pair in unequal]) if unequal and seams else None,
        sum(count for (a, b), count in seams.items() if a == b),
    )


def _unturned(names: Sequence[str]) -> Callable[[str], str]:
    known = set(names)
    return lambda name: name if name in known else turned(name)


def _range(counts: Sequence[int]) -> tuple[int, int]:
    return min(counts), max(counts)


def least_participants(comparisons: int) -> int:
    """Return the participants below which no comparison of such a family can be significant.

    The smallest p of an exact Wilcoxon test, 2 / 2^n, times the comparisons must fall below ALPHA.
    """
    return math.ceil(math.log2(2 * comparisons / ALPHA))


def notes(design: Design) -> tuple[str, ...]:
    """Return hints to consider before the study begins; none of them is an error."""
    return (
        *_of_order(design),
        *(note for part in design.parts for note in _of_part(design, part)),
        *_of_comparisons(design),
        *_of_people(design),
        *design.scene_notes,
    )


def _of_order(design: Design) -> list[str]:
    out = []
    if design.order == FIXED:
        out.append(
            "the order is the same for all participants: late conditions may be rated by habit or fatigue; order "
            "williams balances that"
        )
    elif design.order == RANDOM:
        out.append(
            "random orders are balanced only on average; order williams is balanced exactly, with few participants"
        )
    for part in design.parts:
        count = len(part.conditions)
        if design.order == WILLIAMS and count % 2 and design.shows != PAIR:
            out.append(
                f"part {part.name}: {count} conditions, an odd number, need {2 * count} orders; {count + 1} would "
                f"need {count + 1}"
            )
    return out


def _of_part(design: Design, part: Part) -> list[str]:
    out = []
    reference = next((condition for condition in part.conditions if condition.reference), None)
    if reference is None:
        out.append(
            f"part {part.name}: no condition is a hidden reference (reference = true): nothing shows how each "
            "person uses a scale"
        )
    elif reference.settings.get("latency", 200.0):
        out.append(
            f"part {part.name}: the reference '{reference.name}' has a latency of its own; a reference usually has "
            "latency = 0"
        )
    if reference is not None and reference.settings.get("warp") != "none":
        out.append(
            f"part {part.name}: the reference '{reference.name}' is warped; a reference usually has warp = \"none\""
        )
    for number, condition in enumerate(part.conditions):
        same = [other.name for other in part.conditions[:number] if other.settings == condition.settings]
        if same:
            out.append(
                f"part {part.name}: '{condition.name}' has the settings of '{same[0]}'; repeats in [trial] shows the "
                "same again"
            )
        latency_s = float(condition.settings.get("latency", 200.0)) * 1e-3  # type: ignore[arg-type]
        if latency_s * 3 > design.seconds:
            out.append(
                f"part {part.name}: '{condition.name}' is {latency_s:g} s late, shown for {design.seconds:g} s: that "
                "is little time to see it"
            )
        if condition.settings.get("fused") or condition.settings.get("lens", "auto") not in ("auto", "none"):
            out.append(
                f"part {part.name}: '{condition.name}' applies a lens, which a headset's runtime does by itself: it "
                "works only in a window"
            )
    compared = {c.part for family in design.families for c in family.comparisons}
    if part.name not in compared:
        out.append(f"part {part.name}: no [[family]] plans a comparison; comparisons chosen afterwards prove nothing")
    return out


def _of_comparisons(design: Design) -> list[str]:
    """Say which planned comparisons are confounded: their conditions differ in several settings.

    Those with a hidden reference differ in all by design. A warp and what fills its holes are one
    thing where the other condition has no warp.
    """
    pairs: dict[tuple[str, str], list[str]] = defaultdict(list)
    for compared in (one for family in design.families for one in family.comparisons):
        of = {condition.name: condition for condition in design.part(compared.part).conditions}
        both = of[compared.better], of[compared.baseline]
        varied = _varied(*(resolved(one.settings) for one in both))
        if len(varied) > 1 and not any(one.reference for one in both):
            pairs[compared.part, _confounded(varied, *(one.settings for one in both))].append(
                f"'{compared.better}' over '{compared.baseline}'"
            )
    return [f"part {part}: {', '.join(names)}: {what}" for (part, what), names in pairs.items()]


Varied = dict[str, tuple[object, object]]
# Settings whose default follows the warp.
_BY_WARP = ("fill", "guard", "predict")


def _varied(better: Mapping[str, object], baseline: Mapping[str, object]) -> Varied:
    """Return the settings that differ, with both values. better, baseline: as resolved."""
    names = dict.fromkeys((*better, *baseline))
    values = {name: tuple(one.get(name, default_of(name)) for one in (better, baseline)) for name in names}
    varied = {name: (a, b) for name, (a, b) in values.items() if a != b}
    if "none" in varied.get("warp", ()):
        varied.pop("fill", None)
    return varied


def _confounded(varied: Varied, better: Mapping[str, object], baseline: Mapping[str, object]) -> str:
    what = ", ".join(f"{name} ({_in_toml(a)} and {_in_toml(b)})" for name, (a, b) in varied.items())
    said = f"several settings differ, {what}; which of them is rated, no answer tells"
    by_default = [name for name in _BY_WARP if name in varied and not (name in better and name in baseline)]
    if not by_default:
        return f"{said}; compare conditions that differ in one"
    lines = " and ".join(f"{name} = {_in_toml(better.get(name, varied[name][0]))}" for name in by_default)
    return f"{said}; some have a default that follows the warp: write {lines} into [common], and it is the same for all"


def _in_toml(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else json.dumps(value)


def _of_people(design: Design) -> list[str]:
    out = []
    if design.sickness is None:
        out.append(
            "no question about sickness; [sickness] with scale and stop_at asks between trials and stops in time"
        )
    elif design.sickness.stop_at is None and design.sickness.rise is None:
        out.append("sickness has no stop rule: stop_at ends the session at an answer that bad")
    if design.practice is None:
        out.append("there is no [practice]: the first trial is also the first look, and is rated as such")
    rated = [scale for scale in design.scales if scale.has_answers]
    if len({scale.low_is_good for scale in rated}) > 1:
        good = ", ".join(f"{scale.name}: {'low' if scale.low_is_good else 'high'}" for scale in rated)
        out.append(f"the scales go different ways ({good} is good): participants may confuse them unnoticed")
    if design.consent is None:
        out.append("there is no [consent] text to agree to")
    for part in design.parts:
        minutes = sum(phase.seconds for phase in session_phases(design, part.name)) / 60
        if minutes > 45:
            shorter = ", several sessions, or a shorter longest" if design.until_done else " or several sessions"
            out.append(
                f"part {part.name}: {'at most ' if design.until_done else ''}about {minutes:.0f} minutes are long in a "
                f"headset; use fewer repeats{shorter}"
            )
    return out
