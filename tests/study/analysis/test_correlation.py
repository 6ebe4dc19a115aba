"""Within-person correlations: against pingouin, published figures and made-up studies."""

from __future__ import annotations

import warnings

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.report.study import study_page
from hmdwarp.study.analysis.findings import MEASURES, correlation_data, within_people
from hmdwarp.study.analysis.full_analysis import analyse
from hmdwarp.study.analysis.long_table import Ratings, ScaleInfo

FLIP, HOLES = "measured_flip", "measured_hole_share"
# pH and PaCO2 (kPa) of eight people: Bland and Altman 1995, BMJ 310, 446.
BLAND = """
1 6.68 3.97 6.53 4.12 6.43 4.09 6.33 3.97
2 6.85 5.27 7.06 5.37 7.13 5.41 7.17 5.44
3 7.40 5.67 7.42 3.64 7.41 4.32 7.37 4.73 7.34 4.96 7.35 5.04 7.28 5.22 7.30 4.82 7.34 5.07
4 7.36 5.67 7.33 5.10 7.29 5.53 7.30 4.75 7.35 5.51
5 7.35 4.28 7.30 4.44 7.30 4.32 7.37 3.23 7.27 4.46 7.28 4.72 7.32 4.75 7.32 4.99
6 7.38 4.78 7.30 4.73 7.29 5.12 7.33 4.93 7.31 5.03 7.33 4.93
7 6.86 6.85 6.94 6.44 6.92 6.52
8 7.19 5.28 7.29 4.56 7.21 4.34 7.25 4.32 7.20 4.41 7.19 3.69 6.77 6.09 6.82 5.58
"""


def row(participant, condition, value, measures):
    asked = {"part": "main", "scale": "grade", "low_is_good": True}
    return {"participant": participant, "condition": condition, "value": value, **asked, **measures}


def made_up(seed, effects, people=12, conditions=8, noise=0.5):
    """Rows of a study. Measures are drawn for each condition, tremble with each person, and move
    the grade.
    """
    rng = np.random.default_rng(seed)
    levels = {name: rng.normal(size=conditions) for name in effects}
    rows = []
    for person in range(people):
        own = rng.normal(3, 0.7)
        for c in range(conditions):
            x = {name: levels[name][c] + 0.05 * rng.normal() for name in effects}
            value = own + sum(effects[name] * x[name] for name in effects) + noise * rng.normal()
            rows.append(row(f"p{person}", f"c{c}", value, x))
    return rows


def found_in(rows, scale="grade"):
    return correlation_data(pd.DataFrame(rows), scale)


ROWS = made_up(4, {FLIP: 0.5, HOLES: 0.2})


def test_the_published_correlation_comes_out():
    """r = -0.51, p = 0.0008, 38 degrees of freedom; the interval is that of pingouin 0.5."""
    people = [np.array(line.split(), float) for line in BLAND.strip().splitlines()]
    table = pd.DataFrame([(one[0], x, y) for one in people for x, y in one[1:].reshape(-1, 2)], columns=["who", *"xy"])
    found = within_people(table["x"], table["y"], table["who"])
    assert (round(found.r, 2), round(found.p, 4), found.dof) == (-0.51, 0.0008, 38)
    assert (round(found.low, 2), round(found.high, 2)) == (-0.71, -0.23)


@pytest.mark.parametrize("seed", range(3))
def test_the_correlation_is_pingouins(seed):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pingouin = pytest.importorskip("pingouin", reason="pingouin is not installed (pip install '.[test]')")
        rows = [one for k, one in enumerate(made_up(seed, {FLIP: 0.6, HOLES: -0.2})) if k % 7]  # unequal numbers
        for measure in found_in(rows)["measures"]:
            theirs = pingouin.rm_corr(pd.DataFrame(rows), x=measure["name"], y="value", subject="participant").iloc[0]
            assert measure["r"] == pytest.approx(theirs["r"], abs=1e-9) and measure["dof"] == theirs["dof"]
            assert measure["p"] == pytest.approx(theirs[[n for n in theirs.index if n.startswith("p")][0]], rel=1e-6)
            assert [measure["low"], measure["high"]] == pytest.approx(theirs["CI95"], abs=0.006)


@settings(max_examples=30)
@given(st.integers(0, 1000), st.sampled_from([1e-200, 1e-9, 1.0, 1e9]), st.floats(-10, 10))
def test_units_levels_and_order_play_no_part(seed, scale, shift):
    rows = made_up(seed, {FLIP: 0.5}, people=5)
    other = [one | {FLIP: one[FLIP] * scale, "value": one["value"] + shift} for one in reversed(rows)]
    one, same = (found_in(of)["measures"][0] for of in (rows, other))
    keys = ("r", "low", "high", "p", "dof")
    assert [same[key] for key in keys] == pytest.approx([one[key] for key in keys], abs=1e-6)


def test_untestable_measures_are_named_with_their_reason():
    rows = made_up(3, {FLIP: 0.5, HOLES: 0.2})
    for k, one in enumerate(rows):
        one["actual_missed_share"] = 0.0
        one["measured_ssim"] = 0.9 if k == 0 else None
        one[HOLES] = one[HOLES] if k % 20 else None
        one["actual_pose_age_ms_median"] = float(one["participant"][1:])  # differs between people alone
    found = found_in(rows)
    reasons = dict(found["left_out"])
    assert [measure["name"] for measure in found["measures"]] == [FLIP, HOLES]
    assert reasons["missed refreshes"] == reasons["age of the pose"] == "the same in all trials of each person"
    assert reasons["structural similarity (SSIM)"] == "too few ratings"
    assert reasons["flicker"] == "not measured; 'study measure' does it"
    assert [measure["dof"] for measure in found["measures"]] == [96 - 13, 96 - 5 - 13]
    assert any(said.startswith("Not tested: ") and "flicker" in said for said in found["sentences"])


def test_what_cannot_be_compared_has_a_reason_and_no_figure():
    assert found_in([row("p", "c", 1.0, {})]) is None
    alike = [one | {"measured_size": "320x400", "measured_every": 20} for one in ROWS]
    assert found_in(alike)["measures"] == found_in(ROWS)["measures"]
    for rows, word in (
        (made_up(1, {FLIP: 0.5}, people=1, conditions=3), "too few"),
        ([one | {"value": 3.0} for one in ROWS], "one rating throughout"),
        ([one | {"measured_size": "640x800"} if k % 2 else one for k, one in enumerate(alike)], "one --size"),
        ([one | {"measured_every": 10} if k % 2 else one for k, one in enumerate(alike)], "one --size"),
    ):
        found = found_in(rows)
        assert found["measures"] == [] and word in dict(found["left_out"])[MEASURES[FLIP]]


def test_a_perfect_line_is_one():
    (found,) = found_in(made_up(1, {FLIP: 0.5}, noise=0.0))["measures"]
    assert found["r"] == pytest.approx(1) and found["low"] > 0.999 and found["p"] < 1e-12


def test_missing_ratings_and_other_scales_are_left_alone():
    more = [one | {"value": None} for one in ROWS[:5]] + [one | {"scale": "acr", "low_is_good": False} for one in ROWS]
    assert found_in(ROWS + more) == found_in(ROWS)
    assert found_in(ROWS + more, "acr")["measures"][0]["r"] == pytest.approx(-found_in(ROWS)["measures"][0]["r"])


def test_the_page_has_each_correlation():
    pytest.importorskip("statsmodels", reason="statsmodels is not installed (pip install '.[study]')")
    data = analyse(Ratings(ROWS, {"grade": ScaleInfo("grade", "Grade", low_is_good=True)}))
    page = study_page(data, "hmdwarp study analyse").html()
    said = data["scales"][0]["prediction"]["sentences"]
    assert "What goes with the ratings" in page and said[0] in page
    assert said[0].startswith("Within a person the ratings go with error (FLIP) +")
