"""What is said of made-up ratings whose truth is known.

Comparisons, order, doubles, claims, the reference, and the words for them.
"""

from __future__ import annotations

import json
import re

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.errors import InputError
from hmdwarp.report.study import render_study_report, study_lines
from hmdwarp.study.analysis.findings import copied_rows, load_claims, order_effects
from hmdwarp.study.analysis.full_analysis import analyse, sentence_of_copied, sentences_of_order
from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo, frame
from hmdwarp.study.design import Comparison, Family

from .tables import GRADE, in_order, ratings_of

pytest.importorskip("statsmodels", reason="statsmodels is not installed (pip install '.[study]')")

ACR = ScaleInfo("acr", "Quality", low_is_good=False, least=1, most=5)
PAIR = (Family("one", (Comparison("", "late", "warped"),)),)
LATE, WARPED = [5, 4, 5, 4.5, 6, 5, 4, 5], [3, 3, 2.5, 4, 4, 3, 3.5, 3]


def first(ratings: Ratings) -> dict:
    """The only comparison's row."""
    return analyse(attrs.evolve(ratings, families=PAIR))["scales"][0]["comparisons"][0]


def test_positive_means_better_whichever_way_the_scale_goes():
    low = first(ratings_of({"late": LATE, "warped": WARPED}))
    high = first(ratings_of({"late": [7 - v for v in LATE], "warped": [7 - v for v in WARPED]}, measure=ACR))
    assert low["mean"] == high["mean"] > 0 and low["p"] == high["p"] and low["better"] == 8
    assert low["differences"] == high["differences"]


@pytest.mark.parametrize(("late", "warped", "way"), [(5, 4, "better"), (4, 5, "worse")])
def test_where_most_rate_alike_the_others_still_say_which_way(late, warped, way):
    """Seven pairs one way, nineteen alike.

    P = 2/2^7, though the shift, which counts the nineteen, is 0.
    """
    row = first(ratings_of({"late": [late] * 7 + [4] * 19, "warped": [warped] * 7 + [4] * 19}))
    assert row["shift"] == 0 and row["p"] == 2 / 2**7
    assert row["sentence"].endswith(f"'warped' was rated {way}.")


def test_too_many_people_for_the_exact_test_are_refused():
    many = ratings_of({"late": [3.0] * 1001, "warped": [3.0] * 1001})
    with pytest.raises(InputError, match="1001 participants rated both of two conditions: the exact test takes 1000"):
        first(many)


ALIKE, NOT_SHOWN, SIMILAR = [4] * 8, [4, 3, 5, 4, 3.5, 4, 5, 3], [3, 4, 4, 4.5, 3, 5, 4, 3]
SAID = [  # ratings of `late` and of `warped`; what their sentence says
    (LATE, WARPED, "8 of 8 rated 'warped' better than 'late', 0 worse; mean difference +1.56 grades (95 % "),
    (LATE, WARPED, "By the exact test p = .0078: 'warped' was rated better."),
    (ALIKE, [4] * 7 + [3], "1 unequal pair cannot give a p below 1.000, so this comparison shows nothing either way."),
    (NOT_SHOWN, SIMILAR, "no difference is shown, "),
    (NOT_SHOWN, SIMILAR, "which does not mean that there is none"),
    (NOT_SHOWN, SIMILAR, "the ratings fit anything from a loss of"),
    (NOT_SHOWN, SIMILAR, "to a gain of"),
    ([5, 5, 6, 5], [1, 2, 1, 1.5], "4 unequal pairs cannot give a p below .125, so this comparison shows nothing"),
    ([5, 5, 6, 5], [1, 2, 1, 1.5], "either way, whatever the ratings."),
    ([5, None], [None, 3], "cannot be compared"),
]


@pytest.mark.parametrize(("late", "warped", "said"), SAID, ids=[said[:30] for *_, said in SAID])
def test_a_comparison_says_what_was_found_and_no_more(late, warped, said):
    """A difference that is not shown is not called none; alike pairs are not too few people."""
    row = first(ratings_of({"late": late, "warped": warped}))
    assert said in row["sentence"]
    assert (row["n"] == 0) == (row["holm"] is None) == ("cannot be compared" in row["sentence"])


def test_unrated_parts_show_no_order_and_no_p():
    ratings = ratings_of({"late": [None, None], "warped": [None, None]})
    data = analyse(attrs.evolve(ratings, rows=ratings.rows.assign(place=1)))
    (part,) = data["scales"][0]["parts"]
    assert part["order_sentences"] == ["Effects of order cannot be estimated: nothing was rated."]
    assert study_lines("comparisons", data["scales"][0]["comparisons"])[1][0].count("1.000") == 0
    render_study_report(data, "")


def test_names_in_a_chart_break_between_words_and_fills():
    ratings = ratings_of({"late": LATE, "forward + interpolate+composite, 800 ms": WARPED})
    page = render_study_report(analyse(ratings), "")
    assert ">interpolate+<" in page and ">composite<" in page


def test_one_pair_and_equal_pairs_have_no_interval_and_no_nan():
    for late, warped in (([5], [3]), ([5, 4, 3], [4, 3, 2]), ([4, 4], [4, 4])):
        row = first(ratings_of({"late": late, "warped": warped}))
        assert "no interval" in row["sentence"] and row["low"] is row["high"] is None
        json.dumps(row, allow_nan=False)
        _, ((name, _, _, bca, _, exact, *_),) = study_lines("comparisons", [row])
        assert name == "warped over late" and bca == "–" and (exact == "–") == (len(late) == 1)


def test_the_axis_of_equal_pairs_goes_from_a_grade_worse_to_one_better():
    """Text of an axis that reaches a billionth either way has its factor, 1e-9."""
    result = analyse(attrs.evolve(ratings_of({"late": [3.0] * 5, "warped": [3.0] * 5}), families=PAIR))
    words = re.findall(r">([^<>]*)</text>", render_study_report(result, ""))
    assert "1.0" in "".join(words) and not any(word.startswith("1e") for word in words)


def test_an_exact_interval_is_given_where_it_is_sure_of_anything():
    """Of one difference it is sure of nothing (0 %), of two by half (50 %): 1 - 2 / 2^n."""
    one, two = (first(ratings_of({"late": late, "warped": [3, 3]})) for late in ([5, None], [5, 4]))
    assert one["shift"] == 2.0 and one["shift_low"] is one["shift_high"] is one["shift_level"] is None
    assert "(bootstrap +1.00 to +2.00, which is too short for 95 % with 2 pairs)" in two["sentence"]
    assert (two["shift_low"], two["shift_high"], two["shift_level"]) == (1.0, 2.0, 0.5)


def test_an_unrated_planned_comparison_counts_in_its_family():
    families = (Family("two", (Comparison("", "late", "warped"), Comparison("", "late", "other"))),)
    ratings = ratings_of({"late": LATE, "warped": WARPED, "other": [None] * 8})
    rows = analyse(attrs.evolve(ratings, families=families))["scales"][0]["comparisons"]
    assert rows[0]["holm"] == 2 * rows[0]["p"] and rows[1]["n"] == 0


def test_the_order_of_the_rows_changes_nothing():
    ratings = attrs.evolve(ratings_of({"late": LATE, "warped": WARPED, "other": LATE[::-1]}), families=PAIR)
    shuffled = attrs.evolve(ratings, rows=ratings.rows.sample(frac=1, random_state=1))
    assert json.dumps(analyse(shuffled)["scales"][0]["comparisons"]) == json.dumps(
        analyse(ratings)["scales"][0]["comparisons"]
    )


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
    from statsmodels.formula.api import ols
    from statsmodels.stats.anova import anova_lm

    rows = in_order(effect=0.05, carry=0.1)
    formula = "value ~ C(participant) + C(condition) + place + C(previous)"
    table = anova_lm(ols(formula, rows).fit(), typ=2)
    found = order_effects(rows)
    assert found["place"]["f"] == pytest.approx(table.loc["place", "F"], rel=1e-9)
    # What came before the first trial is nothing, which the place tells too: of five levels the
    # table counts four, as here.
    assert found["previous"]["f"] == pytest.approx(table.loc["C(previous)", "F"], rel=1e-9)


def test_carry_over_is_no_slope_per_trial():
    """One condition shown four times: before it was nothing, or itself.

    One column, but not of numbers.
    """
    rows = [row for k in range(6) for row in repeated(k)]
    found = order_effects(frame(rows))
    assert "slope" in found["place"] and found["previous"]["df"] == 1 and "slope" not in found["previous"]


def repeated(person: int) -> list[dict]:
    grades = np.random.default_rng(person).integers(1, 7, 4).tolist()
    return [
        {"participant": f"p{person}", "condition": "c", "value": float(v), "place": k, "previous": "c" * (k > 1)}
        for k, v in enumerate(grades, 1)
    ]


def test_confounded_effects_are_named():
    """Of two conditions shown once each, "second" and "after the other one" are the same trials."""
    random, rows = np.random.default_rng(3), []
    for person in range(12):
        order = "ab" if person % 2 else "ba"
        for place, name in enumerate(order, 1):
            value = float(3 + place + random.normal(0, 0.3))
            rows.append(
                {"participant": f"p{person}", "condition": name, "value": value, "place": place}
                | {"previous": order[0] if place == 2 else ""}
            )
    found = order_effects(frame(rows))
    assert found["place"]["f"] == pytest.approx(found["previous"]["f"]) and found["place"]["p"] < 0.05
    said = sentences_of_order(found, GRADE)
    assert said[0].endswith("it changed the ratings; here it is confounded with the condition shown before.")
    assert said[1].endswith("it changed the ratings; here it is confounded with the place of a trial.")


def test_one_order_for_all_is_confounded_with_the_conditions():
    rows = in_order()
    rows = rows[rows["participant"].isin(("p0", "p4", "p8", "p12"))]  # the square has four rows
    assert all("all participants saw them in the same order" in one["why_not"] for one in order_effects(rows).values())


# --- doubles


def joined(*made: Ratings) -> Ratings:
    return Ratings([row for one in made for row in one.rows.to_dict("records")], {"grade": GRADE})


def two_parts(second: list[list[float]]) -> Ratings:
    """A first part of eight people, and this second one."""
    random = np.random.default_rng(5)
    parts = {"one": random.integers(4, 24, (8, 3)) / 4, "two": np.array(second)}
    made = [ratings_of({f"c{k}": values[:, k].tolist() for k in range(3)}, part) for part, values in parts.items()]
    return joined(*made)


def test_a_rating_of_minus_one_is_not_a_missing_one():
    """On a scale from -3 to 3, as that of comparison category rating."""

    def copies(*second: float | None) -> list[dict]:
        first = ratings_of({"late": [-1], "warped": [-1], "other": [2]}, part="1")
        again = ratings_of({"late": [second[0]], "warped": [second[1]], "other": [second[2]]}, part="2")
        return copied_rows(joined(first, again), "grade", 1)

    assert copies(None, None, 2) == []
    assert copies(-1, -1, 2)[0]["rows"][0]["ratings"] == [-1, -1, 2]


def test_copied_rows_are_found_and_others_are_not():
    free = (np.random.default_rng(6).integers(4, 24, (6, 3)) / 4).tolist()
    assert copied_rows(two_parts(free), "grade", 1) == []
    taken = two_parts(free)
    source = taken.table("one", "grade").to_numpy()[:3].tolist()
    (found,) = copied_rows(two_parts([*free[:3], *source]), "grade", 1)
    assert [(row["first"], row["second"]) for row in found["rows"]] == [("a", "d"), ("b", "e"), ("c", "f")]
    assert found["people"] == 3 and found["by_chance"] < 0.001


def test_equal_rows_on_a_coarse_scale_are_called_likely():
    rows = [[1.0, 1.0, 1.0], [1.0, 2.0, 1.0]] * 3
    made = [ratings_of({f"c{k}": [row[k] for row in rows] for k in range(3)}, part) for part in ("one", "two")]
    (found,) = copied_rows(joined(*made), "grade", 1)
    assert found["by_chance"] > 0.5 and found["within"] > 0
    assert "no sign of copying" in sentence_of_copied(found) and "most likely" not in sentence_of_copied(found)


# --- claims


def test_a_claim_without_a_step_is_rounded_to_its_last_digit(tmp_path):
    path = tmp_path / "claims.toml"
    claims = ("latency_ms = 200\ndifference = 1.50", 'better = "q"\nbaseline = "p"\ndifference = 2.0')
    path.write_text('title = "it"\n' + "".join(f'[[claim]]\npart = "x"\n{claim}\n' for claim in claims))
    assert [claim.step for claim in load_claims(path).claims] == [0.01, 0.1]


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ('title = "it"\n[[claim]]\npart = "x"\ndifference = 1\n', "claims.toml:4: "),
        ('title = "it"\n[[claim]]\npart = "x"\nlatency_ms = "soon"\n', "claims.toml:4: "),
        ('title = "it"\n[[claim]]\npart = "x"\nlatency_ms = 1\nfoo = 2\n', "claims.toml:5: "),
        ("title = \n", "claims.toml:1: "),
    ],
)
def test_a_wrong_file_of_claims_is_refused_with_its_line(tmp_path, text, told):
    path = tmp_path / "claims.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=told.replace(".", r"\.")):
        load_claims(path)


def test_scales_come_as_the_plan_has_them_whatever_was_answered_first():
    on_acr, on_grade = ratings_of({"x": [4.0]}, measure=ACR), ratings_of({"x": [2.0]})
    both = Ratings(
        joined(on_acr, on_grade).rows.to_dict("records"),
        {"grade": GRADE, "acr": ACR, "slider": ScaleInfo("slider", "Other", low_is_good=False)},
    )
    assert both.rated_scales() == ["grade", "acr"]


REFERENCE = [  # (ratings by condition, what is said of the reference); 1 is the best grade
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
    (
        {"late": [5], "warped": [4], "best": [1]},
        "The only participant who rated the hidden reference rated it better than the median of their other ratings.",
    ),
]


@pytest.mark.parametrize(("values", "says"), REFERENCE, ids=["tied for worst", "flat", "mixed", "unrated", "one"])
@pytest.mark.parametrize("turned", [False, True], ids=["low is good", "high is good"])
def test_a_tie_with_the_reference_is_a_tie(values, says, turned):
    scale = attrs.evolve(GRADE, low_is_good=not turned)
    values = {name: [7 - v if turned and v is not None else v for v in column] for name, column in values.items()}
    (part,) = analyse(ratings_of(values, reference="best", measure=scale))["scales"][0]["parts"]
    assert part["reference_sentence"] == says
