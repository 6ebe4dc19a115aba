"""Power by simulation: how often studies of simulated people find each planned comparison.

Each study is analysed as `study analyse` does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import attrs
import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri
from scipy.stats import binom

from ...experiments.sweep import KeptOptions, Result, Separate, SweepCase, Swept, run_cases
from ..design import Comparison, Design
from ..respondents import Cohort, Floats, Model, Population
from ..scales import PREFERENCE, Scale
from ..statistics import holm, wilcoxon_exact
from .planned_models import choice_differences, expected_jod, planned_comparisons

LEVEL = 0.95


@attrs.frozen
class Proportion:
    """A proportion with Wilson's interval at LEVEL, which is accurate near 0 and 1 too.

    Source: Wilson 1927, Probable inference, J Am Stat Assoc 22; recommended by Brown, Cai and
    DasGupta 2001.
    """

    hits: int
    total: int
    low: float
    high: float

    @property
    def value(self) -> float:
        """The proportion, 0..1."""
        return self.hits / self.total

    def is_uncertain_about(self, threshold: float) -> bool:
        """Return whether the true proportion may be on either side of the threshold."""
        return self.low < threshold < self.high


def proportion_of(hits: int, total: int) -> Proportion:
    """Return the proportion.

    Errors: ValueError unless 0 <= hits <= total and total is at least 1.
    """
    if not 0 <= hits <= total or total < 1:
        raise ValueError(f"{hits} of {total} is no proportion")
    z = float(ndtri((1 + LEVEL) / 2))
    p, narrowed = hits / total, 1 + z * z / total
    middle = (p + z * z / (2 * total)) / narrowed
    half = z * math.sqrt(p * (1 - p) / total + (z / (2 * total)) ** 2) / narrowed
    # At the ends the formula gives 0 and 1 only up to rounding.
    return Proportion(hits, total, 0.0 if hits == 0 else middle - half, 1.0 if hits == total else middle + half)


def people_for(complete: int, share: float, sure: float = 0.9) -> int | None:
    """Return how many must begin so that at least `complete` finish with probability `sure`.

    share: probability that one finishes. None for more than a thousand people.
    """
    counts = np.arange(complete, 1001)
    enough = binom.sf(complete - 1, counts, share) >= sure
    return int(counts[enough.argmax()]) if enough.any() else None


Progress = Callable[[int, int], None]


@attrs.frozen
class PowerAt:
    """Power with n people who begin, in each part."""

    n: int
    found: dict[Comparison, Proportion]  # significant after Holm in its families
    unlimited: dict[Comparison, Proportion]  # the same without steps, ends and choices
    all_found: Proportion  # all comparisons at once
    complete: float  # mean number of people who finish
    pairs: dict[Comparison, float]  # mean number of people with both ratings


@attrs.frozen
class Power:
    """Power for several numbers of people."""

    design: Design
    scale: Scale
    at: tuple[PowerAt, ...]
    alpha: float
    studies: int
    seed: int
    balanced: int  # multiples of that many people have all orders equally often
    complete_share: float  # share of people who finish
    # Expected difference of the ratings, exactly: with steps and ends of the scale, and without. Of
    # pairs in JOD.
    true_effect: dict[Comparison, float]
    planned: dict[Comparison, float]

    def enough(self, target: float, comparison: Comparison | None = None) -> PowerAt | None:
        """Return the smallest n from which on every larger n reaches the target power too.

        Of the comparison; without one, of each comparison by itself.
        """
        reached = None
        for at_n in reversed(self.at):
            shares = at_n.found.values() if comparison is None else (at_n.found[comparison],)
            if min(share.value for share in shares) < target:
                break
            reached = at_n
        return reached


@attrs.frozen
class Simulation:
    """What is simulated: studies by a plan, answered by a model on one of its scales."""

    model: Model
    design: Design
    scale: Scale
    # Numbers of people who begin, in each part. The first n people of a study are the same for
    # every n.
    ns: tuple[int, ...]
    alpha: float = 0.05
    seed: int = 0

    @property
    def comparisons(self) -> tuple[Comparison, ...]:
        """All planned comparisons, each once. Errors: InputError as planned_comparisons."""
        return planned_comparisons(self.design)

    def populations(self) -> dict[str, Population]:
        """Return the people of each part that is compared.

        Errors: InputError for a model that does not name a scale or a condition of the study.
        """
        # Means that rehearse any plan alike say nothing about this one.
        model = attrs.evolve(self.model, others=None)
        parts = dict.fromkeys(comparison.part for comparison in self.comparisons)
        return {part: Population(model, self.design, part, [self.scale.name]) for part in parts}


# Counts over studies by name: whole numbers, so that their sum does not depend on its order.
Tally = dict[str, NDArray[np.int64]]


def tally_of(simulation: Simulation, studies: range, progress: Progress = lambda done, total: None) -> Tally:
    """Simulate these studies and return the counts. Errors: InputError."""
    populations, people = simulation.populations(), range(max(simulation.ns))
    ns, each = len(simulation.ns), (len(simulation.ns), len(simulation.comparisons))
    shapes = {"found": each, "unlimited": each, "pairs": each, "all_found": (ns,), "complete": (ns,)}
    tally = {name: np.zeros(shapes.get(name, ()), np.int64) for name in (*shapes, "studies", "people", "finished")}
    for done, study in enumerate(studies, 1):
        cohorts = {part: population.of(people, simulation.seed, study) for part, population in populations.items()}
        for k in range(len(simulation.ns)):
            _count(tally, k, simulation, cohorts)
        tally["studies"] += 1
        tally["people"] += sum(len(cohort.trials) for cohort in cohorts.values())
        tally["finished"] += sum(cohort.why.count("complete") for cohort in cohorts.values())
        progress(done, len(studies))
    return tally


def power_from(simulation: Simulation, tallies: Sequence[Tally]) -> Power:
    """Return the power from the counts of studies; there is at least one. Errors: InputError."""
    total: Tally = {name: np.sum([tally[name] for tally in tallies], axis=0) for name in tallies[0]}
    comparisons, populations, scale = simulation.comparisons, simulation.populations(), simulation.scale
    studies = int(total["studies"])

    def each(name: str, k: int) -> Iterator[tuple[Comparison, int]]:
        return zip(comparisons, map(int, total[name][k]), strict=True)

    return Power(
        design=simulation.design,
        scale=scale,
        at=tuple(
            PowerAt(
                n=n,
                found={one: proportion_of(hits, studies) for one, hits in each("found", k)},
                unlimited={one: proportion_of(hits, studies) for one, hits in each("unlimited", k)},
                all_found=proportion_of(int(total["all_found"][k]), studies),
                complete=float(total["complete"][k]) / len(populations) / studies,
                pairs={one: pairs / studies for one, pairs in each("pairs", k)},
            )
            for k, n in enumerate(simulation.ns)
        ),
        alpha=simulation.alpha,
        studies=studies,
        seed=simulation.seed,
        balanced=int(np.lcm.reduce([population.balanced for population in populations.values()])),
        complete_share=int(total["finished"]) / int(total["people"]),
        true_effect={
            comparison: expected_difference(populations[comparison.part], scale, comparison)
            for comparison in comparisons
        },
        planned={
            comparison: expected_difference(populations[comparison.part], scale, comparison, latent=True)
            for comparison in comparisons
        },
    )


def expected_difference(population: Population, scale: Scale, comparison: Comparison, *, latent: bool = False) -> float:
    """Return how much better `better` is rated than the baseline in the mean of all people.

    Of pairs: by how many JOD it is better.
    """
    if scale.kind == PREFERENCE:
        return expected_jod(population, scale, comparison)
    names = [condition.name for condition in population.part.conditions]
    rated = population.expected(scale.name, latent=latent)
    out = float(rated[names.index(comparison.baseline)] - rated[names.index(comparison.better)])
    return out if scale.low_is_good else -out


def differences(
    cohort: Cohort, scale: Scale, comparison: Comparison, *, latent: bool = False, people: slice = slice(None)
) -> Floats:
    """Return how much better `better` was rated than the baseline, by each who rated both.

    Of pairs: how often it was chosen, less how often the baseline was.
    """
    if scale.kind == PREFERENCE:
        return choice_differences(cohort, scale, comparison, latent=latent, people=people)
    rated = cohort.per_condition(scale.name, latent=latent, people=people)
    names = [condition.name for condition in cohort.part.conditions]
    out = rated[:, names.index(comparison.baseline)] - rated[:, names.index(comparison.better)]
    return (out if scale.low_is_good else -out)[~np.isnan(out)]


def significant(design: Design, found: dict[Comparison, Floats], alpha: float) -> dict[Comparison, bool]:
    """Return which comparisons are significant after Holm over each of their families.

    found: the differences of each comparison.
    """
    ps = {one: wilcoxon_exact(values).p for one, values in found.items()}
    out = dict.fromkeys(found, True)
    for family in design.families:
        adjusted = holm([ps[comparison] for comparison in family.comparisons])
        for comparison, p in zip(family.comparisons, adjusted, strict=True):
            out[comparison] &= p <= alpha
    return out


def _count(tally: Tally, k: int, simulation: Simulation, cohorts: dict[str, Cohort]) -> None:
    """Count one study of the first ns[k] people of each cohort."""
    people, comparisons = slice(simulation.ns[k]), simulation.comparisons
    for latent, name in ((False, "found"), (True, "unlimited")):
        rated = {
            comparison: differences(
                cohorts[comparison.part], simulation.scale, comparison, latent=latent, people=people
            )
            for comparison in comparisons
        }
        found = significant(simulation.design, rated, simulation.alpha)
        tally[name][k] += [found[comparison] for comparison in comparisons]
        if not latent:
            tally["all_found"][k] += all(found.values())
            tally["pairs"][k] += [len(rated[comparison]) for comparison in comparisons]
    tally["complete"][k] += sum(cohort.why[people].count("complete") for cohort in cohorts.values())


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
