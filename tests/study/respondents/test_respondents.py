"""Simulated people: the formulas of their answers, their files, whole studies of them."""

from __future__ import annotations

import itertools

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.special import ndtr
from scipy.stats import kstest
from together import together

from hmdwarp.base import InputError
from hmdwarp.study.design import Ask, Sickness, load_design, rows_for, steps_of, write_new_plan
from hmdwarp.study.respondents import (
    RatingModel,
    SicknessModel,
    Simulated,
    answers_of,
    draw_for,
    load_model,
    model_from_text,
    model_names,
    of_share,
    on_scale,
    person_of,
    ratings_for,
    table_of,
)
from hmdwarp.study.scales import RATING, load_scale, scale_names
from hmdwarp.study.session.runner import why_sick
from hmdwarp.study.store import Answer

from ..analysis.tables import cohort_of, per_condition, unlimited
from ..plans import text_of

TEXT = text_of("two-people")
SCALES = [name for name in scale_names() if load_scale(name).has_answers]


@given(st.sampled_from(SCALES), st.floats(-1e6, 1e6))
def test_answers_are_answers_of_the_scale_and_the_nearest_ones(name, latent):
    scale = load_scale(name)
    answer = float(on_scale(latent, scale))
    assert answer in scale.values()
    assert abs(answer - latent) <= min(abs(value - latent) for value in scale.values()) + 1e-9 * max(1, abs(latent))


@given(st.sampled_from(SCALES), st.floats(0, 1), st.floats(0, 1))
def test_a_larger_share_is_never_better(name, first, second):
    scale = load_scale(name)
    low, high = sorted((first, second))
    assert scale.badness(float(of_share(low, scale))) <= scale.badness(float(of_share(high, scale)))
    assert scale.badness(float(of_share(0, scale))) == 0
    assert scale.badness(float(of_share(1, scale))) == scale.most - scale.least


def test_sickness_grows_with_trials_faster_in_some():
    model = SicknessModel(start=0.1, per_trial=0.02, people_sd=1.0)
    assert model.latent([0, 5], 0.5, 0.5) == pytest.approx([0.1, 0.2])  # the median person
    assert model.latent(5, ndtr(1), 0.5) == pytest.approx(0.1 + 0.1 * np.e)


def test_draws_are_uniform_and_belong_to_their_person():
    """20,000 values. A right generator gives p below 1e-4 once in 10,000 seeds, and this seed is
    fixed.
    """
    tables = np.concatenate([table_of(1, "run", person, 20) for person in range(1000)])
    assert kstest(tables, "uniform").pvalue > 1e-4
    assert (
        abs(np.corrcoef(tables.reshape(1000, 20), rowvar=False) - np.eye(20)).max() < 0.15
    )  # 4.7 standard errors of 1/sqrt(1000)
    assert (table_of(1, "run", 5, 20)[:7] == table_of(1, "run", 5, 7)).all()
    places = itertools.product((1, 2), ("run", "other"), (0, 2**64 - 1))
    assert len({table_of(*place, 1)[0] for place in places}) == 8
    assert draw_for(1, "run", 5, "a") != draw_for(1, "run", 5, "b")


def test_a_code_is_the_same_person_everywhere():
    assert person_of("p-1") == 0x1DEE6E3EC67DC803
    assert person_of("p-1") != person_of("p-2")
    assert table_of(1, "run", 5, 1) == pytest.approx(0.437898652607293, abs=1e-15)  # NumPy promises Philox's stream


def test_shipped_models_fit_their_studies():
    assert {"quick", "thesis"} <= set(model_names())
    for name in model_names():
        design, model = load_design(name), load_model(name)
        for part in design.parts:
            for scale in design.scales:
                means = model.rating(scale).means_of(part, name)
                assert ((scale.least <= means) & (means <= scale.most)).all()


def test_a_file_is_read_with_its_defaults():
    model = model_from_text(TEXT, "people.toml")
    assert model.ratings["grade"] == RatingModel(means={"a": 2.0, "b": 3.5}, noise_sd=0.5)
    assert (model.sickness.start, model.dropout, model.pause, model.median_s) == (0.1, 0.02, 0.0, 2.0)


def test_a_lack_of_the_model_is_named():
    design, model = load_design("quick"), model_from_text(TEXT, "people.toml")
    told = r"people.toml: \[rating.grade.means\]: no mean for late, turned, warped, reference of part"
    with pytest.raises(InputError, match=told):
        ratings_for(model, design, design.parts[0])
    with pytest.raises(InputError, match=r"no \[rating.acr\]"):
        model.rating(load_scale("acr"))
    # Of a shipped one the remedy is named, and no file of the package.
    with pytest.raises(InputError, match=r"^model thesis: no \[rating.acr\].*add it, or use the model quick"):
        load_model("thesis").rating(load_scale("acr"))
    for name, says in (("thesiss", "thesis"), ("nowhere.toml", "no such file")):
        with pytest.raises(InputError, match=says):
            load_model(name)


@together("name", [name for name in scale_names() if load_scale(name).kind == RATING])
def test_the_model_quick_rehearses_a_new_plan_on_every_rating_scale(tmp_path, name):
    """The reference is rated better than the rest, whichever way the scale goes."""
    plan, scale = write_new_plan(f"mine-{name}", tmp_path), load_scale(name)
    asked = f'["{name}"]' + ('\nshows = "reference first"' if scale.beside_reference else "")
    plan.write_text(plan.read_text(encoding="utf-8").replace('["acr"]', asked), encoding="utf-8")
    design = load_design(str(plan))
    cohort = cohort_of(load_model("quick"), design, design.parts[0].name, range(100), seed=1)
    means = np.nanmean(per_condition(cohort, name), axis=0)
    badness = [scale.badness(mean) for mean in means]
    assert design.parts[0].conditions[-1].reference
    assert max(badness[:-1]) - min(badness[:-1]) < 0.1 * (scale.most - scale.least)
    assert badness[-1] < min(badness[:-1]) - 0.2 * (scale.most - scale.least)


DESIGN, MODEL = load_design("quick"), load_model("quick")
PART = DESIGN.parts[0].name
GRADE = MODEL.ratings["grade"]
ORDER = (("late", "reference", "warped", "turned"),)


def cohort(n=50, seed=1, design=DESIGN, **model):
    return cohort_of(attrs.evolve(MODEL, **model), design, PART, range(n), seed)


def rating(**values):
    return {"grade": attrs.evolve(GRADE, **values)}


def test_the_parts_of_the_spread_are_those_of_the_model():
    """Without ends, steps, drift and carry-over, of 4000 people with 3 repeats. Each variance by
    its own mean squares. The standard error of a standard deviation is sd / sqrt(2 x degrees of
    freedom), below 0.012 sd for all of them; 4 of those.
    """
    design = unlimited(attrs.evolve(DESIGN, repeats=3, sickness=None))
    values = {"people_sd": 0.5, "condition_sd": 0.4, "noise_sd": 0.6, "drift": 0.0, "carry_over": 0.0, "missing": 0.0}
    made = cohort(4000, design=design, ratings=rating(**values), dropout=0.0)
    cube = np.empty((4000, 4, 3))
    for person in range(4000):
        for condition in range(4):
            cube[person, condition] = made.answers["grade"][person][made.order[person, :, 0] == condition]
    means = np.array([GRADE.means[condition.name] for condition in DESIGN.parts[0].conditions])
    noise = cube.var(axis=2, ddof=1).mean()
    of_cell = (cube.mean(axis=2) - means) - (cube.mean(axis=2) - means).mean(axis=1, keepdims=True)
    condition = (of_cell**2).sum() / (4000 * 3) - noise / 3
    people = (cube.mean(axis=(1, 2)) - means.mean()).var() - condition / 4 - noise / 12
    for found, wanted in ((noise, 0.6), (condition, 0.4), (people, 0.5)):
        assert np.sqrt(found) == pytest.approx(wanted, rel=0.05)
    assert (cube.mean(axis=(0, 2)) - means) == pytest.approx(0, abs=0.06)


def test_drift_and_what_was_before_are_in_the_ratings():
    still = {"people_sd": 0.0, "condition_sd": 0.0, "noise_sd": 0.0, "missing": 0.0}
    made = cohort(8, design=unlimited(DESIGN), ratings=rating(**still, drift=0.125, carry_over=0.25), dropout=0.0)
    means = np.array([GRADE.means[condition.name] for condition in DESIGN.parts[0].conditions])[made.order[..., 0]]
    before = np.concatenate([means[:, :1], means[:, :-1]], axis=1)
    wanted = 0.75 * means + 0.25 * before + 0.125 * np.arange(4)
    np.testing.assert_allclose(made.answers["grade"], wanted, atol=1e-6)


@settings(max_examples=60)
@given(
    st.integers(0, 10_000),
    st.sampled_from(["fms", "misc", "acr"]),
    st.sampled_from([1, 2, 3]),
    st.booleans(),
    st.booleans(),
)
def test_the_stop_rule_is_that_of_a_session(seed, name, every, practice, by_rise):
    """Session by session, with the answers one after the other, as study run asks them."""
    scale = load_scale(name)
    limit = scale.values()[len(scale.values()) // 2]
    rule = Sickness(scale, every, None if by_rise else limit, scale.badness(limit) / 2 if by_rise else None)
    design = attrs.evolve(DESIGN, sickness=rule, practice=DESIGN.practice if practice else None, repeats=2)
    people = SicknessModel(start=0.1, per_trial=0.05, people_sd=1.0, noise_sd=0.1)
    model, order = attrs.evolve(MODEL, sickness=people, dropout=0.0), rows_for(design, PART)[0]
    for person in range(6):
        made, answers, ended = answers_of(model, design, PART, seed, person, order), [], None
        for trial, value in enumerate(made.sickness):
            if not np.isnan(value):
                answers.append(answer_of(rule, trial, float(value)))
                if why_sick(rule, answers):
                    ended = trial
                    break
        assert (made.why == "sick") == (ended is not None)
        assert made.trials == (8 if ended is None else ended)


def answer_of(rule: Sickness, trial: int, value: float) -> Answer:
    key = f"trial/{trial}/{rule.scale.name}"
    return Answer(trial + 1, 1, key, 1, "trial", trial, rule.scale.name, "x", value, 1.0, "simulated", "")


def test_a_simulated_participant_gives_those_answers():
    model = attrs.evolve(MODEL, dropout=0.0, ratings=rating(missing=0.3))
    made = answers_of(model, DESIGN, PART, DESIGN.seed, 77, ORDER)
    somebody = Simulated(model, DESIGN, PART, DESIGN.seed, 77, ORDER)
    for step in steps_of(DESIGN, ORDER, PART):
        if isinstance(step, Ask) and step.phase == "trial":
            rated = step.scale.name == "grade"
            wanted = made.ratings["grade"][step.trial - 1] if rated else made.sickness[step.trial]
            assert somebody.answer(step, step.trial) == (None if np.isnan(wanted) else wanted)
