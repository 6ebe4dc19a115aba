"""Many studies of simulated people, each analysed as `study analyse` does: how often is a planned comparison found?"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np

from ...errors import InputError
from ..design import Comparison, Design
from ..respondents import Cohort, Floats, Model, Population
from ..scales import Scale
from ..statistics import wilcoxon_exact
from .shares import Share, share_of

Progress = Callable[[int, int], None]


@attrs.frozen
class Strength:
    """What n people find, who begin, in each part. found: by comparison, how often it is significant after Holm in its families. unlimited:
    likewise where ratings had neither steps nor ends. all_found: how often all are. complete: mean number of people who come to the end.
    pairs: mean number of people with both ratings, by comparison.
    """

    n: int
    found: dict[Comparison, Share]
    unlimited: dict[Comparison, Share]
    all_found: Share
    complete: float
    pairs: dict[Comparison, float]


@attrs.frozen
class Power:
    """balanced: multiples of that many people have all orders equally often. complete_share: of people who come to the end. true_effect:
    by comparison, the mean difference that ratings have, steps and ends of the scale included; planned: without them.
    """

    design: Design
    scale: Scale
    strengths: tuple[Strength, ...]
    alpha: float
    studies: int
    seed: int
    balanced: int
    complete_share: float
    true_effect: dict[Comparison, float]
    planned: dict[Comparison, float]

    def enough(self, wanted: float, comparison: Comparison | None = None) -> Strength | None:
        """The first from which on every larger n reaches the wanted power too; of all comparisons, each by itself, where none is named."""
        reached = None
        for one in reversed(self.strengths):
            shares = one.found.values() if comparison is None else (one.found[comparison],)
            if min(share.value for share in shares) < wanted:
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
    """ns: how many people begin, in each part. The first n of a study's people are the same for every n.

    Errors: InputError for a plan without families, and where the model lacks something of the study.
    """
    comparisons = tuple(dict.fromkeys(one for family in design.families for one in family.comparisons))
    if not comparisons:
        raise InputError(f"{design.path}: no [[family]] plans a comparison: there is nothing to find")
    parts = dict.fromkeys(one.part for one in comparisons)
    populations = {part: Population(model, design, part) for part in parts}
    counts = [_Count(n, comparisons) for n in ns]
    effects, people, complete = _Means(comparisons), 0, 0
    for study in range(studies):
        cohorts = {part: population.of(range(max(ns)), seed, study) for part, population in populations.items()}
        for count in counts:
            count.add(design, scale, cohorts, alpha)
        effects.add(cohorts, scale)
        people += sum(len(cohort.trials) for cohort in cohorts.values())
        complete += sum(cohort.why.count("complete") for cohort in cohorts.values())
        progress(study + 1, studies)
    return Power(
        design=design,
        scale=scale,
        strengths=tuple(count.strength() for count in counts),
        alpha=alpha,
        studies=studies,
        seed=seed,
        balanced=int(np.lcm.reduce([population.balanced for population in populations.values()])),
        complete_share=complete / people,
        true_effect=effects.of(latent=False),
        planned=effects.of(latent=True),
    )


def differences(
    cohort: Cohort, scale: Scale, comparison: Comparison, *, latent: bool = False, people: slice = slice(None)
) -> Floats:
    """How much better b was rated than a, for each of the people who rated both."""
    rated = cohort.per_condition(scale.name, latent=latent, people=people)
    names = [one.name for one in cohort.part.conditions]
    out = rated[:, names.index(comparison.a)] - rated[:, names.index(comparison.b)]
    return (out if scale.low_is_good else -out)[~np.isnan(out)]


def significant(design: Design, found: dict[Comparison, Floats], alpha: float) -> dict[Comparison, bool]:
    """Which comparisons are, after Holm over each family they are in. found: the differences of each."""
    ps = {one: wilcoxon_exact(values).p for one, values in found.items()}
    out = dict.fromkeys(found, True)
    for family in design.families:
        adjusted = _holm([ps[one] for one in family.comparisons])
        for one, p in zip(family.comparisons, adjusted, strict=True):
            out[one] &= p <= alpha
    return out


def _holm(ps: Sequence[float]) -> Floats:
    """As statistics.holm, to the last digit (a test compares them). statsmodels collects Python's garbage in each call, 30 ms: half an hour
    for a thousand studies, most of whose time else is a few seconds."""
    order = np.argsort(ps, kind="stable")
    stepped = np.maximum.accumulate(np.array(ps)[order] * np.arange(len(ps), 0, -1))
    out = np.empty(len(ps))
    out[order] = np.minimum(stepped, 1)
    return out


class _Count:
    """Of one n, over the studies."""

    def __init__(self, n: int, comparisons: Sequence[Comparison]) -> None:
        self._n, self._studies, self._all, self._complete = n, 0, 0, 0
        self._found, self._unlimited, self._pairs = (dict.fromkeys(comparisons, 0) for _ in range(3))

    def add(self, design: Design, scale: Scale, cohorts: dict[str, Cohort], alpha: float) -> None:
        people = slice(self._n)
        for latent, counted in ((False, self._found), (True, self._unlimited)):
            given = {one: differences(cohorts[one.part], scale, one, latent=latent, people=people) for one in counted}
            found = significant(design, given, alpha)
            for one, is_found in found.items():
                counted[one] += is_found
            if not latent:
                self._all += all(found.values())
                for one, values in given.items():
                    self._pairs[one] += len(values)
        self._complete += sum(cohort.why[people].count("complete") for cohort in cohorts.values()) / len(cohorts)
        self._studies += 1

    def strength(self) -> Strength:
        total = self._studies
        return Strength(
            n=self._n,
            found={one: share_of(hits, total) for one, hits in self._found.items()},
            unlimited={one: share_of(hits, total) for one, hits in self._unlimited.items()},
            all_found=share_of(self._all, total),
            complete=self._complete / total,
            pairs={one: pairs / total for one, pairs in self._pairs.items()},
        )


class _Means:
    """Of all differences of all studies."""

    def __init__(self, comparisons: Sequence[Comparison]) -> None:
        self._sums = {(one, latent): [0.0, 0] for one in comparisons for latent in (False, True)}

    def add(self, cohorts: dict[str, Cohort], scale: Scale) -> None:
        for (one, latent), total in self._sums.items():
            values = differences(cohorts[one.part], scale, one, latent=latent)
            total[0] += float(values.sum())
            total[1] += len(values)

    def of(self, *, latent: bool) -> dict[Comparison, float]:
        return {
            one: total[0] / max(total[1], 1) for (one, is_latent), total in self._sums.items() if is_latent == latent
        }
