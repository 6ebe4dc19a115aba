"""Paired comparisons of simulated people with known scores: model, store, analysis, export."""

from __future__ import annotations

import pytest
from scipy import stats

from hmdwarp.study.analysis.findings import Resampling, preference_results
from hmdwarp.study.analysis.full_analysis import analyse, said_of_preferences
from hmdwarp.study.analysis.long_table import Ratings
from hmdwarp.study.design import design_from_text
from hmdwarp.study.respondents import Population, model_from_text
from hmdwarp.study.scales import NEITHER

STUDY = """schema = 1
name = "pairs"
title = "Which is better?"
seed = 4
[common]
scene = "planes"
[trial]
shows = "pair"
seconds = 1
repeats = {repeats}
order = "{order}"
scales = ["{scale}"]
[[condition]]
name = "late"
latency = 400
warp = "none"
fill = "none"
[[condition]]
name = "turned"
latency = 400
warp = "rotation"
[[condition]]
name = "warped"
latency = 400
warp = "forward"
[[condition]]
name = "reference"
latency = 0
warp = "none"
fill = "none"
reference = true
[[family]]
name = "a warp against none"
compare = [{{ better = "warped", baseline = "late" }}, {{ better = "turned", baseline = "late" }}]
"""
MODEL = """schema = 1
title = "people with known scores"
[rating.{scale}]
noise_sd = {noise}
condition_sd = {taste}
threshold = {threshold}
[rating.{scale}.means]
late = -2.0
turned = -1.4
warped = -0.8
reference = 0.0
"""
SCORES = {"late": -2.0, "turned": -1.4, "warped": -0.8, "reference": 0.0}
STUDIES_OF_PAIRS, PEOPLE = 150, 14


def design_of(scale: str = "preference", order: str = "williams", repeats: int = 1):
    text = STUDY.format(scale=scale, order=order, repeats=repeats)
    return design_from_text(text, "pairs.toml", checked=False)


def simulated(design, model, study: int, people: int = PEOPLE) -> Ratings:
    """A whole study, without pictures."""
    scale = design.scales[0]
    population = Population(model, design, "main")
    cohort = population.of(range(people), 7, study)
    orders = population._orders[population._allotted(cohort.why)]  # noqa: SLF001  (who saw what first)
    names = [condition.name for condition in cohort.part.conditions]
    said = [
        {"participant": f"p{k}", "part": "main", "scale": scale.name, "first": names[first], "second": names[second]}
        | {"answer": float(answer), "allows_ties": scale.allows_ties, "reference": "reference"}
        for k in range(people)
        for (first, second), answer in zip(orders[k], cohort.answers[scale.name][k], strict=True)
    ]
    return Ratings(rows=(), scale_info={}, preferences=said, families=design.families)


def test_an_analysis_states_scores_and_votes():
    design = design_of("preference_or_tie")
    model = model_from_text(MODEL.format(scale="preference_or_tie", noise=1.0, taste=0.2, threshold=0.6), "test")
    ratings = simulated(design, model, 1, people=20)
    (found,) = said_of_preferences(preference_results(ratings, design.families, Resampling()))
    assert (found["people"], found["answers"], found["missing"]) == (20, 120, 0)
    assert found["ties"] == (ratings.preferences["answer"] == NEITHER).sum() > 0
    assert found["threshold"] > 0
    reference = next(row for row in found["conditions"] if row["reference"])
    assert (reference["jod"], reference["low"]) == (0, None)
    row = found["comparisons"][0]
    own = [pair for pair in ratings.preferences.itertuples() if {pair.first, pair.second} == {"late", "warped"}]
    preferred = [{1: answer.first, 2: answer.second}.get(answer.answer, "") for answer in own]
    assert (row["for"], row["against"], row["neither"]) == tuple(map(preferred.count, ("warped", "late", "")))
    net = preferred.count("warped") + preferred.count("late")
    # Each person saw the pair once: the exact test of their choices is that of signs.
    assert row["p"] == pytest.approx(stats.binomtest(preferred.count("warped"), net).pvalue)
    assert row["holm_of"] == 2
    assert f"in {row['for']} of 20 answers" in row["sentence"]
    assert "of choices would go to it" in row["sentence"]


def test_few_people_and_no_answers():
    design = design_of()
    model = model_from_text(MODEL.format(scale="preference", noise=1.0, taste=0.0, threshold=0.0), "test")
    for people in (5, 6):  # 126 and 462 resamples that differ; five who agree have p = 2 / 2^5
        some = simulated(design, model, 1, people=people)
        (found,) = said_of_preferences(preference_results(some, design.families, Resampling()))
        row = found["comparisons"][0]
        assert (row["low"] is None) == ("who give no interval. 5 people" in row["sentence"]) == (people == 5)
    pair = {"participant": "a", "scale": "preference", "first": "x", "second": "y", "answer": None}
    (found,) = analyse(Ratings(rows=(), scale_info={}, preferences=[pair]))["preferences"]
    assert found["sentences"] == ["No pair was compared."]
