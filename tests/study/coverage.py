"""How often the intervals and tests of the analysis are right, over studies of simulated people
whose effects are known.

`make test-statistics` checks it over 400 studies, and more over 150 to 200.

Everything of a study but the pictures: balanced orders with drift and carry-over, dropouts (whose
order goes to the next), sickness, answers nobody could give, a scale with steps and ends. The true
values are those of 20,000 people who all come to the end.
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from scipy.stats import binom, t

from hmdwarp.study.analysis.findings import Resampling, preference_results
from hmdwarp.study.design import Comparison, Design, load_design
from hmdwarp.study.respondents import Model, SicknessModel, load_model
from hmdwarp.study.statistics import JOD_SPREAD, attained_level, bca, hodges_lehmann, holm, wilcoxon_exact

from .analysis.tables import SCORES, cohort_of, differences, judges, pairs_of, simulated, unlimited

PART, MANY, LEVEL, STUDIES, STUDIES_OF_PAIRS = "run-1", 20_000, 0.95, 400, 150
FAR = 1e-9  # an end of an interval and a true value that are equal but for the last digits
SURE = 0.999  # that a right method stays within the bounds of a test


def designed() -> tuple[Design, Model]:
    """The first run of the thesis, by people who leave more often, get used to it and judge by what
    was before.
    """
    design, model = load_design("thesis"), load_model("thesis")
    design = attrs.evolve(design, parts=(design.part(PART),), families=(design.families[0],))
    rating = attrs.evolve(model.ratings["grade"], drift=0.03, carry_over=-0.05, missing=0.05)
    return design, attrs.evolve(model, ratings={"grade": rating}, dropout=0.02)


def everybody(model: Model) -> Model:
    """The same people, who all come to the end and can always say."""
    rating = attrs.evolve(model.ratings["grade"], missing=0.0)
    return attrs.evolve(model, ratings={"grade": rating}, dropout=0.0, sickness=SicknessModel())


def true_values(design: Design, model: Model) -> dict[Comparison, tuple[float, float]]:
    """(mean, median of the means of all pairs) of the difference, by a large draw."""
    cohort = cohort_of(everybody(model), design, PART, range(MANY), seed=999)
    out = {}
    for comparison in design.families[0].comparisons:
        values = differences(cohort, design.scales[0], comparison)
        out[comparison] = (float(values.mean()), pseudomedian(values))
    return out


def pseudomedian(values: np.ndarray) -> float:
    """Of so many values that their pairs are too many. The pairs of each with 50 others, drawn,
    tell it to 0.005 of the spread.
    """
    others = np.random.default_rng(0).integers(0, len(values), (50, len(values)))
    return float(np.median((values + values[others]) / 2))


def coverage(design: Design, model: Model, n: int, studies: int, seed: int) -> dict[str, np.ndarray]:
    """Over so many studies of n people who begin, of each comparison: how many differences there
    were, the level that the interval of the shift says it has, whether it holds the true value,
    also of ratings without steps and ends, and whether that of the mean does.
    """
    comparisons = design.families[0].comparisons
    felt = unlimited(design)
    true, latent_true = true_values(design, model), true_values(felt, model)
    scale = design.scales[0]
    shape = (studies, len(comparisons))
    pairs, promised = np.zeros(shape, int), np.zeros(shape)
    shift, latent_shift, mean = (np.zeros(shape, bool) for _ in range(3))
    complete = 0
    for study in range(studies):
        cohort, same = (cohort_of(model, one, PART, range(n), seed + 1000 * study) for one in (design, felt))
        complete += cohort.why.count("complete")
        for k, one in enumerate(comparisons):
            values, latent = differences(cohort, scale, one), differences(same, scale, one)
            pairs[study, k], promised[study, k] = len(values), attained_level(len(values))
            shift[study, k] = holds(hodges_lehmann(values)[1:], true[one][1])
            latent_shift[study, k] = holds(hodges_lehmann(latent)[1:], latent_true[one][1])
            mean[study, k] = holds(bca(values), true[one][0])
    found = {"pairs": pairs, "promised": promised, "shift": shift, "latent": latent_shift, "mean": mean}
    return {**found, "dropped": np.array(1 - complete / (n * studies))}


def holds(interval: tuple[float, float], value: float) -> bool:
    return interval[0] - FAR <= value <= interval[1] + FAR


def without_effect(design: Design, model: Model, n: int, studies: int, seed: int) -> tuple[np.ndarray, float]:
    """p of (studies, comparisons) without an effect, and how often Holm leaves anything."""
    means = {condition.name: 3.5 for condition in design.part(PART).conditions}
    model = attrs.evolve(model, ratings={"grade": attrs.evolve(model.ratings["grade"], means=means)})
    scale, ps = design.scales[0], []
    for study in range(studies):
        cohort = cohort_of(model, design, PART, range(n), seed + 1000 * study)
        ps.append([wilcoxon_exact(differences(cohort, scale, each)).p for each in design.families[0].comparisons])
    return np.array(ps), float(np.mean([min(holm(one)) <= 1 - LEVEL for one in ps]))


def expected_bca(pairs: np.ndarray) -> float:
    """What the bootstrap's interval of a mean covers when ratings are normal, to the order that n =
    12 calls for. The bootstrap takes the standard deviation over n, not n - 1, and the normal's
    quantiles, not Student's: mean +- z s sqrt((n - 1)/n) / sqrt(n) covers with P(|t| < z sqrt((n -
    1)/n)). BCa mends skewness, not that (Efron and Tibshirani 1993, 14.3; Hesterberg 2015, 3.2).
    """
    z = 1.959964
    return float((1 - 2 * t.sf(z * np.sqrt((pairs - 1) / pairs), pairs - 1)).mean())


def bounds(share: float, total: int) -> tuple[float, float]:
    """Between which a share that is truly this one stays, SURE of the time, in so many independent
    tries.
    """
    tail = (1 - SURE) / 2
    return float(binom.ppf(tail, total, share) / total), float(binom.isf(tail, total, share) / total)


@pytest.mark.parametrize("n", [12, 24])
def test_known_effects_come_back_inside_their_intervals_at_the_nominal_rate(n):
    found = coverage(*designed(), n, STUDIES, seed=1)
    assert found["dropped"] > 0.05  # with people who leave among them
    for k in range(found["pairs"].shape[1]):
        least, most = bounds(found["promised"][:, k].mean(), STUDIES)
        # Exact where differences are continuous and symmetric; steps make many pairwise means equal
        # to the true one, which only adds.
        assert least <= found["latent"][:, k].mean() <= most
        assert found["shift"][:, k].mean() >= least
        # The bootstrap of so few is short by a known amount, and by no more: what is promised is
        # what theory says, not 95 %.
        least, most = bounds(expected_bca(found["pairs"][:, k]), STUDIES)
        assert least <= found["mean"][:, k].mean() <= most


@pytest.mark.parametrize("n", [12, 24])
def test_no_effect_is_found_where_there_is_none(n):
    ps, share = without_effect(*designed(), n, STUDIES, seed=2)
    assert share <= bounds(1 - LEVEL, STUDIES)[1]  # Holm over three
    for level in (0.01, 0.05, 0.1, 0.2):
        assert ((ps <= level).mean(axis=0) <= bounds(level, STUDIES)[1]).all()


@pytest.mark.parametrize(("scale", "taste"), [("preference", 0.0), ("preference_or_tie", 0.6)])
def test_known_scores_lie_in_their_intervals_at_the_nominal_rate(scale, taste):
    """95 % intervals hold the true score in 95 % of 150 studies, as the binomial tells: fewer than
    the bound come once in 1000 times at that rate, and so do more. Case V counts what differs
    between people as noise: a score of q is then one of q / sqrt(1 + 2 (taste / JOD_SPREAD)^2).
    """
    design = pairs_of(scale, repeats=2)
    model = judges(scale, noise=JOD_SPREAD / np.sqrt(2), taste=taste, threshold=0.5)
    shrunk = 1 / np.sqrt(1 + 2 * (taste / JOD_SPREAD) ** 2)
    held = dict.fromkeys(("late", "turned", "warped", "warped over late"), 0)
    for study in range(STUDIES_OF_PAIRS):
        (found,) = preference_results(simulated(design, model, study), design.families, Resampling(study, 400))
        for row in found["conditions"]:
            if not row["reference"]:
                held[row["condition"]] += row["low"] <= SCORES[row["condition"]] * shrunk <= row["high"]
        row = found["comparisons"][0]
        held["warped over late"] += row["low"] <= (SCORES["warped"] - SCORES["late"]) * shrunk <= row["high"]
    least, most = binom.ppf((0.001, 0.999), STUDIES_OF_PAIRS, 0.95)
    assert all(least <= count <= most for count in held.values()), held
