"""hmdwarp study init and plan: write a plan to begin with; check one, and print its outline."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import attrs
import typer

from ...options import Declared, force_field, option
from .._options import Said, as_json, takes
from ._options import study_field


@attrs.frozen
class InitOptions(Declared):
    """A new plan."""

    name: str = option(attrs.NOTHING, "Name of the study; the file is NAME.toml.", positional=True, metavar="NAME")
    force: bool = force_field()


@takes(InitOptions)
def init(said: Said) -> None:
    """Write NAME.toml, a commented plan that can be run as it is."""
    from ...study.design import write_new_plan

    options = InitOptions.of(said)
    path = write_new_plan(options.name, Path(), force=options.force)
    typer.echo(f"written: {path}; change it, then: hmdwarp study plan {path}")


@attrs.frozen
class PlanOptions(Declared):
    """What to print of a plan."""

    study: str = study_field()
    json: bool = option(False, "Print the plan as one JSON object.")
    orders: bool = option(False, "Print every order as well.")


@takes(PlanOptions)
def plan(said: Said) -> None:
    """Check a study's file and print conditions, steps, time, orders, scales and comparisons."""
    from ...report import counted
    from ...study import design as study
    from .._show import in_columns, paragraph

    options = PlanOptions.of(said)
    design = study.load_design(options.study)
    if options.json:
        typer.echo(as_json(study.design_as_json(design)))
        return
    paragraph(typer.style(design.title, bold=True))
    in_columns(study.head_rows(design))
    for part in design.parts:
        _print_block(f"Part {part.name}: {counted(len(part.conditions), 'condition')}", study.condition_rows(part))
        whole, phases = study.session_rows(design, part)
        typer.echo(f"  A session: {whole}")
        in_columns(phases, indent=4)
        if not (orders := len(study.rows_for(design, part.name))):
            continue
        typer.echo(f"  Orders: {orders}")
        in_columns(study.balance_rows(design, part), indent=4)
        for row in study.order_rows(design, part) if options.orders else ():
            in_columns([row], indent=4)
        if options.orders and orders > study.MOST_ORDERS:
            typer.echo(f"    .. and {orders - study.MOST_ORDERS} more; --json has them all")
    _print_block("Scales", ((scale.name, study.scale_text(scale)) for scale in study.every_scale(design)))
    families = [(family.name, study.family_text(family)) for family in design.families]
    _print_block("Comparisons, each family with Holm's correction", families)
    if not families:
        typer.echo("  none planned")
    if notes := study.notes(design):
        _print_block("Hints", (("-", note) for note in notes))
    else:
        typer.echo("\nNo hints.")


def _print_block(heading: str, rows: Iterable[tuple[str, str]]) -> None:
    from .._show import in_columns

    typer.echo()
    typer.echo(typer.style(heading, bold=True))
    in_columns(rows, indent=2)
