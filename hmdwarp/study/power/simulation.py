"""Power by simulation: how often studies of simulated people find each planned comparison.

Each study is analysed as `study analyse` does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np

from ..design import Comparison, Design
from ..respondents import Cohort, Floats, Model, Population
from ..scales import PREFERENCE, Scale
from ..statistics import holm, wilcoxon_exact
from .pairs import choice_differences, expected_jod
from .planned_effects import planned_comparisons
from .proportions import Proportion, proportion_of

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
        for one in reversed(self.at):
            shares = one.found.values() if comparison is None else (one.found[comparison],)
            if min(share.value for share in shares) < target:
                break
            reached = one
        return reached


def power_of(
    model: Model,
    design: Design,
    scale: Scale,
    ns: Sequence[int],
    studies: int = 1000,
    alpha: float = 0.05,
    seed: int = 0,
    progress: Progress = lambda done, total: None,
) -> Power:
    """Simulate the study and return its power on one of its scales.

    ns: numbers of people who begin, in each part. The first n people of a study are the same for
    every n.
    Errors: InputError as planned_comparisons, and for a model that does not name a scale or a
    condition of the study.
    """
    comparisons = planned_comparisons(design)
    parts = dict.fromkeys(one.part for one in comparisons)
    model = attrs.evolve(model, others=None)  # means that rehearse any plan alike say nothing about this one
    populations = {part: Population(model, design, part, [scale.name]) for part in parts}
    counts = [_Count(n, comparisons) for n in ns]
    people, complete = 0, 0
    for study in range(studies):
        cohorts = {part: population.of(range(max(ns)), seed, study) for part, population in populations.items()}
        for count in counts:
            count.add(design, scale, cohorts, alpha)
        people += sum(len(cohort.trials) for cohort in cohorts.values())
        complete += sum(cohort.why.count("complete") for cohort in cohorts.values())
        progress(study + 1, studies)
    return Power(
        design=design,
        scale=scale,
        at=tuple(count.result() for count in counts),
        alpha=alpha,
        studies=studies,
        seed=seed,
        balanced=int(np.lcm.reduce([population.balanced for population in populations.values()])),
        complete_share=complete / people,
        true_effect={one: expected_difference(populations[one.part], scale, one) for one in comparisons},
        planned={one: expected_difference(populations[one.part], scale, one, latent=True) for one in comparisons},
    )


def expected_difference(population: Population, scale: Scale, comparison: Comparison, *, latent: bool = False) -> float:
    """Return how much better `better` is rated than the baseline in the mean of all people.

    Of pairs: by how many JOD it is better.
    """
    if scale.kind == PREFERENCE:
        return expected_jod(population, scale, comparison)
    names = [one.name for one in population.part.conditions]
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
    names = [one.name for one in cohort.part.conditions]
    out = rated[:, names.index(comparison.baseline)] - rated[:, names.index(comparison.better)]
    return (out if scale.low_is_good else -out)[~np.isnan(out)]


def significant(design: Design, found: dict[Comparison, Floats], alpha: float) -> dict[Comparison, bool]:
    """Return which comparisons are significant after Holm over each of their families.

    found: the differences of each comparison.
    """
    ps = {one: wilcoxon_exact(values).p for one, values in found.items()}
    out = dict.fromkeys(found, True)
    for family in design.families:
        adjusted = holm([ps[one] for one in family.comparisons])
        for one, p in zip(family.comparisons, adjusted, strict=True):
            out[one] &= p <= alpha
    return out


class _Count:
    """Counts over the studies, of one n."""

    def __init__(self, n: int, comparisons: Sequence[Comparison]) -> None:
        self._n, self._studies, self._all, self._complete = n, 0, 0, 0.0
        self._found, self._unlimited, self._pairs = (dict.fromkeys(comparisons, 0) for _ in range(3))

    def add(self, design: Design, scale: Scale, cohorts: dict[str, Cohort], alpha: float) -> None:
        people = slice(self._n)
        for latent, counted in ((False, self._found), (True, self._unlimited)):
            rated = {one: differences(cohorts[one.part], scale, one, latent=latent, people=people) for one in counted}
            found = significant(design, rated, alpha)
            for one, is_found in found.items():
                counted[one] += is_found
            if not latent:
                self._all += all(found.values())
                for one, values in rated.items():
                    self._pairs[one] += len(values)
        self._complete += sum(cohort.why[people].count("complete") for cohort in cohorts.values()) / len(cohorts)
        self._studies += 1

    def result(self) -> PowerAt:
        total = self._studies
        return PowerAt(
            n=self._n,
            found={one: proportion_of(hits, total) for one, hits in self._found.items()},
            unlimited={one: proportion_of(hits, total) for one, hits in self._unlimited.items()},
            all_found=proportion_of(self._all, total),
            complete=self._complete / total,
            pairs={one: pairs / total for one, pairs in self._pairs.items()},
        )
