"""Commands on the plan of a study: a new one, what it means, a session."""

from __future__ import annotations

import sys
from collections.abc import Iterable
from pathlib import Path

import attrs
import typer

from ...options import Declared, Number, force_field, option
from ...study import store
from ...study.session.session_options import SessionOptions
from .._options import QUIET, Said, as_json, takes
from .._signals import Ended
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
    people: int = option(20, "Number of people whose power is printed, in each part.", valid=Number(least=2, most=100))


@takes(PlanOptions)
def plan(said: Said) -> None:
    """Check a study's file and print conditions, steps, time, orders, scales and comparisons."""
    from ...report import counted
    from ...study import design as study
    from .._show import in_columns, paragraph

    options = PlanOptions.of(said)
    design = study.load_design(options.study)
    if options.json:
        typer.echo(as_json(study.design_as_json(design) | {"power": study.power_as_json(design, options.people)}))
        return
    paragraph(typer.style(design.title, bold=True))
    in_columns(study.head_rows(design))
    for part in design.parts:
        _print_block(f"Part {part.name}: {counted(len(part.conditions), 'condition')}", study.condition_rows(part))
        whole, phases = study.session_rows(design, part)
        typer.echo(f"  A session: {whole}")
        in_columns(phases, indent=4)
        orders = len(study.rows_for(design, part.name))
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
    for rows in (study.power_rows(power) for power in study.power_as_json(design, options.people)):
        _print_block("Power of one comparison", rows)
    if notes := study.notes(design):
        _print_block("Hints", (("-", note) for note in notes))
    else:
        typer.echo("\nNo hints.")


def _print_block(heading: str, rows: Iterable[tuple[str, str]]) -> None:
    from .._show import in_columns

    typer.echo()
    typer.echo(typer.style(heading, bold=True))
    in_columns(rows, indent=2)


INTERRUPTED = 130


@takes(SessionOptions, attrs.evolve(QUIET, help="Print nothing but errors and a drawn code."))
def run(said: Said) -> None:
    """Run a session: show each condition, ask about it, store every answer at once."""
    _run(SessionOptions.of(said), said["quiet"])


def _run(options: SessionOptions, quiet: bool) -> None:
    """Run it, and exit with a status of its own where the session was interrupted.

    The closing words are printed by then; the usual "nothing unfinished is left" would be wrong.
    """
    from ...study.session.program import run_session

    said: list[str] = []
    ends: list[store.Session] = []
    status = INTERRUPTED

    def end(session: store.Session) -> None:
        ends.append(session)
        if quiet and options.participant.lower() == "new":
            typer.echo(session.code)

    try:
        session = run_session(options, said.append if quiet else typer.echo, quiet=quiet, on_end=end)
        if session.status != "interrupted":
            return
    except (KeyboardInterrupt, Ended) as error:
        if not ends:
            raise
        if isinstance(error, Ended):
            status = 128 + error.args[0]
    if quiet:
        typer.echo(f"hmdwarp: session interrupted: {ends[0].why}; what was answered is stored, {said[-1]}", err=True)
    sys.exit(status)
