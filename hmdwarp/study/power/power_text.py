"""Summary of a power simulation: sentences, table and JSON data."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scipy.special import ndtr

from ...report import OutputFolder, counted, pair_text
from ...report.study import PowerLine, power_chart
from ..design import Comparison
from ..scales import PREFERENCE
from ..statistics import JOD_SPREAD
from .planned_models import UNIT
from .simulation import Power, PowerAt, Proportion, people_for

COLUMNS = (
    *("scale", "part", "condition", "baseline", "n", "power", "power_low", "power_high", "power_unlimited", "pairs"),
    *("complete", "true_effect", "planned_effect"),
)


def power_rows(power: Power) -> list[dict[str, Any]]:
    """Return a row for each comparison and n, by COLUMNS."""
    return [_row(power, comparison, at_n) for comparison in power.true_effect for at_n in power.at]


def _row(power: Power, one: Comparison, at_n: PowerAt) -> dict[str, Any]:
    found = at_n.found[one]
    return {
        "scale": power.scale.name,
        "part": one.part,
        "condition": one.better,
        "baseline": one.baseline,
        "n": at_n.n,
        "power": found.value,
        "power_low": found.low,
        "power_high": found.high,
        "power_unlimited": at_n.unlimited[one].value,
        "pairs": at_n.pairs[one],
        "complete": at_n.complete,
        "true_effect": power.true_effect[one],
        "planned_effect": power.planned[one],
    }


def name_of(one: Comparison, power: Power) -> str:
    """Name a comparison for tables and plots, with its part where there are several."""
    several = len({other.part for other in power.true_effect}) > 1
    name = pair_text(one.baseline, one.better)
    return f"{one.part}: {name}" if several else name


def sentences(power: Power, target: float) -> list[str]:
    """Describe the power against the target, one fact per sentence."""
    each = [_enough(power, comparison, target) for comparison in power.true_effect]
    return [*each, *_together(power, target), *_invite(power, target), *_limits(power)]


def _enough(power: Power, one: Comparison, target: float) -> str:
    reached, last = power.enough(target, one), power.at[-1]
    name = f"{name_of(one, power)} ({_effect(power, one)})"
    if reached is None:
        share = f"with {counted(last.n, 'person')} it is found in {_percent(last.found[one])} of studies"
        return f"{name}: {target:.0%} is not reached; {share}."
    found = reached.found[one]
    text = f"{name}: with {counted(reached.n, 'person')} it is found in {_percent(found)} of studies."
    if reached is power.at[0]:
        text += " That is the smallest number tried; fewer may suffice."
    if found.is_uncertain_about(target):
        text += f" The simulation leaves open whether that is {target:.0%}: use more --studies."
    return text


def _effect(power: Power, one: Comparison) -> str:
    true = power.true_effect[one]
    if power.scale.kind == PREFERENCE:
        return f"{true:+.2f} {UNIT}: preferred in {ndtr(true / JOD_SPREAD):.0%} of forced choices"
    return f"a true mean difference of {true:+.2f}"


def _percent(found: Proportion) -> str:
    return f"{found.value:.1%} ({found.low:.1%} to {found.high:.1%})"


def _together(power: Power, target: float) -> list[str]:
    if len(power.true_effect) < 2:
        return []
    reached, each = power.enough(target), f"each of the {len(power.true_effect)} comparisons"
    if reached is None:
        return [f"No number of people tried gives {each} {target:.0%}."]
    together = f"all of them at once are found in {_percent(reached.all_found)} of studies"
    return [f"With {counted(reached.n, 'person')} {each} has {target:.0%} or more; {together}."]


def _invite(power: Power, target: float) -> list[str]:
    """Translate people who begin into people to invite; dropouts count with what they rated."""
    if power.complete_share == 1:
        return []
    reached = power.enough(target) or power.at[-1]
    text = f"{1 - power.complete_share:.0%} of these people do not finish; the numbers above are people who begin."
    needed = people_for(reached.n, power.complete_share)
    if needed is not None:
        sessions = counted(reached.n, "complete session")
        text += f" For {sessions} plan {counted(needed, 'person')} (enough nine times in ten)."
    return [text]


def _limits(power: Power) -> list[str]:
    """Say where the scale's ends and steps reduce an effect."""
    out = []
    for comparison in power.true_effect:
        planned, true = power.planned[comparison], power.true_effect[comparison]
        if abs(planned - true) > 0.05 * abs(planned) and abs(planned - true) > 0.02:
            last = power.at[-1]
            out.append(
                f"{name_of(comparison, power)}: the true mean difference would be {planned:+.2f} on a scale without "
                f"ends and steps, and is {true:+.2f} on this one; without them it would be found in "
                f"{last.unlimited[comparison].value:.0%} of studies with {counted(last.n, 'person')}."
            )
    return out


def power_data(powers: Sequence[Power], target: float) -> dict[str, Any]:
    """Return all results, for power.json. powers: of one study, on each of its scales."""
    first = powers[0]
    return {
        "study": first.design.name,
        "studies": first.studies,
        "seed": first.seed,
        "alpha": first.alpha,
        "wanted": target,
        "orders": first.balanced,
        "scales": [
            {
                "scale": power.scale.name,
                "complete_share": power.complete_share,
                "rows": power_rows(power),
                "all_found": [{"n": at_n.n, "power": at_n.all_found.value} for at_n in power.at],
                "sentences": sentences(power, target),
            }
            for power in powers
        ],
    }


def power_folder(folder: Path, *, force: bool = False) -> OutputFolder:
    """Return the folder to write a power simulation to. Errors: as OutputFolder."""
    return OutputFolder(folder, owned=("power.csv", "power.png"), last="power.json", force=force)


def write_power(folder: OutputFolder, powers: Sequence[Power], target: float) -> None:
    """Write power.csv, power.png and power.json. powers: of one study, on each of its scales."""
    folder.write_csv("power.csv", [row for power in powers for row in power_rows(power)], COLUMNS)
    lines = [
        PowerLine(
            name=(f"{power.scale.name}: " if len(powers) > 1 else "") + name_of(comparison, power),
            power=[at_n.found[comparison].value for at_n in power.at],
            low=[at_n.found[comparison].low for at_n in power.at],
            high=[at_n.found[comparison].high for at_n in power.at],
            unlimited=[at_n.unlimited[comparison].value for at_n in power.at],
        )
        for power in powers
        for comparison in power.true_effect
    ]
    first = powers[0]
    unlimited = {"unlimited": "if people said by how much"} if first.scale.kind == PREFERENCE else {}
    power_chart(folder.path("power.png"), [at_n.n for at_n in first.at], lines, target, first.design.title, **unlimited)
    folder.write_json("power.json", power_data(powers, target))
