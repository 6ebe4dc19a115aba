"""How many people a study needs.

The simulation against theory, against the analysis, and as a command.
"""

from __future__ import annotations

import csv
import json
import re

import attrs
import numpy as np
import pytest
from commands import hmdwarp
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image
from scipy.stats import binomtest, norm

from hmdwarp.cli.study.plan import power as command
from hmdwarp.errors import InputError
from hmdwarp.experiments.sweep import KeptOptions
from hmdwarp.report.study import comparison_lines
from hmdwarp.study.analysis.findings import Resampling, compared
from hmdwarp.study.design import Comparison, Family, load_design
from hmdwarp.study.power import Simulation, sentences, simulate
from hmdwarp.study.power.planned_models import planned_model, with_effect
from hmdwarp.study.power.simulation import (
    differences,
    expected_difference,
    people_for,
    power_from,
    proportion_of,
    significant,
    tally_of,
)
from hmdwarp.study.respondents import Population, load_model

from . import tiny
from .made_up import simulate_study

PLAN_COMPARES = 'compare = [{ better = "warped", baseline = "late" }]\n#'
DESIGN, THESIS = load_design("quick"), load_design("thesis")
GRADE = DESIGN.scales[0]


def power_of(model, design, scale, ns, studies, seed=0):
    simulation = Simulation(model, design, scale, tuple(ns), seed=seed)
    return power_from(simulation, [tally_of(simulation, range(studies))])


@given(st.integers(1, 5000), st.data())
def test_shares_have_wilsons_interval(total, data):
    hits = data.draw(st.integers(0, total))
    found = proportion_of(hits, total)
    wanted = binomtest(hits, total).proportion_ci(0.95, "wilson")
    assert (found.low, found.high) == pytest.approx((wanted.low, wanted.high), abs=1e-9)


def test_how_many_to_invite():
    """Of 15 who come with probability 0.9, at least 12 come with probability 0.944.

    Of 14 with 0.842.
    """
    assert people_for(12, 0.9, sure=0.9) == 15
    assert people_for(12, 0.9, sure=0.84) == 14
    assert people_for(12, 1.0) == 12
    assert people_for(12, 0.001) is None


def test_simulated_significance_equals_the_analysis():
    """Twenty studies, both families of the thesis, through ratings and tables as study analyse
    takes them.
    """
    model = load_model("thesis")
    for study in range(20):
        ratings = simulate_study(THESIS, model, 12, seed=3, study=study)
        rows = compared(ratings, "grade", THESIS.families, Resampling(resamples=100))
        cohorts = {part.name: Population(model, THESIS, part.name).of(range(12), 3, study) for part in THESIS.parts}
        given_ = {c: differences(cohorts[c.part], GRADE, c) for family in THESIS.families for c in family.comparisons}
        found = significant(THESIS, given_, 0.05)
        for row in rows:
            one = Comparison(row["part"], row["baseline"], row["condition"])
            assert found[one] == (row["holm"] <= 0.05)
            assert sorted(given_[one]) == pytest.approx(sorted(row["differences"].values()))


@pytest.mark.parametrize("scale", ["grade", "slider"])  # low is good; high is good
def test_every_command_names_a_comparison_by_the_sign_that_it_prints(tmp_path, scale):
    """A warp that is better by planning: "warped over late" in plan, power and analysis, and a
    positive figure beside it, whichever way the scale goes.
    """
    study = tmp_path / "s.toml"
    study.write_text(tiny.STUDY.replace('"grade"', f'"{scale}"').replace("pairs = [", PLAN_COMPARES), encoding="utf-8")
    design = load_design(str(study))
    assert "warped over late" in hmdwarp("study", "plan", study).stdout
    planned = ("--effect", 3, "--sd", 0.5, "--n", 6, "--studies", 10, "--out", tmp_path / "power")
    said = hmdwarp("study", "power", study, *planned).stdout
    assert "warped over late (a true mean difference of +" in " ".join(said.split())
    (row,) = csv.DictReader((tmp_path / "power" / "power.csv").read_text(encoding="utf-8").splitlines())
    assert (row["condition"], row["baseline"], float(row["true_effect"]) > 0) == ("warped", "late", True)

    model = planned_model(design, design.scales[0], 3.0, 0.5)
    (compares,) = compared(simulate_study(design, model, 6, seed=1), scale, design.families, Resampling(resamples=100))
    assert (compares["condition"], compares["baseline"], compares["mean"] > 0) == ("warped", "late", True)
    assert comparison_lines([compares])[1][0][0] == "main: warped over late"


def one_comparison():
    """A single test on a scale without ends or steps worth the name."""
    wide = attrs.evolve(GRADE, least=-1000.0, most=1000.0, step=1e-3)
    family = Family("one", (Comparison(DESIGN.parts[0].name, "late", "warped"),))
    return attrs.evolve(DESIGN, scales=(wide,), families=(family,), sickness=None)


@pytest.mark.slow(12)
def test_power_is_that_of_the_signed_rank_test():
    """At effect / sd = 1 a t test of 12 has 0.88 (noncentral t), one of 12 x 3 / pi has 0.86.

    That is the signed-rank test's efficiency. The exact level is 0.0425 here, which takes a little
    more; 3 standard errors of 2000 studies are 0.024.
    """
    design = one_comparison()
    found = power_of(
        planned_model(design, design.scales[0], 1.0, 1.0), design, design.scales[0], [12], studies=2000, seed=1
    )
    (share,) = found.at[0].found.values()
    assert 0.82 < share.value < 0.90
    assert found.true_effect == pytest.approx({design.families[0].comparisons[0]: 1.0})
    assert found.complete_share == 1


@pytest.mark.slow(15)
def test_without_an_effect_the_power_is_the_level():
    design = one_comparison()
    found = power_of(
        planned_model(design, design.scales[0], 0.0, 1.0), design, design.scales[0], [8, 20], studies=2000, seed=2
    )
    for at_n in found.at:
        (share,) = at_n.found.values()
        assert share.low < 0.05  # an exact test's level is at most that: 0.039 with 8, 0.048 with 20


def test_the_ends_of_the_scale_take_power():
    """At the better end of the scale nothing can be told apart any more.

    Without ends and steps it could.
    """
    model = planned_model(DESIGN, GRADE, 1.0, 0.8)
    means = {name: mean - 2.5 for name, mean in model.ratings["grade"].means[DESIGN.parts[0].name].items()}
    at_the_end = attrs.evolve(model, ratings={"grade": attrs.evolve(model.ratings["grade"], means=means)})
    found = power_of(at_the_end, DESIGN, GRADE, [12], studies=300, seed=1)
    for one, share in found.at[0].found.items():
        assert share.value < found.at[0].unlimited[one].value - 0.1
        assert found.true_effect[one] < 0.75 * found.planned[one]
    assert any("on a scale without ends and steps, and is" in text for text in sentences(found, 0.8))


def test_the_true_difference_is_that_of_all_people_however_few_are_simulated():
    """By hand on a scale of two answers, 0 and 1: the share of ratings above 0.5."""
    coin = attrs.evolve(GRADE, least=0.0, most=1.0, step=1.0)
    design = attrs.evolve(DESIGN, scales=(coin,), sickness=None)
    model = planned_model(design, coin, 0.5, 1.0)
    (few, many) = (power_of(model, design, coin, [n], studies=10, seed=n) for n in (3, 40))
    assert few.true_effect == many.true_effect and few.planned == many.planned
    means = model.ratings["grade"].means[DESIGN.parts[0].name]
    for comparison in design.families[0].comparisons:
        assert few.planned[comparison] == pytest.approx(0.5, abs=1e-12)
        share = {name: norm.cdf(mean - 0.5) for name, mean in means.items()}  # latent_sd is 1 where --sd is 1
        assert few.true_effect[comparison] == pytest.approx(
            share[comparison.baseline] - share[comparison.better], abs=1e-12
        )


def test_the_true_difference_counts_drift_and_carry_over_as_simulated_people_do():
    """4 standard errors of 16,000 people, whose differences spread by 0.71."""
    model = with_effect(attrs.evolve(load_model("quick"), dropout=0.0), DESIGN, GRADE, 0.5)
    design = attrs.evolve(DESIGN, sickness=None)
    population = Population(model, design, DESIGN.parts[0].name)
    cohort = population.of(range(16_000), 1)
    for comparison in design.families[0].comparisons:
        for latent in (False, True):
            values = differences(cohort, GRADE, comparison, latent=latent)
            true = expected_difference(population, GRADE, comparison, latent=latent)
            assert values.mean() == pytest.approx(true, abs=4 * values.std() / np.sqrt(len(values)))


def test_more_people_find_more_and_dropouts_cost():
    model = load_model("quick")
    found = power_of(model, DESIGN, GRADE, [8, 12], studies=200, seed=1)
    assert found.balanced == 4
    less = power_of(attrs.evolve(model, dropout=0.2), DESIGN, GRADE, [8, 12], studies=200, seed=1)
    for comparison in found.true_effect:
        assert found.at[0].found[comparison].value <= found.at[1].found[comparison].value
        assert less.at[0].found[comparison].value < found.at[0].found[comparison].value
        assert less.at[1].pairs[comparison] < found.at[1].pairs[comparison] <= 12
    told = " ".join(sentences(less, 0.8))
    assert "do not finish" in told and "complete sessions plan" in told


def test_enough_is_from_where_on_it_stays_enough():
    found = power_of(load_model("quick"), DESIGN, GRADE, [4, 8, 12, 16], studies=100, seed=1)
    wanted = found.enough(0.8)
    assert wanted is not None and wanted.n in (8, 12)
    assert found.at[0].found and found.enough(1.01) is None


@pytest.mark.parametrize("sign", [True, False])
def test_planned_effects_point_to_the_better_one(sign):
    scale = attrs.evolve(GRADE, low_is_good=sign)
    design = attrs.evolve(DESIGN, scales=(scale,), sickness=None)
    model = planned_model(design, scale, 0.5, 1.0)
    cohort = Population(model, design, DESIGN.parts[0].name).of(range(8000), 1)
    for comparison in design.families[0].comparisons:
        values = differences(cohort, scale, comparison, latent=True)
        assert values.mean() == pytest.approx(0.5, abs=0.045)  # 4 standard errors of 1 / sqrt(8000)
        assert values.std() == pytest.approx(1.0, abs=0.032)


def test_effects_that_contradict_each_other_are_refused():
    part = DESIGN.parts[0].name
    circle = Family(
        "round",
        (Comparison(part, "late", "warped"), Comparison(part, "warped", "turned"), Comparison(part, "turned", "late")),
    )
    with pytest.raises(InputError, match="cycle"):
        with_effect(load_model("quick"), attrs.evolve(DESIGN, families=(circle,)), GRADE, 0.5)
    with pytest.raises(InputError, match="no .*family"):
        power_of(load_model("quick"), attrs.evolve(DESIGN, families=()), GRADE, [12], studies=10)


@pytest.mark.slow(20)
def test_the_command_writes_a_table_a_plot_and_sentences(tmp_path):
    asked = ("study", "power", "quick", "--effect", "0.8", "--sd", "1", "--n", "8..16", "--studies", "100")
    said = tiny.ran(*asked, "--out", tmp_path)
    assert "people who begin" in said and "it is found in" in said
    data = json.loads((tmp_path / "power.json").read_text())
    (scale,) = data["scales"]
    assert scale["scale"] == "grade" and [row["n"] for row in scale["rows"]] == [8, 12, 16] * 2
    assert all(0 <= row["power_low"] <= row["power"] <= row["power_high"] <= 1 for row in scale["rows"])
    assert (tmp_path / "power.csv").read_text().count("\n") == 7
    picture = np.asarray(Image.open(tmp_path / "power.png"))
    assert picture.shape[0] > 300 and picture.std() > 10
    again = tmp_path / "again"
    assert tiny.ran(*asked, "--quiet", "--out", again) == ""
    assert all((again / name).read_bytes() == (tmp_path / name).read_bytes() for name in ("power.json", "power.csv"))


def test_power_is_a_set_of_cases_that_can_be_resumed(tmp_path):
    """80 studies are two cases; of 120 studies, the first 50 were done before."""
    asked = ("study", "power", "quick", "--n", "8,12", "--out", tmp_path)
    assert hmdwarp(*asked, "--studies", 80).returncode == 0
    done = {path.name: path.stat().st_mtime_ns for path in (tmp_path / "cases").iterdir()}
    assert len(done) == 2
    again = hmdwarp(*asked, "--studies", 120, "--resume")
    assert again.returncode == 0 and "1 of 3 cases are kept from before" in again.stderr
    rows = json.loads((tmp_path / "power.json").read_text())["scales"][0]["rows"]
    whole = power_of(load_model("quick"), DESIGN, GRADE, [8, 12], studies=120, seed=1)
    assert [row["power"] for row in rows] == [
        at.found[comparison].value for comparison in whole.true_effect for at in whole.at
    ]
    assert len([*(tmp_path / "cases").iterdir()]) == 4  # what another number of studies needs stays
    assert all((tmp_path / "cases" / name).stat().st_mtime_ns == time for name, time in done.items())


@pytest.mark.slow(10)
def test_on_a_cluster_the_power_is_the_same(tmp_path):
    pytest.importorskip("distributed")
    simulation = Simulation(load_model("quick"), DESIGN, GRADE, (8,))
    (found,), _ = simulate([simulation], 20, tmp_path, KeptOptions(cluster="local:1"))
    assert found == power_of(load_model("quick"), DESIGN, GRADE, [8], studies=20)


@pytest.fixture
def two_scales(tmp_path):
    """A study that asks on two scales after each trial."""
    study = tmp_path / "two.toml"
    study.write_text(tiny.STUDY.replace('scales = ["grade"]', 'scales = ["acr", "slider"]'), encoding="utf-8")
    return study


EFFECT = ("--effect", 0.5, "--sd", 1, "--n", "8,12", "--studies", 20)


def test_a_study_with_two_scales_is_planned_on_both_or_on_one(two_scales, tmp_path):
    said = tiny.ran("study", "power", two_scales, *EFFECT, "--out", tmp_path / "both")
    assert "acr: Quality in five grades (ACR)" in said and "slider: Quality, continuous" in said
    assert "in the units of each scale" in said
    both = json.loads((tmp_path / "both" / "power.json").read_text())["scales"]
    assert [power["scale"] for power in both] == ["acr", "slider"]
    tiny.ran("study", "power", two_scales, *EFFECT, "--scale", "slider", "--out", tmp_path / "one")
    assert json.loads((tmp_path / "one" / "power.json").read_text())["scales"] == both[1:]
    rows = list(csv.DictReader((tmp_path / "both" / "power.csv").read_text(encoding="utf-8").splitlines()))
    assert [row["scale"] for row in rows] == ["acr"] * 4 + ["slider"] * 4


def test_a_model_of_one_scale_plans_that_scale(two_scales, tmp_path):
    model = tmp_path / "acr.toml"
    model.write_text(tiny.MODEL.format(**tiny.USUAL).replace("rating.grade", "rating.acr"), encoding="utf-8")
    asked = ("study", "power", two_scales, "--model", model, "--n", "8", "--studies", 20, "--out", tmp_path / "out")
    done = tiny.program(*asked)
    assert done.returncode == 2 and "no [rating.slider]" in done.stderr and "--scale (acr" in done.stderr
    assert "people who begin" in tiny.ran(*asked, "--scale", "acr")


@pytest.mark.parametrize(
    ("asked", "says"),
    [
        ({"n": "12-40"}, "--n 12-40: expected a range like 6..40"),
        ({"n": "0"}, "expected numbers of people, from 1 to 1000"),
        ({"n": "6..1001"}, "expected numbers of people, from 1 to 1000"),
        ({"n": "9..5"}, "--n 9..5: runs backwards: expected the smaller number first, 5..9"),
        ({"effect": float("nan")}, "--effect nan"),
        ({"effect": 1.0, "sd": 0.0}, "--sd 0: expected a number above 0"),
        ({"sd": 1.0}, "expected --effect and --sd"),
        ({"sd": 1.0, "model": "quick"}, "leave one out"),
        ({"model": "nowhere.toml"}, "nowhere.toml: no such file"),
        ({"scale": "acr"}, "--scale acr"),
    ],
)
def test_wrong_options_are_refused(asked, says, tmp_path):
    with pytest.raises(InputError, match=re.escape(says)):
        command(study="quick", out=tmp_path / "out", **{"n": "6..40", **asked})
    assert not (tmp_path / "out").exists()


def test_the_command_refuses_a_wrong_option_in_one_line(tmp_path):
    done = hmdwarp("study", "power", "quick", "--out", tmp_path / "out", "--n", "many")
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "--n many" in done.stderr
