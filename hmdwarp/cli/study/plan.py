"""Commands on the plan of a study: a new one, what it means, how many people, a session."""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import attrs
import typer

from ...experiments.sweep.options import KeptOptions
from ...options import Declared, Number, force_field, group, option, out_field
from ...study import power as study
from ...study import respondents, scales, store
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


@attrs.frozen
class PowerOptions(Declared):
    """A power simulation. Errors: InputError for a number out of range."""

    study: str = study_field()
    out: Path = out_field(attrs.NOTHING, "Folder for the table, the plot and power.json.")
    force: bool = force_field()
    effect: float | None = option(None, "Assumed true difference, in scale units; of pairs in JOD.")
    sd: float | None = option(
        None, "Standard deviation of one person's difference, in scale units; of pairs of taste, in JOD."
    )
    model: str | None = option(None, "Response model: a .toml file, or a shipped one's name.")
    scale: str | None = option(None, "Rating scale or preference of the study; by default each of them.")
    n: str = option("6..40", "People who begin: 6..40 tries numbers that balance the orders; or a list, 10,12,15.")
    studies: int = option(1000, "Number of simulated studies.", valid=Number(least=10, most=1_000_000))
    power: float = option(0.8, "Target power.", valid=Number(least=0.01, most=0.999))
    alpha: float = option(0.05, "Significance level, after Holm.", valid=Number(least=1e-6, most=0.5))
    seed: int = option(1, "Random seed of the simulation.", valid=Number())
    sweep: KeptOptions = group(KeptOptions)


@takes(PowerOptions, QUIET)
def power(said: Said) -> None:
    """Simulate the study many times, dropouts included, and analyse each like `study analyse`."""
    from ...study.design import load_design
    from .._show import sayer, steps

    options, quiet = PowerOptions.of(said), said["quiet"]
    design = load_design(options.study)
    models = {
        scale: study.model_for(design, scale, options.effect, options.sd, options.model)
        for scale in study.scales_for(design, options.scale)
    }
    ns = study.numbers_of_people(options.n, design)
    with study.power_folder(options.out, force=options.force) as folder:
        simulations = [
            study.Simulation(model, design, scale, ns, options.alpha, options.seed) for scale, model in models.items()
        ]
        with steps("studies", quiet=quiet) as (progress, _):
            found, swept = study.simulate(
                simulations, options.studies, options.out, options.sweep, progress, sayer(quiet)
            )
        study.write_power(folder, found, options.power)
    if not quiet:
        _print_power(found, models, options)
    swept.raise_failures()


def _print_power(
    powers: Sequence[study.Power], models: Mapping[scales.Scale, respondents.Model], options: PowerOptions
) -> None:
    from .._show import paragraph

    first = powers[0]
    people = f"{first.studies} simulated studies ('{models[first.scale].title}'), seed {first.seed}."
    paragraph(f"{people} How often p <= {first.alpha:g} after Holm:")
    for found in powers:
        if len(powers) > 1:
            typer.echo()
            typer.echo(typer.style(f"{found.scale.name}: {found.scale.title}", bold=True))
        _print_power_of(found, options.power)
    if len(powers) > 1 and options.effect is not None:
        paragraph("--effect and --sd were taken in the units of each scale: choose one with --scale where they differ.")
    paragraph(f"Table and plot: {options.out}")


def _print_power_of(found: study.Power, target: float) -> None:
    from ...report import terminal_table
    from .._show import console, paragraph

    lines = [
        [study.name_of(comparison, found), *(f"{at_n.found[comparison].value:.0%}" for at_n in found.at)]
        for comparison in found.true_effect
    ]
    if len(lines) > 1:
        lines.append(["all of them", *(f"{at_n.all_found.value:.0%}" for at_n in found.at)])
    lines.append(["finish", *(f"{at_n.complete:.1f}" for at_n in found.at)])
    console().print(terminal_table(["people who begin", *(str(at_n.n) for at_n in found.at)], lines))
    for sentence in study.sentences(found, target):
        paragraph(sentence)
