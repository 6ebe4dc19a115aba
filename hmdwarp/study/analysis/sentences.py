"""One honest sentence for each result: what the ratings show, how sure that is, and what they leave open."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ...report import ALPHA, counted, listed, p_is, plain, signed
from .ratings import Measure

Row = Mapping[str, Any]
# A bootstrap interval lies between the least and the largest difference. All n are on one side of a symmetric truth in 2 / 2^n of studies,
# and then it misses: five pairs hold it in 93.75 % at most.
_LEAST_FOR_BCA = 6


def of_comparison(row: Row, measure: Measure) -> str:
    """What a comparison says. row: as comparisons.compared."""
    where = f"{row['part']}: " if row["part"] else ""
    if not row["n"]:
        return f"{where}nobody rated both '{row['a']}' and '{row['b']}', so nothing can be said of them."
    told = f"{where}{_votes(row)}; {_size(row, measure)}"
    return f"{told} {_verdict(row, measure)}"


def _votes(row: Row) -> str:
    parts = [f"{row['better']} of {row['n']} rated '{row['b']}' better than '{row['a']}'", f"{row['worse']} worse"]
    if row["equal"]:
        parts.append(f"{row['equal']} the same")
    return ", ".join(parts)


def _size(row: Row, measure: Measure) -> str:
    mean = f"mean difference {signed(row['mean'])} {measure.unit}"
    if row["low"] is None:
        why = "there is only one" if row["n"] == 1 else "all differences are the same"
        return f"{mean} (no interval: {why})."
    ends = f"{signed(row['low'])} to {signed(row['high'])}"
    if row["n"] < _LEAST_FOR_BCA:
        return f"{mean} (bootstrap {ends}, which is too short for 95 % with {counted(row['n'], 'pair')})."
    return f"{mean} (95 % {ends})."


def _verdict(row: Row, measure: Measure) -> str:
    after = f"After Holm over {counted(row['holm_of'], 'comparison')}" if row["holm_of"] > 1 else "By the exact test"
    if row["holm"] <= ALPHA:
        # Not by the shift: it is 0 where more than half of the pairs are alike, which the test leaves out.
        way = "better" if row["w_plus"] > row["w_minus"] else "worse"
        return f"{after} {p_is(row['holm'])}: '{row['b']}' was rated {way}."
    if row["smallest_p"] > ALPHA:
        least = p_is(row["smallest_p"])
        always = "" if row["equal"] else ", whatever the ratings"
        return f"{_pairs(row)} can give no smaller p than {least[4:]}, so this comparison shows nothing either way{always}."
    low, high, level = row["shift_low"], row["shift_high"], f"{100 * row['shift_level']:.0f} %"
    if row["p"] <= ALPHA:
        return (
            f"{after} {p_is(row['holm'])}, by itself {p_is(row['p'])}: not shown at 5 % where all {row['holm_of']} count; alone, the "
            f"ratings fit differences from {signed(low)} to {signed(high)} {measure.unit} ({level})."
        )
    return (
        f"{after} {p_is(row['holm'])}: no difference is shown, which does not say that there is none: the ratings fit anything from "
        f"{_way(low, measure)} to {_way(high, measure)} ({level})."
    )


def _way(shift: float, measure: Measure) -> str:
    return (
        "no difference"
        if shift == 0
        else f"{'a gain' if shift > 0 else 'a loss'} of {plain(abs(shift))} {measure.unit}"
    )


def _pairs(row: Row) -> str:
    return counted(row["better"] + row["worse"], "unequal pair")


def of_friedman(row: Row | None, part: str) -> str:
    """Whether any condition differs at all."""
    where = f"{part}: " if part else ""
    if row is None:
        return f"{where}Friedman's test needs three conditions and two participants who rated all of them."
    verdict = (
        "the conditions were not all rated alike"
        if row["p"] <= ALPHA
        else "no difference among the conditions is shown"
    )
    return (
        f"{where}Friedman over {row['conditions']} conditions, {counted(row['n'], 'participant')} who rated all: chi2({row['df']}) = "
        f"{row['chi2']:.1f}, {p_is(row['p'])}, Kendall's W = {row['w']:.2f}: {verdict}."
    )


def of_order(effects: Mapping[str, Row], measure: Measure) -> list[str]:
    """Of the effects of a trial's place and of what was shown before it. effects: as effects.order_effects."""
    reasons = {row.get("why_not", "") for row in effects.values()}
    if len(reasons) == 1 and "" not in reasons:
        return [f"Whether the order mattered cannot be estimated: {reasons.pop()}."]
    return [_of_effect(name, row, measure) for name, row in effects.items()]


_EFFECTS = {"place": "The place of a trial", "previous": "The condition shown before"}


def _of_effect(name: str, row: Row, measure: Measure) -> str:
    what = _EFFECTS[name]
    if "why_not" in row:
        return f"{what}: its effect cannot be estimated, {row['why_not']}."
    test = f"F({row['df']}, {row['df_rest']}) = {row['f']:.2f}, {p_is(row['p'])}"
    verdict = "it changed the ratings" if row["p"] <= ALPHA else "no effect is shown"
    if "or" in row:
        verdict += f"; here it cannot be told apart from {_EFFECTS[row['or']].lower()}"
    slope = ""
    if "slope" in row:
        slope = f"; {signed(row['slope'], 3)} {measure.unit} per trial (95 % {signed(row['low'], 3)} to {signed(row['high'], 3)})"
    return f"{what}: {test}{slope}: {verdict}."


def of_copied(row: Row) -> str:
    """Rows that two parts share."""
    first, second = row["parts"]
    doubles = listed([f"{one['second']} = {one['first']}" for one in row["rows"]])
    chance = (
        f"Drawn independently that many would come about in {100 * row['by_chance']:.2g} % of studies; within the parts "
        f"{row['within']} of {row['within_of']} pairs of people are alike."
    )
    if row["by_chance"] <= ALPHA:
        verdict = "Such rows were most likely copied, or are of the same people: the parts are not independent, and are not pooled here."
    else:
        verdict = "That is no sign that any were copied; the parts are not pooled here."
    return (
        f"In {row['people']} of {row['of']} rows of {second} the ratings of the {len(row['conditions'])} conditions that both parts have "
        f"equal those of somebody in {first} ({second} = {first}: {doubles}). {chance} {verdict}"
    )


def of_claim(row: Row, title: str, measure: Measure) -> str:
    """A published figure against the data."""
    told = f"{title}" + (f" ({row['where']})" if row["where"] else "")
    if "why_not" in row:
        said = f"{row['latency_ms']:g} ms" if row["difference"] is None else signed(row["difference"], 3)
        return f"{row['part']}: {told} says {said}; {row['why_not']}."
    at = (
        f"{row['part']}, {row['latency_ms']:g} ms"
        if row["latency_ms"] is not None
        else f"{row['part']}, {row['a']} against {row['b']}"
    )
    if row["difference"] is None:
        return f"{at}: {told} names it, and it was rated."
    says = f"{at}: {told} says {_figure(row['difference'])}, its data give {signed(row['data'], 3)}"
    if row["follows"]:
        return f"{says}: follows."
    rest = (
        f"; near it is only the {listed(row['explained_by'], 'or the')}, which is another thing"
        if row["explained_by"]
        else ""
    )
    return f"{says}: does not follow{rest}."


def _figure(value: float) -> str:
    return f"{value:+.3f}".rstrip("0").rstrip(".")


def of_reference(row: Row | None) -> str:
    """Whether people found the hidden reference good."""
    if row is None:
        return "There was no hidden reference, so nobody can tell from the ratings who judged with care."
    if not row["rated"]:
        return "Nobody rated the hidden reference."
    if not row["missed"]:
        who = {1: "The only one", 2: "Both"}.get(row["rated"], f"All {row['rated']}")
        return f"{who} who rated the hidden reference put it in the better half of their ratings."
    return (
        f"{len(row['missed'])} of {row['rated']} rated the hidden reference worse than the middle one of their other ratings "
        f"({listed(row['missed'])}). Their ratings are kept; what the comparisons are without them stands beside."
    )
