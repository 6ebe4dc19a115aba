"""Steps of a session, its duration and balance, hints; and the plan as 'study plan' prints it."""

from __future__ import annotations

import itertools
import json
import math
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from statistics import NormalDist
from typing import Any

import attrs

from ...report import counted, listed, pair_text
from ..scales import QUESTIONNAIRE, Item, Scale
from ..statistics import JOD_SPREAD, people_for_sign, people_for_signed_rank, sign_power, signed_rank_power, smallest_p
from . import definitions
from .definitions import Condition, Design, Family, Page, Part, default_of, every_scale, resolved
from .orders import Order, pair_name, pair_of, presented, rows_for, trials_of, turned

# Names of a trial's showings, by what it shows; the questions are about the last one.
TURNS = {"one": ("",), "pair": ("first", "second"), "reference first": ("reference", "second")}


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
    """Return all steps of a session. order: names of the part's conditions, a tuple per repeat."""
    steps: list[Step] = [] if design.consent is None else [Read("consent", design.consent.text)]
    steps += [ask for scale in design.before for ask in _asks(scale, "before", "before")]
    if design.instructions is not None:
        steps.append(PageStep("instructions", design.instructions))
    if design.practice is not None:
        steps.append(Show("practice", 0, design.practice, design.practice_seconds, block=0))
        steps += _sickness(design, "practice", 0, "practice")
    shown = [(name, repeat) for repeat, names in enumerate(order, 1) for name in names]
    for trial, (name, repeat) in enumerate(shown, 1):
        steps += _trial(design, design.part(part), trial, name, repeat)
        if design.breaks.every and trial % design.breaks.every == 0 and trial < len(shown):
            steps.append(Pause(f"break/{trial // design.breaks.every}", design.breaks.seconds))
    steps += [ask for scale in design.after for ask in _asks(scale, "after", "after")]
    return tuple(steps)


def _trial(design: Design, part: Part, trial: int, name: str, repeat: int) -> list[Step]:
    """Return a trial's showings and the questions about the last. name: as the order has it."""
    key, names = f"trial/{trial}", [name]
    if design.shows == definitions.PAIR:
        names = [*pair_of(name)]
    elif design.shows == definitions.REFERENCE_FIRST:
        names = [condition.name for condition in part.conditions if condition.reference] + names
    conditions = [part.condition(shown) for shown in names]
    block = 1 + (trial - 1) // design.breaks.every if design.breaks.every else 1
    shows: list[Show] = []
    for condition, turn in zip(conditions, TURNS[design.shows], strict=True):
        after, at = shows[-1].key if shows else "", f"{key}/{turn}" if turn else key
        shows.append(Show(at, trial, condition, design.seconds, repeat, block, design.until_done, turn, after))
    about = shows[-1].key
    asks = [ask for scale in design.scales for ask in _asks(scale, key, "trial", trial, about)]
    if design.sickness is not None and trial % design.sickness.every == 0:
        asks += _sickness(design, key, trial, about)
    return [*shows, *asks]


def _sickness(design: Design, key: str, trial: int, about: str) -> tuple[Ask, ...]:
    if design.sickness is None:
        return ()
    return _asks(design.sickness.scale, key, "trial" if trial else "practice", trial, about)


def _asks(scale: Scale, key: str, phase: str, trial: int = 0, about: str = "") -> tuple[Ask, ...]:
    return tuple(Ask(f"{key}/{scale.name}/{item.key}", scale, item, phase, trial, about) for item in scale.items)


# Estimates in seconds: an answer by keys after a look at the scale, an item of a list, a word to
# read.
_ANSWER_S, _ITEM_S, WORD_S = 6.0, 4.0, 0.3
ALPHA = 0.05


@attrs.frozen
class _SessionPhase:
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


def session_phases(design: Design, part: str) -> tuple[_SessionPhase, ...]:
    """Return the phases of a session of that part, from beginning to end."""
    trials, every = trials_of(design, part), design.breaks.every
    asked = [scale.name for scale in design.scales]
    if (rule := design.sickness) is not None:
        asked.append(f"{rule.scale.name}{'' if rule.every == 1 else f' after every {_nth(rule.every)}'}")
    lasting = f"until done, at most {design.seconds:g} s" if design.until_done else f"of {design.seconds:g} s"
    each = f"each {'condition ' if design.shows == definitions.PAIR else ''}{lasting.removeprefix('of ')}"
    lasting = {
        definitions.PAIR: f"pairs, {each}",
        definitions.REFERENCE_FIRST: f"of the reference and a condition, {each}",
    }.get(design.shows, lasting)
    rated = f"{'each ' if trials > 1 else ''}{'compared' if design.shows == definitions.PAIR else 'rated'}"
    before, after = (
        ", ".join(f"{scale.name} ({counted(len(scale.items), 'item')})" for scale in scales)
        for scales in (design.before, design.after)
    )
    content = {
        "consent": "a text to read and to agree to",
        "before": before,
        "instructions": "a page to read",
        "practice": f"{design.practice_seconds:g} s, not scored",
        "trials": f"{trials} {lasting}, {rated}: {', '.join(asked)}",
        "breaks": f"{design.breaks.seconds:g} s at least, after every {_nth(every)}",
        "after": after,
    }
    found: dict[str, list[Step]] = {name: [] for name in content}
    for step in steps_of(design, (presented(design, part),) * design.repeats, part):
        found[_phase(step)].append(step)
    return tuple(
        _SessionPhase(name, content[name], len(of), sum(map(_expected_s, of)), name == "trials" and design.until_done)
        for name, of in found.items()
        if of
    )


def _nth(every: int) -> str:
    return "trial" if every == 1 else counted(every, "trial")


def _phase(step: Step) -> str:
    if isinstance(step, Ask) and step.phase != "trial":
        return step.phase
    if isinstance(step, Show | Ask):
        return "trials" if step.trial else "practice"
    return {Read: "consent", PageStep: "instructions", Pause: "breaks"}[type(step)]


def _expected_s(step: Step) -> float:
    """Return the expected duration of a step, and the longest of one that the participant ends."""
    if isinstance(step, Show | Pause):
        return step.seconds
    if isinstance(step, Ask):
        return _ITEM_S if step.scale.kind == QUESTIONNAIRE else _ANSWER_S
    return reading_s(step.text if isinstance(step, Read) else step.page.text)


def reading_s(text: str) -> float:
    """Return how long a text, or a picture without words, is read."""
    return max(10.0, WORD_S * len(text.split()))


def balance(orders: Sequence[Order], names: Sequence[str]) -> Balance:
    """Count how these orders of `names` are balanced; of a pair either may be first."""
    known = set(names)
    unturned = [[[name if name in known else turned(name) for name in row] for row in order] for order in orders]
    rows = [row for order in unturned for row in order]
    places = Counter((place, name) for row in rows for place, name in enumerate(row))
    pairs = Counter(pair for row in rows for pair in zip(row, row[1:], strict=False))
    seams = Counter((before[-1], after[0]) for order in unturned for before, after in itertools.pairwise(order))
    unequal = [(a, b) for a in names for b in names if a != b]

    def range_of(counts: Sequence[int]) -> tuple[int, int]:
        return min(counts), max(counts)

    return Balance(
        len(orders),
        range_of([places[place, name] for place in range(len(names)) for name in names]),
        range_of([pairs[pair] for pair in unequal]) if unequal else None,
        range_of([seams[pair] for pair in unequal]) if unequal and seams else None,
        sum(count for (a, b), count in seams.items() if a == b),
    )


def least_participants(comparisons: int) -> int:
    """Return how many people the exact Wilcoxon test of so many comparisons needs."""
    return math.ceil(math.log2(2 * comparisons / ALPHA))


def notes(design: Design) -> tuple[str, ...]:
    """Return hints to consider before the study begins; none of them is an error."""
    out = []
    if design.order == definitions.FIXED:
        out.append(
            "the order is the same for all participants: late conditions may be rated by habit or fatigue; order "
            "williams balances that"
        )
    elif design.order == definitions.RANDOM:
        out.append(
            "random orders are balanced only on average; order williams is balanced exactly, with few participants"
        )
    for part in design.parts:
        count = len(part.conditions)
        if design.order == definitions.WILLIAMS and count % 2 and design.shows != definitions.PAIR:
            need = f"{count} conditions, an odd number, need {2 * count} orders"
            out.append(f"part {part.name}: {need}; {count + 1} would need {count + 1}")
    for part in design.parts:
        out += [f"part {part.name}: {note}" for note in _of_part(design, part)]
    return (*out, *_of_comparisons(design), *_of_people(design), *design.scene_notes)


def _of_part(design: Design, part: Part) -> list[str]:
    out = []
    reference = next((condition for condition in part.conditions if condition.reference), None)
    if reference is None:
        none = "no condition is a hidden reference (reference = true)"
        out.append(f"{none}: nothing shows how each person uses a scale")
    else:
        name, settings = f"the reference '{reference.name}'", reference.settings
        if settings.get("latency", 200.0):
            out.append(f"{name} has a latency of its own; a reference usually has latency = 0")
        if settings.get("warp") != "none":
            out.append(f'{name} is warped; a reference usually has warp = "none"')
    for number, condition in enumerate(part.conditions):
        name, settings = f"'{condition.name}'", condition.settings
        same = [other.name for other in part.conditions[:number] if other.settings == settings]
        if same:
            out.append(f"{name} has the settings of '{same[0]}'; repeats in [trial] shows the same again")
        latency_s = float(settings.get("latency", 200.0)) * 1e-3  # type: ignore[arg-type]
        if latency_s * 3 > design.seconds:
            late = f"{name} is {latency_s:g} s late, shown for {design.seconds:g} s"
            out.append(f"{late}: that is little time to see it")
        if settings.get("fused") or settings.get("lens", "auto") not in ("auto", "none"):
            out.append(f"{name} applies a lens, which a headset's runtime does by itself: it works only in a window")
    if part.name not in {c.part for family in design.families for c in family.comparisons}:
        out.append("no [[family]] plans a comparison; comparisons chosen afterwards prove nothing")
    return out


def _of_comparisons(design: Design) -> list[str]:
    """Say which planned comparisons are confounded: their conditions differ in several settings.

    Those with a hidden reference differ in all by design. A warp and what fills its holes are one
    thing where the other condition has no warp.
    """
    pairs: dict[tuple[str, str], list[str]] = defaultdict(list)
    for compared in (one for family in design.families for one in family.comparisons):
        both = [design.part(compared.part).condition(name) for name in (compared.better, compared.baseline)]
        better, baseline = (resolved(one.settings) for one in both)
        varied = dict[str, tuple[object, ...]]()
        for name in dict.fromkeys((*better, *baseline)):
            values = tuple(one.get(name, default_of(name)) for one in (better, baseline))
            varied |= {name: values} if values[0] != values[1] else {}
        if "none" in varied.get("warp", ()):
            varied.pop("fill", None)
        if len(varied) > 1 and not any(one.reference for one in both):
            what = _confounded(varied, *(one.settings for one in both))
            pairs[compared.part, what].append(f"'{compared.better}' over '{compared.baseline}'")
    return [f"part {part}: {', '.join(names)}: {what}" for (part, what), names in pairs.items()]


# Settings whose default follows the warp.
_BY_WARP = ("fill", "guard", "predict")


def _confounded(
    varied: Mapping[str, tuple[object, ...]], better: Mapping[str, object], baseline: Mapping[str, object]
) -> str:
    def in_toml(value: object) -> str:
        return f"{value:g}" if isinstance(value, float) else json.dumps(value)

    what = ", ".join(f"{name} ({in_toml(a)} and {in_toml(b)})" for name, (a, b) in varied.items())
    said = f"several settings differ, {what}; which of them is rated, no answer tells"
    by_default = [name for name in _BY_WARP if name in varied and not (name in better and name in baseline)]
    if not by_default:
        return f"{said}; compare conditions that differ in one"
    lines = " and ".join(f"{name} = {in_toml(better.get(name, varied[name][0]))}" for name in by_default)
    return f"{said}; some have a default that follows the warp: write {lines} into [common], and it is the same for all"


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
            about = f"{'at most ' if design.until_done else ''}about {minutes:.0f} minutes are long in a headset"
            out.append(f"part {part.name}: {about}; use fewer repeats{shorter}")
    return out


MOST_ORDERS = 40  # printed; the JSON data has them all
Rows = list[tuple[str, str]]


def head_rows(design: Design) -> Rows:
    """Describe the study, what is hidden, the order, and what surrounds the trials."""
    hidden = {
        definitions.BOTH: "the condition, from participant and experimenter: both see only numbers of trials",
        definitions.PARTICIPANT: "the condition, from the participant; the experimenter sees it",
    }.get(design.blind, "nothing: participant and experimenter see the condition")
    what = "pair" if design.shows == definitions.PAIR else "condition"
    again = f"; each {what} {design.repeats} times, each round in another order" if design.repeats > 1 else ""
    order = {
        definitions.FIXED: "fixed: as in the file, the same for all participants",
        definitions.WILLIAMS: f"Williams design, seed {design.seed}: each session gets the order used least so far"
        f"{again}",
        definitions.RANDOM: f"random, seed {design.seed}: another one for each participant{again}",
    }[design.order]
    rows = [("Study", f"{design.name}: {design.path} is valid"), ("Hidden", hidden), ("Order", order)]
    if design.practice is not None:
        settings = ", ".join(_settings(design.practice.settings))
        rows.append(("Practice", f"{design.practice_seconds:g} s first, not scored: {settings}"))
    if (rule := design.sickness) is not None:
        often = "every trial" if rule.every == 1 else f"every {rule.every} trials"
        ends = [f"{rule.rise:g} worse than at first"] if rule.rise is not None else []
        if rule.stop_at is not None:
            ends.insert(0, f"{rule.stop_at:g} or {'more' if rule.scale.low_is_good else 'less'}")
        ending = f"ends the session at {' or at '.join(ends)}" if ends else "never ends the session"
        rows.append(("Sickness", f"{rule.scale.name} after {often}; {ending}"))
    if design.consent is not None:
        words = counted(len(design.consent.text.split()), "word")
        rows.append(("Consent", f"text version {design.consent.version}, {words}"))
    return rows


def _settings(settings: Mapping[str, object]) -> list[str]:
    def text(value: object) -> str:
        if isinstance(value, bool):
            return "yes" if value else "no"
        return f"{value:g}" if isinstance(value, int | float) else str(value)

    return [f"{name} {text(value)}" for name, value in settings.items()]


def condition_rows(part: Part) -> Rows:
    """Describe the conditions of a part with their defaults, what they share last."""
    first, *others = part.conditions
    shared = {
        name: value
        for name, value in first.settings.items()
        if others and all(name in condition.settings and condition.settings[name] == value for condition in others)
    }
    rows = []
    for number, condition in enumerate(part.conditions, 1):
        settings = condition.settings
        own = ", ".join(_settings({name: value for name, value in settings.items() if name not in shared}))
        more = {name: value for name, value in resolved(settings).items() if name not in settings}
        by_default = f"; by default {', '.join(_settings(more))}" if more else ""
        reference = " (the hidden reference)" if condition.reference else ""
        rows.append((f"{number}  {condition.name}", (own or "as all") + by_default + reference))
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
    if design.order == definitions.FIXED:
        return [("balanced", "no: there is one order")]

    def times(least: int, most: int) -> str:
        return f"{least} to {most} times" if least != most else "once" if least == 1 else f"{least} times"

    found = balance(rows_for(design, part.name), presented(design, part.name))
    what, count = "pair" if design.shows == definitions.PAIR else "condition", found.orders
    lines = [("places", f"each {what} in each place {times(*found.places)}")]
    if found.pairs is not None:
        lines.append(("neighbours", f"each {what} right after each other one {times(*found.pairs)}"))
    if found.seams is not None:
        often = f"{times(found.repeated, found.repeated)} a condition" if found.repeated else "none"
        round_ = f"between two rounds, each right after each other one {times(*found.seams)}"
        lines.append(("seams", f"{round_}; {often} follows itself"))
    if design.order == definitions.WILLIAMS:
        lines.append(("people", f"balanced with {count}, {2 * count}, {3 * count} .. complete sessions"))
    return lines


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
    unit, found = "JOD" if design.shows == definitions.PAIR else "sd", []
    for count in sorted({len(family.comparisons) for family in design.families}):
        alpha, rows = ALPHA / count, []
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
    rows = [("test", f"{found['test']}, p below 0.05{strict}: {listed(found['families'])}")]
    for row in found["effects"]:
        power = f"{row['power']:.0%} with {found['people']} people, 80% with {row['people_for_80_percent']}"
        rows.append((f"{row['effect']:g} {found['unit']}", power))
    return [*rows, ("assumed", found["assumed"])]


def design_as_json(design: Design) -> dict[str, object]:
    """Return the whole plan; times in seconds, orders as lists of names for each repeat."""
    rule, practice = design.sickness, design.practice
    pages = {key: getattr(design, key) for key in ("instructions", "ready", "thanks")}
    return {
        **{key: getattr(design, key) for key in ("name", "title", "path", "seed")},
        **{key: getattr(design, key) for key in ("blind", "order", "shows", "repeats")},
        "trial_seconds": design.seconds,
        "trial_until_done": design.until_done,
        "practice": practice and {"seconds": design.practice_seconds, "settings": dict(practice.settings)},
        "breaks": attrs.asdict(design.breaks),
        "sickness": rule and attrs.asdict(rule, recurse=False) | {"scale": rule.scale.name},
        "consent_version": design.consent and design.consent.version,
        **{key: page and attrs.asdict(page) for key, page in pages.items()},
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
