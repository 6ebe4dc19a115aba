"""What is said of made-up ratings whose truth is known.

Comparisons, order, doubles, claims, the reference, and the words for them.
"""

from __future__ import annotations

import json

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from statsmodels.formula.api import ols
from statsmodels.stats.anova import anova_lm
from together import together

from hmdwarp.errors import InputError
from hmdwarp.report.study import render_study_report, study_lines
from hmdwarp.study.analysis.findings import copied_rows, load_claims, order_effects
from hmdwarp.study.analysis.full_analysis import analyse, sentence_of_copied, sentences_of_order
from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo, frame
from hmdwarp.study.design import Comparison, Family

from .tables import GRADE, in_order, ratings_of

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


@together("late, warped, way", [(5, 4, "better"), (4, 5, "worse")])
def test_where_most_rate_alike_the_others_still_say_which_way(late, warped, way):
    """Seven pairs one way, nineteen alike.

    P = 2/2^7, though the shift, which counts the nineteen, is 0.
    """
    row = first([late] * 7 + [4] * 19, [warped] * 7 + [4] * 19)
    assert row["shift"] == 0 and row["p"] == 2 / 2**7
    assert row["sentence"].endswith(f"'warped' was rated {way}.")


def test_too_many_people_for_the_exact_test_are_refused():
    told = "1001 participants rated both of two conditions: the exact test takes 1000"
    with pytest.raises(InputError, match=told):
        first([3.0] * 1001, [3.0] * 1001)


ALIKE, NOT_SHOWN, SIMILAR = [4] * 8, [4, 3, 5, 4, 3.5, 4, 5, 3], [3, 4, 4, 4.5, 3, 5, 4, 3]
FOUR, BETTER = [5, 5, 6, 5], [1, 2, 1, 1.5]
SAID = [  # ratings of `late` and of `warped`; what their sentence says
    (LATE, WARPED, "8 of 8 rated 'warped' better than 'late', 0 worse; mean difference +1.56 grades (95 % "),
    (LATE, WARPED, "By the exact test p = .0078: 'warped' was rated better."),
    (ALIKE, [4] * 7 + [3], "1 unequal pair cannot give a p below 1.000, so this comparison shows nothing either way."),
    (NOT_SHOWN, SIMILAR, "no difference is shown, "),
    (NOT_SHOWN, SIMILAR, "which does not mean that there is none"),
    (NOT_SHOWN, SIMILAR, "the ratings fit anything from a loss of"),
    (NOT_SHOWN, SIMILAR, "to a gain of"),
    (FOUR, BETTER, "4 unequal pairs cannot give a p below .125, so this comparison shows nothing"),
    (FOUR, BETTER, "either way, whatever the ratings."),
    ([5, None], [None, 3], "cannot be compared"),
    ([5, 4], [3, 3], "(bootstrap +1.00 to +2.00, which is too short for 95 % with 2 pairs)"),
]


@together("late, warped, said", SAID)
def test_a_comparison_says_what_was_found_and_no_more(late, warped, said):
    """A difference that is not shown is not called none; alike pairs are not too few people."""
    row = first(late, warped)
    assert said in row["sentence"]
    assert (row["n"] == 0) == (row["holm"] is None) == ("cannot be compared" in row["sentence"])


def test_unrated_parts_show_no_order_and_no_p():
    ratings = ratings_of({"late": [None, None], "warped": [None, None]})
    data = analyse(attrs.evolve(ratings, rows=ratings.rows.assign(place=1)))
    (part,) = data["scales"][0]["parts"]
    assert part["order_sentences"] == ["Effects of order cannot be estimated: nothing was rated."]
    assert study_lines("comparisons", data["scales"][0]["comparisons"])[1][0].count("1.000") == 0
    render_study_report(data, "")


def test_one_pair_and_equal_pairs_have_no_interval_and_no_nan():
    for late, warped in (([5], [3]), ([5, 4, 3], [4, 3, 2]), ([4, 4], [4, 4])):
        row = first(late, warped)
        assert "no interval" in row["sentence"] and row["low"] is row["high"] is None
        json.dumps(row, allow_nan=False)
        _, ((name, _, _, bca, _, exact, *_),) = study_lines("comparisons", [row])
        assert name == "warped over late" and bca == "–" and (exact == "–") == (len(late) == 1)


def test_an_exact_interval_is_given_where_it_is_sure_of_anything():
    """Of one difference it is sure of nothing (0 %), of two by half (50 %): 1 - 2 / 2^n."""
    one, two = first([5, None], [3, 3]), first([5, 4], [3, 3])
    assert one["shift"] == 2.0 and one["shift_low"] is one["shift_high"] is one["shift_level"] is None
    assert (two["shift_low"], two["shift_high"], two["shift_level"]) == (1.0, 2.0, 0.5)


def test_an_unrated_planned_comparison_counts_in_its_family_and_the_order_of_rows_does_not():
    families = (Family("two", (Comparison("", "late", "warped"), Comparison("", "late", "other"))),)
    ratings = attrs.evolve(ratings_of({"late": LATE, "warped": WARPED, "other": [None] * 8}), families=families)
    rows = analyse(ratings)["scales"][0]["comparisons"]
    assert rows[0]["holm"] == 2 * rows[0]["p"] and rows[1]["n"] == 0
    shuffled = attrs.evolve(ratings, rows=ratings.rows.sample(frac=1, random_state=1))
    assert json.dumps(analyse(shuffled)["scales"][0]["comparisons"]) == json.dumps(rows)


GRADES = st.lists(st.one_of(st.none(), st.integers(4, 24).map(lambda quarters: quarters / 4)), min_size=5, max_size=5)


@settings(max_examples=30)
@given(GRADES, GRADES, GRADES)
def test_any_ratings_give_json_without_nan(a, b, c):
    ratings = attrs.evolve(ratings_of({"late": a, "warped": b, "reference": c}, reference="reference"), families=PAIR)
    json.dumps(analyse(ratings), allow_nan=False)


# --- order


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


def shown(person: int, order: str, values: list[float]) -> list[dict]:
    """Rows of a person who rated conditions of one letter each in this order."""
    return [
        {"participant": f"p{person}", "condition": name, "value": value, "place": place, "previous": before}
        for place, (name, value, before) in enumerate(zip(order, values, ["", *order[:-1]], strict=True), 1)
    ]


def test_carry_over_is_no_slope_per_trial():
    """One condition shown four times: before it was nothing, or itself.

    One column, but not of numbers.
    """
    grades = np.random.default_rng(1).integers(1, 7, (6, 4)).astype(float)
    found = order_effects(frame([row for k in range(6) for row in shown(k, "cccc", grades[k].tolist())]))
    assert "slope" in found["place"] and found["previous"]["df"] == 1 and "slope" not in found["previous"]


def test_confounded_effects_are_named():
    """Of two conditions shown once each, "second" and "after the other one" are the same trials."""
    values = np.random.default_rng(3).normal([4, 5], 0.3, (12, 2)).tolist()
    found = order_effects(frame([row for k in range(12) for row in shown(k, "ab" if k % 2 else "ba", values[k])]))
    assert found["place"]["f"] == pytest.approx(found["previous"]["f"]) and found["place"]["p"] < 0.05
    said = sentences_of_order(found, GRADE)
    assert said[0].endswith("it changed the ratings; here it is confounded with the condition shown before.")
    assert said[1].endswith("it changed the ratings; here it is confounded with the place of a trial.")
    rows = in_order()
    rows = rows[rows["participant"].isin(("p0", "p4", "p8", "p12"))]  # the square has four rows
    assert all("all participants saw them in the same order" in one["why_not"] for one in order_effects(rows).values())


# --- doubles


def joined(*made: Ratings) -> Ratings:
    return Ratings([row for one in made for row in one.rows.to_dict("records")], {"grade": GRADE})


def parts(**rated: list[list[float | None]]) -> Ratings:
    """Of each part, the ratings of each participant."""
    columns = {part: list(zip(*rows, strict=True)) for part, rows in rated.items()}
    return joined(*(ratings_of({f"c{k}": list(c) for k, c in enumerate(of)}, part) for part, of in columns.items()))


def test_a_rating_of_minus_one_is_not_a_missing_one():
    """On a scale from -3 to 3, as that of comparison category rating."""
    assert copied_rows(parts(one=[[-1, -1, 2]], two=[[None, None, 2]]), "grade", 1) == []
    (found,) = copied_rows(parts(one=[[-1, -1, 2]], two=[[-1, -1, 2]]), "grade", 1)
    assert found["rows"][0]["ratings"] == [-1, -1, 2]


def test_copied_rows_are_found_and_others_are_not():
    chance = np.random.default_rng(5)
    one, two = ((chance.integers(4, 24, (people, 3)) / 4).tolist() for people in (8, 6))
    assert copied_rows(parts(one=one, two=two), "grade", 1) == []
    (found,) = copied_rows(parts(one=one, two=[*two[:3], *one[:3]]), "grade", 1)
    assert [(row["first"], row["second"]) for row in found["rows"]] == [("a", "d"), ("b", "e"), ("c", "f")]
    assert found["people"] == 3 and found["by_chance"] < 0.001


def test_equal_rows_on_a_coarse_scale_are_called_likely():
    rows = [[1.0, 1.0, 1.0], [1.0, 2.0, 1.0]] * 3
    (found,) = copied_rows(parts(one=rows, two=rows), "grade", 1)
    assert found["by_chance"] > 0.5 and found["within"] > 0
    assert "no sign of copying" in sentence_of_copied(found) and "most likely" not in sentence_of_copied(found)


# --- claims


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
    on_acr, on_grade = ratings_of({"x": [4.0]}, measure=ACR), ratings_of({"x": [2.0]})
    scales = {"grade": GRADE, "acr": ACR, "slider": ScaleInfo("slider", "Other", low_is_good=False)}
    assert Ratings(joined(on_acr, on_grade).rows.to_dict("records"), scales).rated_scales() == ["grade", "acr"]


REFERENCE = [  # ratings by condition, what is said of the reference; 1 is the best grade
    (
        {"late": [1] * 8, "warped": [4] * 8, "other": [4] * 8, "best": [4] * 8},  # tied for worst
        "All 8 who rated the hidden reference rated it the same as the median of their other ratings.",
    ),
    (
        {"late": [3, 3], "warped": [3, 3], "best": [3, 3]},
        "Both who rated the hidden reference rated it the same as the median of their other ratings. 2 of them gave "
        "everything the same rating, which shows nothing.",
    ),
    (
        {"late": [5, 5, 2, 3], "warped": [4, 4, 3, 3], "best": [1, 2, 5, 3]},
        "2 of 4 who rated the hidden reference rated it better than, 1 the same as and 1 worse than the median of "
        "their other ratings. 1 of them gave everything the same rating, which shows nothing. Worse: c. Their ratings "
        "are kept; the comparisons without them are listed as well.",
    ),
    ({"late": [5], "warped": [4], "best": [None]}, "The hidden reference was not rated."),
]


@together("values, says", REFERENCE)
def test_a_tie_with_the_reference_is_a_tie(values, says):
    for low_is_good in (True, False):
        rated = values if low_is_good else {k: [v and 7 - v for v in column] for k, column in values.items()}
        ratings = ratings_of(rated, reference="best", measure=attrs.evolve(GRADE, low_is_good=low_is_good))
        (part,) = analyse(ratings)["scales"][0]["parts"]
        assert part["reference_sentence"] == says
