"""What is found in made-up ratings whose truth is known, and in tables of several sites.

What is said of them, and of tables of others: tables/.
"""

from __future__ import annotations

import json
from pathlib import Path

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats
from statsmodels.formula.api import ols
from statsmodels.stats.anova import anova_lm

from hmdwarp.base import InputError
from hmdwarp.study.analysis.findings import Resampling, families_for, load_claims, order_effects, preference_results
from hmdwarp.study.analysis.full_analysis import analyse, said_of_preferences
from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo, SourceOptions, from_csv, ratings_from_all
from hmdwarp.study.design import Comparison, Family
from hmdwarp.study.scales import NEITHER

from .tables import GRADE, PUBLISHED, in_order, judges, pairs_of, ratings_of, simulated

ACR = ScaleInfo("acr", "Quality", low_is_good=False, least=1, most=5)
PAIR = (Family("one", (Comparison("", "late", "warped"),)),)
LATE, WARPED = [5, 4, 5, 4.5, 6, 5, 4, 5], [3, 3, 2.5, 4, 4, 3, 3.5, 3]


def first(late: list, warped: list, **more) -> dict:
    """The row of the only comparison."""
    ratings = ratings_of({"late": late, "warped": warped}, **more)
    return analyse(attrs.evolve(ratings, families=PAIR))["scales"][0]["comparisons"][0]


def test_positive_means_better_whichever_way_the_scale_goes():
    low = first(LATE, WARPED)
    high = first([7 - v for v in LATE], [7 - v for v in WARPED], measure=ACR)
    for name in ("mean", "p", "differences"):
        assert low[name] == high[name]
    assert low["mean"] > 0 and low["better"] == 8


def test_too_many_people_for_the_exact_test_are_refused():
    told = "1001 participants rated both of two conditions: the exact test takes 1000"
    with pytest.raises(InputError, match=told):
        first([3.0] * 1001, [3.0] * 1001)


GRADES = st.lists(st.one_of(st.none(), st.integers(4, 24).map(lambda quarters: quarters / 4)), min_size=5, max_size=5)


@settings(max_examples=30)
@given(GRADES, GRADES, GRADES)
def test_any_ratings_give_json_without_nan(a, b, c):
    ratings = attrs.evolve(ratings_of({"late": a, "warped": b, "reference": c}, reference="reference"), families=PAIR)
    json.dumps(analyse(ratings), allow_nan=False)


def test_a_drift_is_found_with_its_size_and_carry_over_too():
    found = order_effects(in_order(effect=0.2))
    # 96 ratings, noise 0.3, places of variance 1.25: the slope's standard error is about 0.3 /
    # sqrt(96 * 1.25) = 0.03.
    assert found["place"]["p"] < 0.001 and found["place"]["slope"] == pytest.approx(0.2, abs=0.12)
    assert found["place"]["low"] <= 0.2 <= found["place"]["high"]
    carried = order_effects(in_order(carry=0.4))["previous"]
    assert carried["p"] < 0.001 and carried["df"] == 4


def test_the_f_test_is_the_one_of_statsmodels_type_ii_table():
    rows = in_order(effect=0.05, carry=0.1)
    formula = "value ~ C(participant) + C(condition) + place + C(previous)"
    table = anova_lm(ols(formula, rows).fit(), typ=2)
    found = order_effects(rows)
    assert found["place"]["f"] == pytest.approx(table.loc["place", "F"], rel=1e-9)
    # What came before the first trial is nothing, which the place tells too: of five levels the
    # table counts four, as here.
    assert found["previous"]["f"] == pytest.approx(table.loc["C(previous)", "F"], rel=1e-9)


def test_a_claim_without_a_step_is_rounded_to_its_last_digit_and_a_wrong_file_has_a_line(tmp_path):
    path = tmp_path / "claims.toml"
    claims = ("latency_ms = 200\ndifference = 1.50", 'better = "q"\nbaseline = "p"\ndifference = 2.0')
    path.write_text('title = "it"\n' + "".join(f'[[claim]]\npart = "x"\n{claim}\n' for claim in claims))
    assert [claim.step for claim in load_claims(path).claims] == [0.01, 0.1]
    begin = 'title = "it"\n[[claim]]\npart = "x"\n'
    wrong = {"difference = 1\n": 4, 'latency_ms = "soon"\n': 4, "latency_ms = 1\nfoo = 2\n": 5}
    for text, line in [*wrong.items(), ("difference = \n", 4)]:
        path.write_text(begin + text)
        with pytest.raises(InputError, match=rf"claims\.toml:{line}: "):
            load_claims(path)


def test_scales_come_as_the_plan_has_them_whatever_was_answered_first():
    rows = [row for scale in (ACR, GRADE) for row in ratings_of({"x": [4.0]}, measure=scale).rows.to_dict("records")]
    scales = {"grade": GRADE, "acr": ACR, "slider": ScaleInfo("slider", "Other", low_is_good=False)}
    assert Ratings(rows, scales).rated_scales() == ["grade", "acr"]


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


def test_conditions_of_settings_are_compared_at_each_latency_or_as_requested():
    found = from_csv(PUBLISHED)
    assert found.conditions("run 1")[0] == "none, 200 ms"
    families, why = families_for(found)
    assert [len(family.comparisons) for family in families] == [3, 3]
    assert "at each latency" in why
    families, _ = families_for(found, ["run 1/none, 200 ms:none, 800 ms"])
    (only,) = families[0].comparisons
    assert (only.part, only.baseline, only.better) == ("run 1", "none, 200 ms", "none, 800 ms")
    each = "run 1/none, 200 ms:none, 400 ms", "run 1/none, 400 ms:none, 800 ms"
    rows = [analyse(found, families=asked)["scales"][0]["comparisons"] for asked in (each, each[:1], each[1:])]
    assert [(row["holm"], row["holm_of"]) for row in rows[0]] == [(row["p"], 1) for row in rows[1] + rows[2]]
    with pytest.raises(InputError, match="expected pairs of conditions"):
        families_for(found, ["a-b"])


def exported(path: Path, participant: str, session: int = 1, scale: str = "grade", **more: str) -> str:
    """A table as a site exports it; more: columns."""
    head = ",".join(["participant", "session", "scale", "trial", "condition", "value", *({"origin": ""} | more)])
    last = ",".join(({"origin": "person"} | more).values())
    rows = [f"{participant},{session},{scale},{one},{last}" for one in ("1,late,4", "2,warped,2.5")]
    path.write_text("\n".join([head, *rows, ""]), encoding="utf-8")
    return str(path)


def test_tables_of_several_sites_are_one_study(tmp_path):
    one, two = exported(tmp_path / "berlin.csv", "k3x"), exported(tmp_path / "paris.csv", "w9q")
    options = SourceOptions()
    both = ratings_from_all([one, two], None, options)
    found = [*both.rows[["participant", "condition", "value"]].itertuples(index=False, name=None)]
    assert found == [("k3x", "late", 4.0), ("k3x", "warped", 2.5), ("w9q", "late", 4.0), ("w9q", "warped", 2.5)]
    assert both.source == "berlin.csv, paris.csv"
    assert analyse(both)["participants"] == 2
    second = exported(tmp_path / "again.csv", "k3x", session=2)
    assert analyse(ratings_from_all([one, second], None, options))["participants"] == 1
    assert ratings_from_all([one], None, options).rows.equals(from_csv(tmp_path / "berlin.csv").rows)


def test_tables_that_do_not_go_together_are_refused(tmp_path):
    one = exported(tmp_path / "berlin.csv", "k3x")
    own = exported(tmp_path / "own.csv", "w9q", scale="stars", low_is_good="true")
    turned = exported(tmp_path / "turned.csv", "k3x", scale="stars", low_is_good="false")
    for first, second, says in (
        (one, exported(tmp_path / "copy.csv", "k3x"), "has session 1 of participant 'k3x', as .*berlin.csv has"),
        (one, exported(tmp_path / "made.csv", "w9q", origin="simulated"), "of origin 'simulated', and 'person' in"),
        (one, str(tmp_path / "none.csv"), "expected a table of ratings that is there"),
        (one, "quick", "export each study first"),
        (own, turned, "scale 'stars' is another one"),
    ):
        with pytest.raises(InputError, match=says):
            ratings_from_all([first, second], None, SourceOptions())
