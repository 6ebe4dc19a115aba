"""What a power simulation found, as people read it, and as a table and JSON."""

from __future__ import annotations

from typing import Any

from ..design import Comparison
from .shares import people_for
from .simulation import Power, Strength

COLUMNS = (
    *("part", "a", "b", "n", "power", "power_low", "power_high", "power_unlimited", "pairs", "complete"),
    *("true_effect", "planned_effect"),
)


def rows_of(power: Power) -> list[dict[str, Any]]:
    """One for each comparison and n, under COLUMNS."""
    return [_row(power, one, strength) for one in power.true_effect for strength in power.strengths]


def _row(power: Power, one: Comparison, strength: Strength) -> dict[str, Any]:
    found = strength.found[one]
    return {
        "part": one.part,
        "a": one.a,
        "b": one.b,
        "n": strength.n,
        "power": found.value,
        "power_low": found.low,
        "power_high": found.high,
        "power_unlimited": strength.unlimited[one].value,
        "pairs": strength.pairs[one],
        "complete": strength.complete,
        "true_effect": power.true_effect[one],
        "planned_effect": power.planned[one],
    }


def name_of(one: Comparison, power: Power) -> str:
    """As tables and plots call it; with its part where there are several."""
    several = len({other.part for other in power.true_effect}) > 1
    return f"{one.part}: {one.a} - {one.b}" if several else f"{one.a} - {one.b}"


def sentences(power: Power, wanted: float) -> list[str]:
    """What follows from it, one thing each."""
    each = [_enough(power, one, wanted) for one in power.true_effect]
    return [*each, *_together(power, wanted), *_invite(power, wanted), *_limits(power)]


def _enough(power: Power, one: Comparison, wanted: float) -> str:
    reached, last = power.enough(wanted, one), power.strengths[-1]
    name = name_of(one, power)
    effect = f"a true mean difference of {power.true_effect[one]:+.2f}"
    if reached is None:
        found = last.found[one]
        return (
            f"{name} ({effect}): up to {last.n} people do not reach {wanted:.0%}; with {last.n} it is {_share(found)}."
        )
    found = reached.found[one]
    said = f"{name} ({effect}): {reached.n} people find it in {_share(found)} of studies."
    if reached is power.strengths[0]:
        said += " That is the least number tried; fewer may do."
    if found.leaves_open(wanted):
        said += f" The simulation leaves open whether that is {wanted:.0%}: more --studies would tell."
    return said


def _share(share: Any) -> str:
    return f"{share.value:.1%} ({share.low:.1%} to {share.high:.1%})"


def _together(power: Power, wanted: float) -> list[str]:
    if len(power.true_effect) < 2:
        return []
    reached, each = power.enough(wanted), f"each of the {len(power.true_effect)} comparisons"
    if reached is None:
        return [f"No number of people tried gives {each} {wanted:.0%}."]
    together = f"all of them at once are found in {_share(reached.all_found)} of studies"
    return [f"With {reached.n} people {each} has {wanted:.0%} or more; {together}."]


def _invite(power: Power, wanted: float) -> list[str]:
    """Counted are people who begin; who leaves in the middle is in the analysis with what they rated."""
    if power.complete_share == 1:
        return []
    reached = power.enough(wanted) or power.strengths[-1]
    said = f"{1 - power.complete_share:.0%} of these people do not come to the end; the numbers above are people who begin."
    needed = people_for(reached.n, power.complete_share)
    if needed is not None:
        said += f" Whoever wants {reached.n} complete sessions plans for {needed} people (enough nine times in ten)."
    return [said]


def _limits(power: Power) -> list[str]:
    """Where the scale's ends and steps take from an effect."""
    out = []
    for one in power.true_effect:
        planned, true = power.planned[one], power.true_effect[one]
        if abs(planned - true) > 0.05 * abs(planned) and abs(planned - true) > 0.02:
            out.append(
                f"{name_of(one, power)}: the scale's ends and steps make {true:+.2f} of {planned:+.2f}; a scale without them would find "
                f"{power.strengths[-1].unlimited[one].value:.0%} with {power.strengths[-1].n} people."
            )
    return out


def as_json(power: Power, wanted: float) -> dict[str, Any]:
    """Everything, for power.json."""
    return {
        "study": power.design.name,
        "scale": power.scale.name,
        "studies": power.studies,
        "seed": power.seed,
        "alpha": power.alpha,
        "wanted": wanted,
        "orders": power.balanced,
        "complete_share": power.complete_share,
        "rows": rows_of(power),
        "all_found": [{"n": one.n, "power": one.all_found.value} for one in power.strengths],
        "sentences": sentences(power, wanted),
    }
