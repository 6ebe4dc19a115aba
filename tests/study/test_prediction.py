"""What predicts ratings.

Against pingouin and plain loops, and on made-up studies whose best measure is known.
"""

from __future__ import annotations

import warnings

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.errors import InputError
from hmdwarp.study.analysis.predict import LEAST_PEOPLE, MEASURES, pooled, predict, sentences

FLIP, PSNR, FLICKER, HOLES, AGE = (
    "measured_flip", "measured_psnr_db", "measured_flicker", "measured_hole_share", "actual_latency_ms_median"
)  # fmt: skip


def made_up(seed, effects, people=12, conditions=8, noise=0.5, together=0.0, repeats=1):
    """Rows of a study.

    Measures are drawn for each condition, tremble a little with each person, and move the grade by
    their effects.

    together: how far all measures are one and the same.
    """
    rng = np.random.default_rng(seed)
    shared = rng.normal(size=conditions)
    levels = {name: together * shared + (1 - together) * rng.normal(size=conditions) for name in effects}
    rows = []
    for person in range(people):
        own = rng.normal(3, 0.7)
        for c in range(conditions):
            for repeat in range(repeats):
                x = {name: levels[name][c] + 0.05 * rng.normal() for name in effects}
                value = own + sum(effects[name] * x[name] for name in effects) + noise * rng.normal()
                rows.append(row(f"p{person}", f"c{c}", value, x) | {"repeat": repeat + 1})
    return rows


def row(participant, condition, value, measures):
    asked = {"part": "main", "scale": "grade", "low_is_good": True}
    return {"participant": participant, "condition": condition, "value": value, **asked, **measures}


def few(rows, **more):
    return predict(rows, **{"resamples": 500} | more)


@pytest.mark.parametrize("seed", range(3))
def test_the_correlation_is_pingouins(seed):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        pingouin = pytest.importorskip("pingouin", reason="pingouin is not installed (pip install '.[test]')")
        import pandas
    rows = made_up(seed, {FLIP: 0.6, HOLES: -0.2})
    rows = [one for k, one in enumerate(rows) if k % 7]  # unequal numbers of ratings
    found = few(rows)
    table = pandas.DataFrame(rows)
    for measure in found.measures:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            theirs = pingouin.rm_corr(table, x=measure.name, y="value", subject="participant").iloc[0]
        assert measure.r == pytest.approx(theirs["r"], abs=1e-9) and measure.dof == theirs["dof"]
        assert measure.p == pytest.approx(theirs[[n for n in theirs.index if n.startswith("p")][0]], rel=1e-6)


def test_people_left_out_are_predicted_as_a_plain_loop_does():
    rows = made_up(5, {FLIP: 0.6, HOLES: 0.1}, people=6)
    found = {measure.name: measure for measure in few(rows).measures}
    people = list(dict.fromkeys(row["participant"] for row in rows))
    for name in (FLIP, HOLES):
        error = alone = 0.0
        for left_out in people:
            x, y = [], []
            for person in people:
                mine = [row for row in rows if row["participant"] == person]
                dx = np.array([row[name] for row in mine]) - np.mean([row[name] for row in mine])
                dy = np.array([row["value"] for row in mine]) - np.mean([row["value"] for row in mine])
                if person == left_out:
                    asked = dx, dy
                else:
                    x.extend(dx)
                    y.extend(dy)
            slope = np.linalg.lstsq(np.array(x)[:, None], np.array(y), rcond=None)[0][0]
            error += ((asked[1] - slope * asked[0]) ** 2).sum()
            alone += (asked[1] ** 2).sum()
        assert found[name].skill == pytest.approx(1 - error / alone, rel=1e-9)
        assert found[name].rmse == pytest.approx(np.sqrt(error / len(rows)), rel=1e-9)


def test_a_choice_is_tested_on_people_who_took_no_part_in_it_as_nested_plain_loops_do():
    rows = made_up(7, {FLIP: 0.5, HOLES: 0.3, AGE: 0.2}, people=7, noise=1.5)
    found = few(rows)
    names = (FLIP, HOLES, AGE)
    people = list(dict.fromkeys(row["participant"] for row in rows))

    def centred(person, name):
        values = np.array([row[name] for row in rows if row["participant"] == person])
        return values - values.mean()

    def off(asked, known, name):
        x, y = (np.concatenate([centred(row, column) for row in known]) for column in (name, "value"))
        slope = np.linalg.lstsq(x[:, None], y, rcond=None)[0][0]
        return ((centred(asked, "value") - slope * centred(asked, name)) ** 2).sum()

    error, chosen = 0.0, []
    for left_out in people:
        others = [person for person in people if person != left_out]
        inner = {name: sum(off(other, [o for o in others if o != other], name) for other in others) for name in names}
        chosen.append(min(inner, key=inner.get))
        error += off(left_out, others, chosen[-1])
    alone = sum((centred(person, "value") ** 2).sum() for person in people)
    assert found.choice_skill == pytest.approx(1 - error / alone, rel=1e-9)
    assert dict(found.chosen) == {MEASURES[name]: chosen.count(name) / len(people) for name in set(chosen)}
    assert found.choice_low <= found.choice_skill <= found.choice_high


def test_the_first_place_flatters_and_a_choice_by_others_does_not():
    """Of ten measures that say nothing the best looks better than chance on its own people.

    The mean of 40 studies: skill of one study has a standard deviation of about 0.05 here, so that
    of the mean is below 0.01.
    """
    found = [few(made_up(seed, dict.fromkeys(list(MEASURES)[:10], 0.0)), resamples=20) for seed in range(40)]
    first = np.mean([max(measure.skill for measure in study.measures) for study in found])
    chosen = np.mean([study.choice_skill for study in found])
    assert first > 0.01 > chosen


def test_a_choice_that_is_clear_costs_nothing():
    found = few(made_up(3, {FLICKER: 0.8, FLIP: 0.0, HOLES: 0.1, AGE: 0.0}))
    assert found.chosen == ((MEASURES[FLICKER], 1.0),)
    assert found.choice_skill == found.measures[0].skill
    assert any("nested cross-validation" in sentence for sentence in sentences(found))


def matrix(rows, people, measure):
    """A column for the level of each person, and one for the measure."""
    levels = np.array([[row["participant"] == person for person in people] for row in rows], dtype=float)
    return np.column_stack([levels, [row[measure] for row in rows]]) if measure else levels


def test_conditions_left_out_are_predicted_as_a_regression_with_a_level_for_each_person_does():
    rows = made_up(6, {FLIP: 0.6, HOLES: 0.1}, people=6)
    found = {measure.name: measure for measure in few(rows).measures}
    people = list(dict.fromkeys(row["participant"] for row in rows))
    for name in (FLIP, HOLES):
        error = alone = 0.0
        for left_out in dict.fromkeys(row["condition"] for row in rows):
            known = [row for row in rows if row["condition"] != left_out]
            asked = [row for row in rows if row["condition"] == left_out]
            for measure in (name, None):
                fit = np.linalg.lstsq(
                    matrix(known, people, measure), np.array([row["value"] for row in known]), rcond=None
                )[0]
                off = ((np.array([row["value"] for row in asked]) - matrix(asked, people, measure) @ fit) ** 2).sum()
                error, alone = (error + off, alone) if measure else (error, alone + off)
        assert found[name].skill_condition == pytest.approx(1 - error / alone, rel=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_the_best_measure_of_a_made_up_study_is_found(seed):
    found = few(made_up(seed, {FLICKER: 0.8, FLIP: 0.0, HOLES: 0.1, AGE: 0.0}), resamples=2000)
    first = found.measures[0]
    assert first.name == FLICKER and first.r > 0.4 and found.sure and first.low > 0
    assert first.skill > 0 and first.skill_condition > 0
    assert [candidate.name for candidate in found.candidates] == [FLICKER] and first.best > 0.95
    assert sentences(found)[0].startswith("Flicker predicts the ratings best")


def test_equally_good_measures_stay_undecided():
    """At the nominal rate.

    Of 60 studies with two equal measures one is declared the best in 5 of 100, so in 9 or fewer
    with p > 0.999.
    """
    claimed = 0
    for seed in range(60):
        rng = np.random.default_rng(seed)
        rows = []
        for person in range(12):
            flip, psnr = rng.normal(size=8), rng.normal(size=8)
            y = rng.normal() + 0.5 * flip + 0.5 * psnr + 0.8 * rng.normal(size=8)
            rows += [
                row(f"p{person}", f"c{k}", float(y[k]), {FLIP: float(flip[k]), PSNR: float(psnr[k])}) for k in range(8)
            ]
        claimed += len(few(rows).candidates) == 1
    assert claimed <= 9


def test_correlated_measures_are_named():
    found = few(made_up(2, {FLIP: 0.5, FLICKER: 0.0, AGE: 0.0}, together=0.99))
    assert all(
        set(measure.alike) == {other.title for other in found.measures} - {measure.title} for measure in found.measures
    )
    text = " ".join(sentences(found))
    assert "is undecided" in text and "ratings cannot separate them" in text and "move together" in text


def test_a_skipped_prediction_says_what_it_lacks():
    said = sentences(few(made_up(1, {FLIP: 0.5}, people=2)))[0]
    assert said.startswith(f"Skipped: which metric predicts the ratings (needs {LEAST_PEOPLE} people with ")
    assert said.endswith("each, found 2).")


@pytest.mark.slow(8)
def test_noise_supports_no_claim():
    """13 measures that have nothing to do with the grades.

    A claim in at most 5 of 100 studies, so in 8 or fewer of 60 with p > 0.99.
    """
    effects = dict.fromkeys(MEASURES, 0.0)
    claims = sum(few(made_up(seed, effects), resamples=2000).sure for seed in range(60))
    assert claims <= 8
    quiet = next(found for seed in range(60) if not (found := few(made_up(seed, effects))).sure)
    assert sentences(quiet)[0].startswith("No metric is shown to predict the ratings")


@pytest.mark.slow(12)
def test_the_interval_covers_what_is_true():
    """r of endless ratings is 0.6 / sqrt(0.6^2 + 0.8^2) = 0.6; 200 studies of 12 people.

    95 % is 190, and 181 is 3 sigma below it. Percentile-like intervals of 12 people are known to be
    somewhat short: 90 % is held to.
    """
    covered = 0
    for seed in range(200):
        rng = np.random.default_rng(seed)
        rows = []
        for person in range(12):
            x = rng.normal(size=8)
            y = rng.normal() + 0.6 * x + 0.8 * rng.normal(size=8)
            rows += [row(f"p{person}", f"c{k}", float(y[k]), {FLIP: float(x[k])}) for k in range(8)]
        one = few(rows, resamples=1000).measures[0]
        covered += one.low <= 0.6 <= one.high
    assert covered >= 180 - 13  # 90 %, less 3 sigma of 200 draws


@settings(max_examples=15)
@given(st.integers(0, 1000), st.floats(1e-6, 1e6), st.floats(-1e3, 1e3))
def test_units_order_and_direction_play_no_part(seed, scale, shift):
    rows = made_up(seed, {FLIP: 0.5, HOLES: 0.2}, people=6)
    before = few(rows)
    other = [dict(row) for row in rows]
    np.random.default_rng(seed).shuffle(other)
    for row in other:
        row[FLIP] = row[FLIP] * scale + shift * scale
        row["low_is_good"], row["value"] = False, 7 - row["value"]
    after = {measure.name: measure for measure in few(other).measures}
    for measure in before.measures:
        got = after[measure.name]
        for name in ("r", "rank_r", "skill", "skill_condition"):
            # Shifting by 1000 times the spread costs three digits of sixteen twice over, in
            # centring and in its squares.
            assert getattr(got, name) == pytest.approx(getattr(measure, name), abs=1e-7)


def test_the_same_rows_give_the_same_numbers():
    rows = made_up(1, {FLIP: 0.5, HOLES: 0.2})
    assert few(rows) == few(rows)
    assert few(rows, seed=1).measures[0].low != few(rows, seed=2).measures[0].low


def test_untestable_measures_are_named_with_their_reason():
    rows = made_up(3, {FLIP: 0.5, HOLES: 0.2})
    for k, one in enumerate(rows):
        one["actual_missed_share"] = 0.0
        one["measured_ssim"] = 0.9 if k % 3 == 0 else None
        one[HOLES] = one[HOLES] if k % 20 else None
        one["actual_pose_age_ms_median"] = float(one["participant"][1:])  # differs between people alone
    found = few(rows)
    reasons = dict(found.left_out)
    assert [measure.name for measure in found.measures] == [FLIP, HOLES]
    assert reasons["missed refreshes"] == reasons["age of the pose"] == "the same in all trials of each person"
    assert (
        reasons["likeness (SSIM)"] == "missing with 64 of 96 ratings"
        and reasons["flicker"] == "not measured; 'study measure' does it"
    )
    assert found.dropped == 5 and found.ratings == 91
    text = " ".join(sentences(found))
    assert "Left out: 5 ratings without all metrics" in text and "flicker" in text


def test_too_little_is_refused_in_words():
    assert predict([]) is None and predict([row("p", "c", 1.0, {})]) is None
    for rows, word in (
        (made_up(1, {FLIP: 0.5}, people=LEAST_PEOPLE - 1), "people"),
        (made_up(1, {FLIP: 0.5}, conditions=2, repeats=3), "conditions"),
        ([row | {FLIP: 1.0} for row in made_up(1, {FLIP: 0.5})], "no metric differs"),
        ([row | {"value": 3.0} for row in made_up(1, {FLIP: 0.5})], "same rating"),
        ([row for row in made_up(1, {FLIP: 0.5}) if row["condition"] == "c0"], "people"),
    ):
        found = few(rows)
        assert word in found.refused and found.measures == () and word in sentences(found)[0]


def test_pictures_measured_in_different_ways_are_not_compared():
    alike = [row | {"measured_size": "320x400", "measured_every": 20} for row in made_up(4, {FLIP: 0.5, HOLES: 0.2})]
    assert few(alike).measures == few(made_up(4, {FLIP: 0.5, HOLES: 0.2})).measures
    for other in ({"measured_size": "640x800"}, {"measured_every": 10}):
        found = few([one | other if k % 2 else one for k, one in enumerate(alike)])
        assert found.measures == () and "one --size" in dict(found.left_out)[MEASURES[FLIP]]


def test_missing_ratings_and_other_scales_are_left_alone():
    rows = made_up(4, {FLIP: 0.5, HOLES: 0.2})
    more = [row | {"value": None} for row in rows[:5]] + [row | {"scale": "acr", "low_is_good": False} for row in rows]
    assert few(rows + more) == few(rows)
    assert few(rows + more, scale="acr").measures[0].r == pytest.approx(-few(rows).measures[0].r)


def test_one_measure_alone_is_not_called_the_best():
    found = few(made_up(1, {FLIP: 0.5}))
    assert sentences(found)[0].startswith("Only one metric can be tested") and attrs.asdict(found)["scale"] == "grade"


def test_people_and_conditions_of_two_studies_are_never_one():
    """Each with its own level of the measure and of the grade, which count for nothing."""
    first = made_up(1, {FLIP: 0.6, HOLES: 0.1}, people=6)
    second = [row | {FLIP: row[FLIP] + 50, "value": row["value"] - 9} for row in made_up(2, {FLIP: 0.6, HOLES: 0.1})]
    scale, rows = pooled({"a": first, "b.toml": second})
    found = few(rows)
    assert (scale, found.people, found.conditions, found.ratings) == ("grade", 18, 16, len(first) + len(second))
    assert found.measures[0].name == FLIP and found.measures[0].r > 0.4


def test_studies_whose_scale_has_another_good_end_are_refused():
    """Their correlations would cancel each other."""
    first = made_up(1, {FLIP: 0.6})
    second = [row | {"low_is_good": False, "value": -row["value"]} for row in made_up(2, {FLIP: 0.6})]
    with pytest.raises(InputError, match="'grade' is not the same .*: low is good in 'a' and high is good in 'b'"):
        pooled({"a": first, "b": second})


def test_studies_without_a_common_scale_are_refused_with_what_they_have():
    first = made_up(1, {FLIP: 0.6})
    second = [row | {"scale": "acr"} for row in made_up(2, {FLIP: 0.6})]
    with pytest.raises(InputError, match=r"on one scale in every study.*'a' \(grade\).*'b' \(acr\)"):
        pooled({"a": first, "b": second})
    with pytest.raises(InputError, match=r"on scale 'acr' in every study.*'a' \(grade\)") as refused:
        pooled({"a": first, "b": second}, "acr")
    assert "'b'" not in str(refused.value)
