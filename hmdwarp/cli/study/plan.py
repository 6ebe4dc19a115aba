"""hmdwarp study plan: checks a plan, and prints its outline."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs
import typer

from ...options import Declared, option
from .._options import Said, as_json, takes
from ._options import study_field

if TYPE_CHECKING:
    from ...study.design import Condition, Design, Family, Order, Part, Sickness
    from ...study.scales import Scale

_MOST_ORDERS = 40  # printed; --json has them all


@attrs.frozen
class PlanOptions(Declared):
    """What to print of a plan."""

    study: str = study_field()
    json: bool = option(False, "Print the plan as one JSON object.")
    orders: bool = option(False, "Print every order as well.")


@takes(PlanOptions)
def plan(said: Said) -> None:
    """Check a study's file and print conditions, steps, time, orders, scales and comparisons."""
    from ...study.design import design_as_json, load_design

    options = PlanOptions.of(said)
    design = load_design(options.study)
    if options.json:
        typer.echo(as_json(design_as_json(design)))
        return
    _print_head(design)
    for part in design.parts:
        _print_part(design, part, options.orders)
    _print_scales(design)
    _print_families(design)
    _print_notes(design)


def _print_head(design: Design) -> None:
    from ...report import counted
    from .._show import in_columns, paragraph

    paragraph(typer.style(design.title, bold=True))
    rows = [
        ("Study", f"{design.name}: {design.path} is valid"),
        ("Hidden", _hidden(design)),
        ("Order", _order(design)),
    ]
    if design.practice is not None:
        rows.append(("Practice", f"{design.practice_seconds:g} s first, not scored: {_settings(design.practice)}"))
    if design.sickness is not None:
        rows.append(("Sickness", _sickness(design.sickness)))
    if design.consent is not None:
        rows.append(
            ("Consent", f"text version {design.consent.version}, {counted(len(design.consent.text.split()), 'word')}")
        )
    in_columns(rows)


def _hidden(design: Design) -> str:
    from ...study.design import BOTH, PARTICIPANT

    if design.blind == BOTH:
        return "the condition, from participant and experimenter: both see only numbers of trials"
    if design.blind == PARTICIPANT:
        return "the condition, from the participant; the experimenter sees it"
    return "nothing: participant and experimenter see the condition"


def _order(design: Design) -> str:
    from ...study.design import ADAPTIVE, FIXED, PAIR, WILLIAMS

    if design.order == ADAPTIVE:
        return f"adaptive, seed {design.seed}: each session gets the pairs that tell most after all answers before it"
    if design.order == FIXED:
        return "fixed: as in the file, the same for all participants"
    what = "pair" if design.shows == PAIR else "condition"
    again = f"; each {what} {design.repeats} times, each round in another order" if design.repeats > 1 else ""
    if design.order == WILLIAMS:
        return f"Williams design, seed {design.seed}: each session gets the order used least so far{again}"
    return f"random, seed {design.seed}: another one for each participant{again}"


def _sickness(asked: Sickness) -> str:
    often = "every trial" if asked.every == 1 else f"every {asked.every} trials"
    ends = []
    if asked.stop_at is not None:
        ends.append(f"{asked.stop_at:g} or {'more' if asked.scale.low_is_good else 'less'}")
    if asked.rise is not None:
        ends.append(f"{asked.rise:g} worse than at first")
    rule = f"ends the session at {' or at '.join(ends)}" if ends else "never ends the session"
    return f"{asked.scale.name} after {often}; {rule}"


def _settings(condition: Condition) -> str:
    return ", ".join(f"{name} {_value(value)}" for name, value in condition.settings.items())


def _defaults(condition: Condition) -> str:
    """Name the defaults of a condition: a reference that names no warp has one."""
    from ...study.design import live_options

    options = live_options(condition.settings)
    values = {"latency": options.latency_ms, "warp": options.warp, "fill": options.fill}
    if options.rendered_size is None:
        values["guard"] = options.guard
    values["predict"] = options.predict
    texts = [f"{name} {_value(value)}" for name, value in values.items() if name not in condition.settings]
    return f"; by default {', '.join(texts)}" if texts else ""


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    return f"{value:g}" if isinstance(value, int | float) else str(value)


def _common(design: Design, part: Part) -> dict[str, object]:
    """Return the settings that all conditions of the part share."""
    first, *others = part.conditions
    return {
        name: value
        for name, value in first.settings.items()
        if others and all(name in one.settings and one.settings[name] == value for one in others)
    }


def _print_part(design: Design, part: Part, orders: bool) -> None:
    from ...report import counted
    from .._show import in_columns

    typer.echo()
    typer.echo(typer.style(f"Part {part.name}: {counted(len(part.conditions), 'condition')}", bold=True))
    shared = _common(design, part)
    rows = []
    for number, one in enumerate(part.conditions, 1):
        own = ", ".join(f"{name} {_value(value)}" for name, value in one.settings.items() if name not in shared)
        rows.append(
            (
                f"{number}  {one.name}",
                (own or "as all") + _defaults(one) + (" (the hidden reference)" if one.reference else ""),
            )
        )
    if shared:
        rows.append(("   all", ", ".join(f"{name} {_value(value)}" for name, value in shared.items())))
    in_columns(rows, indent=2)
    _print_session(design, part)
    _print_orders(design, part, orders)


def _print_session(design: Design, part: Part) -> None:
    from ...study.design import session_phases
    from .._show import in_columns

    session = session_phases(design, part.name)
    total, at_most = sum(one.seconds for one in session), any(one.at_most for one in session)
    steps = sum(one.steps for one in session)
    typer.echo(f"  A session: {steps} steps, {'at most ' if at_most else ''}about {_time(total)}")
    in_columns(((one.name, f"{_time(one.seconds):>7}  {one.content}") for one in session), indent=4)


def _time(seconds: float) -> str:
    return f"{seconds:.0f} s" if seconds < 90 else f"{seconds / 60:.0f} min"


def _print_orders(design: Design, part: Part, all_of_them: bool) -> None:
    from ...study.design import pair_name, rows_for
    from .._show import in_columns

    rows = rows_for(design, part.name)
    if not rows:
        return
    typer.echo(f"  Orders: {len(rows)}")
    in_columns(_balance(design, part, rows), indent=4)
    if not all_of_them:
        return
    numbers = {one.name: str(number) for number, one in enumerate(part.conditions, 1)}
    numbers |= {pair_name(a, b): f"{numbers[a]}/{numbers[b]}" for a in list(numbers) for b in list(numbers)}
    for number, order in enumerate(rows[:_MOST_ORDERS], 1):
        rounds = " | ".join(" ".join(numbers[name] for name in names) for names in order)
        in_columns([(f"order {number}:", rounds)], indent=4)
    if len(rows) > _MOST_ORDERS:
        typer.echo(f"    .. and {len(rows) - _MOST_ORDERS} more; --json has them all")


def _balance(design: Design, part: Part, rows: tuple[Order, ...]) -> list[tuple[str, str]]:
    from ...study.design import FIXED, PAIR, WILLIAMS, balance, presented

    if design.order == FIXED:
        return [("balanced", "no: there is one order")]
    found = balance(rows, presented(design, part.name))
    what = "pair" if design.shows == PAIR else "condition"
    lines = [("places", f"each {what} in each place {_times(found.places)}")]
    if found.pairs is not None:
        lines.append(("neighbours", f"each {what} right after each other one {_times(found.pairs)}"))
    if found.seams is not None:
        again = (
            f"; {_times((found.repeated,) * 2)} a condition follows itself"
            if found.repeated
            else "; none follows itself"
        )
        lines.append(("seams", f"between two rounds, each right after each other one {_times(found.seams)}{again}"))
    if design.order == WILLIAMS:
        count = found.orders
        lines.append(("people", f"balanced with {count}, {2 * count}, {3 * count} .. complete sessions"))
    return lines


def _times(counts: tuple[int, int]) -> str:
    least, most = counts
    if least != most:
        return f"{least} to {most} times"
    return "once" if least == 1 else f"{least} times"


def _print_scales(design: Design) -> None:
    from ...study.design import every_scale
    from .._show import in_columns

    typer.echo()
    typer.echo(typer.style("Scales", bold=True))
    in_columns(((scale.name, _scale(scale)) for scale in every_scale(design)), indent=2)


def _scale(scale: Scale) -> str:
    anchors = "; ".join(f"{value:g} = {words}" for value, words in scale.anchors.items())
    items = f" {len(scale.items)} items." if len(scale.items) > 1 else ""
    if not scale.has_answers:
        return f"{scale.title}: {', '.join(item.key for item in scale.items)}, each with its own answers"
    range_ = f"{scale.least:g} to {scale.most:g} in steps of {scale.step:g}"
    return f"{scale.title}: {range_}, {scale.direction}.{items} {anchors}"


def _print_families(design: Design) -> None:
    from .._show import in_columns

    typer.echo()
    typer.echo(typer.style("Comparisons, each family with Holm's correction", bold=True))
    in_columns(((family.name, _family(family)) for family in design.families), indent=2)
    if not design.families:
        typer.echo("  none planned")


def _family(family: Family) -> str:
    from ...report import pair_text
    from ...study.design import least_participants
    from ...study.statistics import smallest_p

    pairs = ", ".join(pair_text(one.baseline, one.better) for one in family.comparisons)
    count = len(family.comparisons)
    need = least_participants(count)
    best = f"{count} x {smallest_p(need):.2g} at best with {need}"
    return f"{pairs}\np below 0.05 is out of reach with fewer than {need} people ({best})"


def _print_notes(design: Design) -> None:
    from ...study.design import notes
    from .._show import in_columns

    found = notes(design)
    typer.echo()
    if found:
        typer.echo(typer.style("Hints", bold=True))
        in_columns((("-", note) for note in found), indent=2)
    else:
        typer.echo("No hints.")
