"""hmdwarp study power: how many people a planned effect needs."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import attrs
import typer

from ...experiments.sweep.options import KeptOptions
from ...options import Declared, Number, force_field, group, option, out_field
from .._options import QUIET, Said, takes
from ._options import study_field

if TYPE_CHECKING:
    from ...report import OutputFolder
    from ...study.design import Design
    from ...study.power import Power
    from ...study.respondents import Model
    from ...study.scales import Scale

MOST_COUNTS = 9  # numbers of people from a range: so many columns fit a terminal
OWNED = ("power.csv", "power.png")


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
    from ...report import OutputFolder
    from ...study.design import load_design
    from ...study.power import Simulation, simulate
    from .._show import sayer, steps

    options, quiet = PowerOptions.of(said), said["quiet"]
    design = load_design(options.study)
    models = {
        scale: _model(design, scale, options.effect, options.sd, options.model)
        for scale in _scales(design, options.scale)
    }
    counts = _counts(options.n, design)
    with OutputFolder(options.out, owned=OWNED, last="power.json", force=options.force) as folder:
        simulations = [
            Simulation(people, design, scale, tuple(counts), options.alpha, options.seed)
            for scale, people in models.items()
        ]
        with steps("studies", quiet=quiet) as (progress, _):
            found, swept = simulate(simulations, options.studies, options.out, options.sweep, progress, sayer(quiet))
        _write(folder, found, options.power)
    if not quiet:
        _print(found, models, options)
    swept.raise_failures()


def _scales(design: Design, name: str | None) -> tuple[Scale, ...]:
    from ...errors import InputError
    from ...study.power import planned_comparisons
    from ...study.scales import PREFERENCE, RATING

    planned_comparisons(design)  # raises where there is nothing to plan for
    known = {one.name: one for one in design.scales if one.kind in (RATING, PREFERENCE)}
    if name is not None and name not in known:
        raise InputError(f"--scale {name}: {design.path} has {', '.join(known)} after each trial")
    return tuple(known.values()) if name is None else (known[name],)


def _model(design: Design, scale: Scale, effect: float | None, sd: float | None, name: str | None) -> Model:
    """Return the response model. Errors: InputError for too few or conflicting options."""
    from ...errors import InputError
    from ...study.power import pairs_model, pairs_with_effect, planned_model, with_effect
    from ...study.respondents import load_model, model_names
    from ...study.scales import PREFERENCE

    if effect is not None and not math.isfinite(effect):
        raise InputError(f"--effect {effect:g}: expected a number, in units of '{scale.name}'")
    if sd is not None and not 0 < sd < math.inf:
        raise InputError(f"--sd {sd:g}: expected a number above 0, in units of '{scale.name}'")
    if name is not None and sd is not None:
        raise InputError("--sd and --model both set how much people differ: leave one out")
    if name is None and sd is None and design.name in model_names():
        name = design.name
    if name is not None:
        found = load_model(name)
        if scale.name not in found.ratings:
            has = ", ".join(found.ratings) or "none"
            raise InputError(
                f"{found.path}: no [rating.{scale.name}], which the study asks for after each trial: add it, or plan "
                f"another scale of the study by --scale ({has} in the model)"
            )
        if effect is None:
            return found
        return (pairs_with_effect if scale.kind == PREFERENCE else with_effect)(found, design, scale, effect)
    if scale.kind == PREFERENCE:
        if effect is None:
            raise InputError("no response model: expected --effect (in JOD), or --model FILE.toml")
        return pairs_model(design, scale, effect, sd)
    if effect is None or sd is None:
        wanted = "--sd (of one person's difference between two showings)" if effect is not None else "--effect and --sd"
        raise InputError(f"no response model: expected {wanted}, or --model FILE.toml")
    return planned_model(design, scale, effect, sd)


def _counts(text: str, design: Design) -> list[int]:
    """Return the numbers of people. Errors: InputError."""
    from ...errors import InputError
    from ...study.design import rows_for
    from ...study.statistics import MOST_PAIRS

    many = MOST_PAIRS  # a person gives one pair at most
    wanted = f"expected numbers of people, from 1 to {many}"
    listed = re.fullmatch(r"\d+(,\d+)*", text)
    if listed:
        counts = sorted({int(one) for one in text.split(",")})
    elif found := re.fullmatch(r"(\d+)\.\.(\d+)", text):
        least, most = int(found[1]), int(found[2])
        if least > most:
            raise InputError(f"--n {text}: runs backwards: expected the smaller number first, {most}..{least}")
        if most > many:
            raise InputError(f"--n {text}: {wanted}")
        step = math.lcm(*(len(rows_for(design, part.name)) for part in design.parts))
        balanced = [count for count in range(step, most + 1, step) if count >= least]
        balanced = balanced[:: max(1, math.ceil(len(balanced) / MOST_COUNTS))]
        counts = (
            balanced if len(balanced) > 1 else sorted({*range(least, most + 1, max(1, (most - least) // 8)), *balanced})
        )
    else:
        raise InputError(f"--n {text}: expected a range like 6..40, or a list like 10,12,15")
    if not counts or counts[0] < 1 or counts[-1] > many:
        raise InputError(f"--n {text}: {wanted}")
    return counts


def _write(folder: OutputFolder, powers: Sequence[Power], target: float) -> None:
    from ...report.study import PowerLine, power_chart
    from ...study.power import COLUMNS, name_of, power_data, power_rows
    from ...study.scales import PREFERENCE

    folder.write_csv("power.csv", [row for found in powers for row in power_rows(found)], COLUMNS)
    lines = []
    for found in powers:
        scale = f"{found.scale.name}: " if len(powers) > 1 else ""
        for one in found.true_effect:
            shares = [at_n.found[one] for at_n in found.at]
            lines.append(
                PowerLine(
                    name=scale + name_of(one, found),
                    power=[share.value for share in shares],
                    low=[share.low for share in shares],
                    high=[share.high for share in shares],
                    unlimited=[at_n.unlimited[one].value for at_n in found.at],
                )
            )
    ns = [one.n for one in powers[0].at]
    pairs = powers[0].scale.kind == PREFERENCE
    unlimited = {"unlimited": "if people said by how much"} if pairs else {}
    power_chart(folder.path("power.png"), ns, lines, target, powers[0].design.title, **unlimited)
    folder.write_json("power.json", power_data(powers, target))


def _print(powers: Sequence[Power], models: Mapping[Scale, Model], options: PowerOptions) -> None:
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


def _print_one(found: Power, target: float) -> None:
    from rich.table import Table

    from ...study.power import name_of, sentences
    from .._show import console, paragraph

    table = Table(box=None, pad_edge=False)
    table.add_column("people who begin")
    for at_n in found.at:
        table.add_column(str(at_n.n), justify="right")
    for one in found.true_effect:
        table.add_row(name_of(one, found), *(f"{at_n.found[one].value:.0%}" for at_n in found.at))
    if len(found.true_effect) > 1:
        table.add_row("all of them", *(f"{at_n.all_found.value:.0%}" for at_n in found.at))
    table.add_row("finish", *(f"{at_n.complete:.1f}" for at_n in found.at))
    console().print(table)
    for sentence in sentences(found, target):
        paragraph(sentence)
