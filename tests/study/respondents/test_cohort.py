"""Whole studies of simulated people: what comes out is what the model says, and obeys the plan."""

from __future__ import annotations

from collections import Counter

import attrs
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.study.design import Ask, Sickness, load_design, steps_of
from hmdwarp.study.respondents import Population, SicknessModel, Simulated, load_model
from hmdwarp.study.scales import load_scale
from hmdwarp.study.session.runner import why_sick
from hmdwarp.study.store import Answer

from ..made_up import unlimited

DESIGN, MODEL = load_design("quick"), load_model("quick")
PART = DESIGN.parts[0].name
GRADE = MODEL.ratings["grade"]
ORDER = (("late", "reference", "warped", "turned"),)


def cohort(n=50, seed=1, design=DESIGN, **model):
    return Population(attrs.evolve(MODEL, **model), design, PART).of(range(n), seed)


def rating(**values):
    return {"grade": attrs.evolve(GRADE, **values)}


def test_the_same_seed_gives_the_same_people_in_any_company():
    few, many = cohort(12), cohort(30)
    np.testing.assert_array_equal(few.answers["grade"], many.answers["grade"][:12])
    assert few.why == many.why[:12]
    assert (cohort(12, seed=2).answers["grade"] != few.answers["grade"]).any()


def test_the_parts_of_the_spread_are_those_of_the_model():
    """Without ends, steps, drift and carry-over, of 4000 people with 3 repeats.

    Each variance by its own mean squares. The standard error of a standard deviation is sd / sqrt(2
    x degrees of freedom), below 0.012 sd for all of them; 4 of those.
    """
    design = unlimited(attrs.evolve(DESIGN, repeats=3, sickness=None))
    values = {"people_sd": 0.5, "condition_sd": 0.4, "noise_sd": 0.6, "drift": 0.0, "carry_over": 0.0, "missing": 0.0}
    made = cohort(4000, design=design, ratings=rating(**values), dropout=0.0)
    cube = np.empty((4000, 4, 3))
    for person in range(4000):
        for condition in range(4):
            cube[person, condition] = made.answers["grade"][person][made.order[person] == condition]
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
    means = np.array([GRADE.means[condition.name] for condition in DESIGN.parts[0].conditions])[made.order]
    before = np.concatenate([means[:, :1], means[:, :-1]], axis=1)
    wanted = 0.75 * means + 0.25 * before + 0.125 * np.arange(4)
    np.testing.assert_allclose(made.answers["grade"], wanted, atol=1e-6)


def test_shares_of_missing_ratings_and_dropouts():
    """2000 people: 4 standard errors of a share p are 4 sqrt(p (1 - p) / 2000)."""
    made = cohort(2000, ratings=rating(missing=0.1), dropout=0.05, sickness=SicknessModel())
    assert np.mean([reason == "complete" for reason in made.why]) == pytest.approx(
        0.95**3, abs=0.032
    )  # after the last trial nobody leaves
    for place in range(4):
        went_on = made.trials > place
        assert np.mean(went_on) == pytest.approx(0.95**place, abs=0.032)
        assert np.isnan(made.answers["grade"][went_on, place]).mean() == pytest.approx(0.1, abs=0.03)
        assert np.isnan(made.answers["grade"][~went_on, place]).all()


def test_orders_stay_balanced_after_dropouts():
    made = cohort(200, dropout=0.2)
    stayed = [tuple(order) for order, why in zip(made.order.tolist(), made.why, strict=True) if why == "complete"]
    counts = Counter(stayed)
    assert len(counts) == 4 and max(counts.values()) - min(counts.values()) <= 1


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
    population = Population(attrs.evolve(MODEL, sickness=people, dropout=0.0), design, PART)
    made = population.of(range(6), seed)
    for person in range(6):
        answers, ended = [], None
        for trial, value in enumerate(made.sickness[person]):
            if not np.isnan(value):
                answers.append(answer_of(rule, trial, float(value)))
                if why_sick(rule, answers):
                    ended = trial
                    break
        assert (made.why[person] == "sick") == (ended is not None)
        assert made.trials[person] == (8 if ended is None else ended)


def answer_of(rule: Sickness, trial: int, value: float) -> Answer:
    key = f"trial/{trial}/{rule.scale.name}"
    return Answer(trial + 1, 1, key, 1, "trial", trial, rule.scale.name, "x", value, 1.0, "simulated", "")


def test_a_simulated_session_answers_as_a_simulated_study():
    model = attrs.evolve(MODEL, dropout=0.0, ratings=rating(missing=0.3))
    made = Population(model, DESIGN, PART).of([77], DESIGN.seed, orders=[ORDER])
    somebody = Simulated(model, DESIGN, PART, DESIGN.seed, 77, ORDER)
    for step in steps_of(DESIGN, ORDER, PART):
        if isinstance(step, Ask) and step.phase == "trial":
            wanted = (
                made.answers["grade"][0, step.trial - 1] if step.scale.name == "grade" else made.sickness[0, step.trial]
            )
            assert somebody.answer(step, step.trial) == (None if np.isnan(wanted) else wanted)
