"""The formulas of simulated answers, and the files they come from."""

from __future__ import annotations

import itertools

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import kstest, norm
from together import together

from hmdwarp.errors import InputError
from hmdwarp.study.design import load_design, write_new_plan
from hmdwarp.study.respondents import (
    Population,
    RatingModel,
    SicknessModel,
    draw_for,
    load_model,
    model_from_text,
    model_names,
    normal,
    of_share,
    on_scale,
    person_of,
    table_of,
)
from hmdwarp.study.scales import RATING, load_scale, scale_names

from ..made_up import per_condition
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


def test_a_latent_rating_is_the_sum_of_its_parts():
    """By hand: 3 + 0.5 x 1 + 0.2 x (-1) + 0.3 x 2 + 0.1 x 4 - 0.25 x (5 - 3)."""
    model = RatingModel(people_sd=0.5, condition_sd=0.2, noise_sd=0.3, drift=0.1, carry_over=-0.25)
    level, taste, noise = norm.cdf([1, -1, 2])
    assert model.latent(3.0, 5.0, 4, level, taste, noise) == pytest.approx(3.8)


def test_sickness_grows_with_trials_faster_in_some():
    model = SicknessModel(start=0.1, per_trial=0.02, people_sd=1.0)
    assert model.state([0, 5], 0.5) == pytest.approx([0.1, 0.2])  # the median person
    assert model.state(5, norm.cdf(1)) == pytest.approx(0.1 + 0.1 * np.e)


def test_the_least_draw_is_a_number():
    assert np.isfinite(normal([0.0, np.nextafter(1, 0)])).all()


def test_draws_are_uniform_and_belong_to_their_person():
    """20,000 values.

    A right generator gives p below 1e-4 once in 10,000 seeds, and this seed is fixed.
    """
    tables = np.concatenate([table_of(1, 0, "run", person, 20) for person in range(1000)])
    assert kstest(tables, "uniform").pvalue > 1e-4
    assert (
        abs(np.corrcoef(tables.reshape(1000, 20), rowvar=False) - np.eye(20)).max() < 0.15
    )  # 4.7 standard errors of 1/sqrt(1000)
    assert (table_of(1, 0, "run", 5, 20)[:7] == table_of(1, 0, "run", 5, 7)).all()
    places = itertools.product((1, 2), (0, 1), ("run", "other"), (0, 2**64 - 1))
    assert len({table_of(*place, 1)[0] for place in places}) == 16
    assert draw_for(1, "run", 5, "a") != draw_for(1, "run", 5, "b")


def test_a_code_is_the_same_person_everywhere():
    assert person_of("p-1") == 0x1DEE6E3EC67DC803
    assert person_of("p-1") != person_of("p-2")
    assert table_of(1, 0, "run", 5, 1) == pytest.approx(0.437898652607293, abs=1e-15)  # NumPy promises Philox's stream


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


@given(st.text(max_size=200))
def test_no_text_gives_another_error(text):
    with pytest.raises(InputError):
        model_from_text(text, "people.toml")


def test_a_lack_of_the_model_is_named():
    design, model = load_design("quick"), model_from_text(TEXT, "people.toml")
    told = r"people.toml: \[rating.grade.means\]: no mean for late, turned, warped, reference of part"
    with pytest.raises(InputError, match=told):
        Population(model, design, design.parts[0].name)
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
    cohort = Population(load_model("quick"), design, design.parts[0].name).of(range(100), seed=1)
    means = np.nanmean(per_condition(cohort, name), axis=0)
    badness = [scale.badness(mean) for mean in means]
    assert design.parts[0].conditions[-1].reference
    assert max(badness[:-1]) - min(badness[:-1]) < 0.1 * (scale.most - scale.least)
    assert badness[-1] < min(badness[:-1]) - 0.2 * (scale.most - scale.least)


def test_parts_may_have_their_own_means():
    design, model = load_design("thesis"), load_model("thesis")
    first, second = (model.rating(design.scales[0]).means_of(part, "") for part in design.parts)
    assert (first != second).any()
    assert attrs.evolve(model, title="x").ratings == model.ratings
