"""hmdwarp study power: how many people a planned effect needs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import attrs
import typer

from ...experiments.sweep.options import KeptOptions
from ...options import Declared, Number, force_field, group, option, out_field
from ...study import power as study
from ...study import respondents, scales
from .._options import QUIET, Said, takes
from ._options import study_field


@attrs.frozen
class PowerOptions(Declared):
    """A power simulation. Errors: InputError for a number out of range."""

    study: str = study_field()
    out: Path = out_field(attrs.NOTHING, "Folder for the table, the plot and power.json.")
    force: bool = force_field()
    effect: float | None = option(None, "Assumed true difference, in scale units; of pairs in JOD.", kind=float)
    sd: float | None = option(
        None, "Standard deviation of one person's difference, in scale units; of pairs of taste, in JOD.", kind=float
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
        _print(found, models, options)
    swept.raise_failures()


def _print(
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
        _print_one(found, options.power)
    if len(powers) > 1 and options.effect is not None:
        paragraph("--effect and --sd were taken in the units of each scale: choose one with --scale where they differ.")
    paragraph(f"Table and plot: {options.out}")


def _print_one(found: study.Power, target: float) -> None:
    from rich.table import Table

    from .._show import console, paragraph

    table = Table(box=None, pad_edge=False)
    table.add_column("people who begin")
    for at_n in found.at:
        table.add_column(str(at_n.n), justify="right")
    for comparison in found.true_effect:
        table.add_row(study.name_of(comparison, found), *(f"{at_n.found[comparison].value:.0%}" for at_n in found.at))
    if len(found.true_effect) > 1:
        table.add_row("all of them", *(f"{at_n.all_found.value:.0%}" for at_n in found.at))
    table.add_row("finish", *(f"{at_n.complete:.1f}" for at_n in found.at))
    console().print(table)
    for sentence in study.sentences(found, target):
        paragraph(sentence)
