"""Power of the exact tests: against simulation, closed forms and published numbers of people."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from commands import hmdwarp
from scipy.special import ndtr
from scipy.stats import binom, binomtest

from hmdwarp.study.design import power_as_json, power_rows
from hmdwarp.study.statistics import (
    JOD_SPREAD,
    people_for_sign,
    people_for_signed_rank,
    sign_power,
    signed_rank_power,
)

from ..analysis.tables import pairs_of

DOCS = (Path(__file__).parents[3] / "docs" / "study-analysis.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("effect", [0.0, 0.5, 1.2])
def test_six_people_must_all_differ_in_one_direction(effect):
    assert signed_rank_power(6, effect, 0.05) == pytest.approx(ndtr(effect) ** 6 + ndtr(-effect) ** 6, abs=1e-9)
    assert signed_rank_power(5, effect, 0.05) == 0


@pytest.mark.parametrize(("effect", "people"), [(0.3, 94), (0.5, 35)])
def test_published_numbers_of_people(effect, people):
    """G*Power 3.1 (Faul et al. 2007) for normal parents, two-sided, 5 % and 80 %.

    It takes Student's number divided by the efficiency 3 / pi of Hodges and Lehmann 1956.
    """
    assert people_for_signed_rank(effect, 0.05) == people
    assert signed_rank_power(people - 1, effect, 0.05) < 0.8 <= signed_rank_power(people, effect, 0.05)


@pytest.mark.parametrize(("people", "share"), [(5, 0.9), (17, 0.75), (40, 0.5)])
def test_the_sign_test_is_that_of_all_counts(people, share):
    found = sum(binom.pmf(k, people, share) for k in range(people + 1) if binomtest(k, people).pvalue <= 0.05)
    assert sign_power(people, share, 0.05) == pytest.approx(found, abs=1e-12)


def test_more_people_than_enough_are_enough():
    enough = people_for_sign(0.75, 0.05)
    assert sign_power(enough - 1, 0.75, 0.05) < 0.8
    assert all(sign_power(people, 0.75, 0.05) >= 0.8 for people in range(enough, 3 * enough))


def test_the_plan_says_the_power_of_its_test_and_what_it_assumes():
    whole = hmdwarp("study", "plan", "quick", "--people", "24").stdout
    assert "Power of one comparison" + DOCS.split("```text\nPower of one comparison")[1].split("```")[0] in whole
    said = " ".join(whole.split())
    assert "exact signed-rank test, p below 0.05 / 2" in said
    assert "independent people" in said and "which is normal" in said
    (found,) = json.loads(hmdwarp("study", "plan", "quick", "--people", "24", "--json").stdout)["power"]
    for row in found["effects"]:
        assert row["power"] == signed_rank_power(24, row["effect"], 0.05 / 2)
        assert f"{row['effect']:g} sd {row['power']:.0%} with 24 people" in said
        assert f"80% with {row['people_for_80_percent']} " in said


def test_a_plan_of_pairs_has_that_of_the_sign_test():
    (found,) = power_as_json(pairs_of(), 30)
    expected = [sign_power(30, ndtr(jod / JOD_SPREAD), 0.05 / 2) for jod in (0.5, 1, 1.5)]
    assert [row["power"] for row in found["effects"]] == pytest.approx(expected, rel=1e-12)
    said = dict(power_rows(found))
    assert said["test"].startswith("exact sign test, p below 0.05 / 2") and "1 JOD, 75% of all" in said["assumed"]
    assert said["1 JOD"] == f"{expected[1]:.0%} with 30 people, 80% with {people_for_sign(0.75, 0.05 / 2)}"
