"""Simulated studies as a set of cases: so many of them on one scale each."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import attrs
import numpy as np

from ...experiments.sweep import KeptOptions, Result, Separate, SweepCase, Swept, run_cases
from .simulation import Power, Progress, Simulation, Tally, power_from, tally_of

# Of the package, besides what draws pictures.
_ALSO = ("study/",)
STUDIES_OF_A_CASE = 50


@attrs.frozen
class PowerPart:
    """What one case simulates."""

    simulation: Simulation
    # Numbers of its studies.
    first: int
    count: int


def simulate(
    simulations: Sequence[Simulation],
    studies: int,
    out: Path,
    options: KeptOptions,
    progress: Progress = lambda done, total: None,
    say: Callable[[str], None] = lambda text: None,
) -> tuple[list[Power], Swept]:
    """Simulate the studies and return the power of each simulation, and what became of the cases.

    simulations: each on a scale of its own.
    Cases are kept in the folder `cases` of `out`. Those that fail are left out: the power is that
    of fewer studies. progress(done, total): in studies. say: gets a sentence.
    Errors: InputError; that of the first case where all of a simulation failed.
    """
    for simulation in simulations:
        simulation.populations()  # says what is wrong with a model before anything runs
    cases = [case for simulation in simulations for case in _cases(simulation, studies)]
    swept = run_cases(Separate(_run), cases, out, options, progress, say)
    tallies: dict[str, list[Tally]] = {simulation.scale.name: [] for simulation in simulations}
    for case, data in swept.results():
        counts = {name: np.asarray(count) for name, count in data.items()}
        tallies[case.what.simulation.scale.name].append(counts)
    if not all(tallies.values()):
        swept.raise_failures()
    return [power_from(simulation, tallies[simulation.scale.name]) for simulation in simulations], swept


def _cases(simulation: Simulation, studies: int) -> list[SweepCase]:
    # Where the plan and the model came from does not count, and need not cross.
    model = attrs.evolve(simulation.model, path="")
    alike = attrs.evolve(simulation, model=model, design=attrs.evolve(simulation.design, path="", text=""))
    parts = [
        PowerPart(alike, first, min(STUDIES_OF_A_CASE, studies - first))
        for first in range(0, studies, STUDIES_OF_A_CASE)
    ]
    return [
        SweepCase.of(
            "study power",
            f"{simulation.scale.name}, studies {part.first + 1} to {part.first + part.count}",
            part,
            also=_ALSO,
            steps=part.count,
        )
        for part in parts
    ]


def _run(case: SweepCase, step: Callable[[float], None]) -> Result:
    part: PowerPart = case.what
    studies = range(part.first, part.first + part.count)
    tally = tally_of(part.simulation, studies, lambda done, total: step(done / total))
    return Result({name: counts.tolist() for name, counts in tally.items()})
