"""Paired comparisons of simulated people with known scores: model, store, analysis, export."""

from __future__ import annotations

import pytest
from scipy import stats

from hmdwarp.study.analysis.findings import Resampling, preference_results
from hmdwarp.study.analysis.full_analysis import analyse, said_of_preferences
from hmdwarp.study.analysis.long_table import Ratings
from hmdwarp.study.scales import NEITHER

from .tables import judges, pairs_of, simulated


def test_an_analysis_states_scores_and_votes():
    design = pairs_of("preference_or_tie")
    ratings = simulated(design, judges("preference_or_tie", noise=1.0, taste=0.2, threshold=0.6), 1, people=20)
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
    design, model = pairs_of(), judges("preference", noise=1.0, taste=0.0, threshold=0.0)
    for people in (5, 6):  # 126 and 462 resamples that differ; five who agree have p = 2 / 2^5
        some = simulated(design, model, 1, people=people)
        (found,) = said_of_preferences(preference_results(some, design.families, Resampling()))
        row = found["comparisons"][0]
        assert (row["low"] is None) == ("who give no interval. 5 people" in row["sentence"]) == (people == 5)
    pair = {"participant": "a", "scale": "preference", "first": "x", "second": "y", "answer": None}
    (found,) = analyse(Ratings(rows=(), scale_info={}, preferences=[pair]))["preferences"]
    assert found["sentences"] == ["No pair was compared."]
