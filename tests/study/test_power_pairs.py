"""How many people a study of pairs needs: the simulation against theory, and as a command."""

from __future__ import annotations

import csv
import functools
import json
import math

import attrs
import numpy as np
import pytest
from commands import hmdwarp
from scipy.stats import binom, binomtest, multinomial, norm

from hmdwarp.errors import InputError
from hmdwarp.study.analysis.comparisons import Resampling
from hmdwarp.study.analysis.preferences import preference_results
from hmdwarp.study.power import Simulation, sentences
from hmdwarp.study.power.planned_models import choice_differences, expected_jod, pairs_model
from hmdwarp.study.power.simulation import differences, power_from, significant, tally_of
from hmdwarp.study.respondents import Population
from hmdwarp.study.respondents.response_model import model_from_text
from hmdwarp.study.statistics import JOD_SPREAD

from .analysis.test_preferences import MODEL, STUDY, design_of, simulated

ALPHA, STUDIES = 0.05, 400
TIE = 0.5  # as planned, JOD


def one_comparison(scale: str = "preference"):
    """A single test, so that Holm's correction does nothing."""
    design = design_of(scale)
    family = design.families[0]
    return attrs.evolve(design, families=(attrs.evolve(family, comparisons=family.comparisons[:1]),))


@functools.cache
def p_of(wins: int, losses: int) -> float:
    return binomtest(wins, wins + losses).pvalue


def sign_test_power(n: int, better: float, worse: float) -> float:
    """Of n people who choose once each: the share of studies whose exact sign test finds it.

    Who says "no difference" drops out of the test, as zeros do.
    """
    found = 0.0
    for wins in range(n + 1):
        for losses in range(n + 1 - wins):
            if wins + losses and p_of(wins, losses) <= ALPHA:
                found += multinomial.pmf([wins, losses, n - wins - losses], n, [better, worse, 1 - better - worse])
    return found


def expected_power(scale: str, jod: float, n: int) -> float:
    """The power by theory: choices of different people are independent, as each chooses once."""
    tie = TIE if scale == "preference_or_tie" else 0.0
    better, worse = norm.cdf([(jod - tie) / JOD_SPREAD, (-jod - tie) / JOD_SPREAD])
    return sign_test_power(n, better, worse)


@pytest.mark.parametrize("scale", ["preference", "preference_or_tie"])
@pytest.mark.parametrize("jod", [0.0, 1.0])
def test_power_is_that_of_the_sign_test_and_without_an_effect_its_level(scale, jod):
    """The count of studies lies where it does in all but 1 of 10,000 runs, by the binomial of the
    power that theory gives. That is at most the nominal level without an effect, and grows with
    people with one.
    """
    design = one_comparison(scale)
    people = [8, 16, 32]
    asked = design.scales[0]
    simulation = Simulation(pairs_model(design, asked, jod), design, asked, tuple(people), ALPHA, 3)
    found = power_from(simulation, [tally_of(simulation, range(STUDIES))])
    theory = [expected_power(scale, jod, n) for n in people]
    for at_n, power in zip(found.at, theory, strict=True):
        (share,) = at_n.found.values()
        low, high = binom.interval(1 - 1e-4, STUDIES, power)
        assert low <= share.hits <= high
        assert at_n.complete == at_n.n
        assert list(at_n.pairs.values()) == [at_n.n]
    if jod:
        shares = [next(iter(at_n.found.values())).value for at_n in found.at]
        assert shares == sorted(shares) and theory == sorted(theory)
        assert list(found.true_effect.values()) == pytest.approx([jod])
        assert "+1.00 JOD: preferred in 75% of forced choices" in sentences(found, 0.8)[0]
        unlimited = [next(iter(at_n.unlimited.values())).value for at_n in found.at]
        assert all(one >= share for one, share in zip(unlimited, shares, strict=True))  # by how much tells more
    else:
        assert max(theory) <= ALPHA


@pytest.mark.parametrize(("scale", "repeats"), [("preference", 2), ("preference_or_tie", 1)])
def test_simulated_significance_equals_the_analysis(scale, repeats):
    design = design_of(scale, repeats=repeats)
    text = MODEL.format(scale=scale, noise=1.0, taste=0.5, threshold=TIE)
    model = model_from_text(text, "test")
    people = 10
    for study in range(20):
        (analysed,) = preference_results(
            simulated(design, model, study, people), design.families, Resampling(resamples=10)
        )
        cohort = Population(model, design, "main").of(range(people), 7, study)
        comparisons = design.families[0].comparisons
        given = {comparison: differences(cohort, design.scales[0], comparison) for comparison in comparisons}
        found = significant(design, given, ALPHA)
        for row, one in zip(analysed["comparisons"], comparisons, strict=True):
            assert (row["condition"], row["baseline"]) == (one.better, one.baseline)
            assert given[one].sum() == row["for"] - row["against"]
            assert found[one] == (row["holm"] <= ALPHA)


def test_taste_does_not_change_how_many_prefer_but_what_repeats_give():
    """1 JOD is 75 % of the choices of all people, whatever part of the spread is taste.

    4 standard errors of 6000 people. Where people differ in nothing, two answers of one person are
    as good as those of two; where they differ in taste alone, the second says nothing new.
    """
    design = design_of(repeats=2)
    comparison = design.families[0].comparisons[0]
    for sd, both in ((0.0, 0.75**2 + 0.25**2), (JOD_SPREAD, 1.0)):
        model = pairs_model(design, design.scales[0], 1.0, sd)
        population = Population(model, design, "main")
        assert expected_jod(population, design.scales[0], comparison) == pytest.approx(1.0)
        net = choice_differences(population.of(range(6000), 1), design.scales[0], comparison)
        assert len(net) == 6000 and set(np.unique(net)) <= {-2, 0, 2}
        assert (net.mean() / 2 + 1) / 2 == pytest.approx(0.75, abs=4 * math.sqrt(0.75 * 0.25 / 6000))
        assert (net != 0).mean() == pytest.approx(both, abs=4 * math.sqrt(0.25 / 6000))


def test_a_plan_that_cannot_be_simulated_is_refused():
    design = design_of()
    with pytest.raises(InputError, match=r"--sd 1\.5: expected 1\.48 at most"):
        pairs_model(design, design.scales[0], 1.0, 1.5)


def test_the_command_plans_pairs(tmp_path):
    plan = tmp_path / "pairs.toml"
    plan.write_text(STUDY.format(scale="preference_or_tie", order="williams", repeats=1), encoding="utf-8")
    asked = ("study", "power", plan, "--n", "12..150", "--studies", 10)
    said = " ".join(hmdwarp(*asked, "--effect", 1.2, "--out", tmp_path / "out").stdout.split())
    assert "warped over late (+1.20 JOD: preferred in 79% of forced choices)" in said
    rows = list(csv.DictReader((tmp_path / "out" / "power.csv").read_text(encoding="utf-8").splitlines()))
    people = ["12", "36", "60", "84", "108", "132"]  # of those that balance the orders, no more than fit a terminal
    assert [(row["scale"], row["n"]) for row in rows] == [("preference_or_tie", n) for n in people] * 2
    assert [float(row["true_effect"]) for row in rows] == pytest.approx([1.2] * 12)
    assert json.loads((tmp_path / "out" / "power.json").read_text())["scales"][0]["scale"] == "preference_or_tie"
    lacking = hmdwarp(*asked, "--out", tmp_path / "none")
    assert lacking.returncode == 2 and "expected --effect (in JOD), or --model FILE.toml" in lacking.stderr
