"""The plan of every set of effects. Which passes run, in which order, what frames carry for them,
and why the others do not."""

from __future__ import annotations

import itertools
from functools import reduce
from operator import or_

import pytest
from hypothesis import given
from hypothesis import strategies as st
from together import together

from hmdwarp.base import InputError
from hmdwarp.client import SHOWN, build_plan
from hmdwarp.client.effects import RenderedPass, effects
from hmdwarp.client.warps import warps
from hmdwarp.frames import EyeSizes, Needs, frame_bytes
from hmdwarp.frames.layers import readable_names
from hmdwarp.geometry import Fov

EVERY_EFFECT = effects.ordered(effect.name for effect in effects if not effect.by_name_only)
SETS = [chosen for count in range(8) for chosen in itertools.combinations(EVERY_EFFECT, count)]
SIZES = EyeSizes((40, 30), (20, 10), (Fov.symmetric(1, 1),) * 2)


def plan_of(declared: tuple[str, ...], warp: str = "forward", fill: str = "none", lens: str = "none", **more):
    return build_plan(declared, warp, fill, lens, client_geometry=True, **more)


@together("declared", SETS)
def test_declared_effects_are_compensated_and_the_rest_left_out_with_a_reason(declared):
    plan = plan_of(declared, fill="interpolate", lens="radial")
    done = [effect.name for pass_ in plan.effect_passes for effect in pass_.effects]
    left_out = dict(plan.left_out)
    refining = [e.name for e in effects if e.refines and e.name in declared and e.refines not in declared]
    assert sorted(done) == sorted(set(declared) - set(refining))
    assert set(effects.names()) - set(done) <= set(left_out) and not set(done) & set(left_out)
    assert all(reason.strip() for reason in left_out.values())
    assert list(plan.effects) == sorted(done, key=EVERY_EFFECT.index)

    stages = [step.stage for step in plan.steps]
    rendered = [pass_ for pass_ in plan.effect_passes if issubclass(pass_.made_by, RenderedPass)]
    assert stages[: len(rendered)] == ["effects"] * len(rendered) and stages[len(rendered)] == "warp"
    assert stages[-1] == "lens", "effects come before the lens"
    assert len({pass_.made_by for pass_ in plan.effect_passes}) == len(plan.effect_passes), (
        "effects that share a pass are one pass"
    )
    known = set(readable_names())
    for step in plan.steps:
        assert set(step.reads) <= known, step.name
        known |= set(step.writes)
    for pass_ in plan.effect_passes:
        (step,) = [step for step in plan.steps if step.name == pass_.made_by.name]
        assert all(effect.name in step.reason and effect.summary in step.reason for effect in pass_.effects)


@together("declared", SETS)
def test_a_frame_weighs_what_the_effects_need_and_no_more(declared):
    plan = plan_of(declared)
    needs = reduce(or_, (effect.needs for pass_ in plan.effect_passes for effect in pass_.effects), Needs())
    assert plan.needs == needs
    parts = frame_bytes(plan.needs, SIZES, plan.layers)
    extra = set(parts) - {"rendered.colour", "rendered.inverse_depth"}
    read = {name for step in plan.steps for name in step.reads if name in readable_names()}
    assert extra <= read, "what nobody reads is not sent"
    assert (extra == set()) == (needs == Needs())


@pytest.mark.parametrize("warp", [warp.name for warp in warps if warp.fuses])
def test_fused_with_the_lens_nothing_is_composited(warp):
    plan = plan_of(EVERY_EFFECT, warp, lens="radial", fused=True, named=EVERY_EFFECT)
    done = [effect for pass_ in plan.effect_passes for effect in pass_.effects]
    assert all(effect.fuses or issubclass(effect.made_by, RenderedPass) for effect in done)
    assert not any(SHOWN in step.writes for step in plan.steps)
    for effect in map(effects.get, EVERY_EFFECT):
        if not (effect.fuses or issubclass(effect.made_by, RenderedPass)):
            assert "nothing can be composited" in dict(plan.left_out)[effect.name]


@pytest.mark.parametrize("warp", [warp.name for warp in warps if not warp.carries and warp.kind != "draw"])
def test_a_warp_that_carries_nothing_leaves_out_what_it_cannot(warp):
    left_out = dict(plan_of(EVERY_EFFECT, warp).left_out)
    for effect in map(effects.get, EVERY_EFFECT):
        assert ("carries nothing" in left_out.get(effect.name, "")) == effect.made_by.carries


@pytest.mark.parametrize("warp", [warp.name for warp in warps if warp.kind == "draw"])
def test_a_warp_that_draws_leaves_nothing_to_compensate(warp):
    plan = plan_of(EVERY_EFFECT, warp, named=EVERY_EFFECT)
    assert plan.effects == () and not {"rendered.colour", "rendered.inverse_depth"} & {*plan.layers}
    reasons = [dict(plan.left_out)[name] for name in EVERY_EFFECT]
    assert all(
        f"warp '{warp}' {warps.get(warp).without_effects}" in reason or reason.startswith("it refines")
        for reason in reasons
    )


@together("declared", SETS)
def test_an_imposter_compensates_only_what_is_asked_for_by_name(declared):
    imposters = [warp.name for warp in warps if warp.imposter]
    assert imposters == ["none"]
    plan = plan_of(declared, "none", fill="interpolate", lens="radial")
    assert plan.effects == () and plan.needs == Needs() and plan.layers == ("rendered.colour",)
    assert not any(step.stage == "effects" for step in plan.steps)
    reasons = [dict(plan.left_out)[name] for name in declared]
    assert all(
        "warp 'none' compensates nothing unless" in reason or reason.startswith("it refines") for reason in reasons
    )
    by_name = plan_of(declared, "none", named=declared)
    assert by_name.effects == plan_of(declared).effects and by_name.needs == plan_of(declared).needs


# --- what an experiment asks for ----------------------------------------------------------------


@given(st.sampled_from(SETS), st.sampled_from(SETS), st.sampled_from(SETS))
def test_each_may_be_forced_or_forbidden(declared, forced, forbidden):
    told = ", ".join([*forced, *(f"no-{name}" for name in forbidden)])
    if {*forced} & {*forbidden}:
        with pytest.raises(InputError, match="both forced and forbidden"):
            effects.selected(told, declared)
    else:
        assert effects.selected(told, declared) == effects.ordered({*declared, *forced} - {*forbidden})


def test_a_display_that_composes_panels_is_handed_those_that_nothing_hides():
    alone = plan_of(("panels",), takes_panels="the headset")
    assert "panels" in alone.needs and alone.effects == ("panels",)
    assert not alone.effect_passes and not [step for step in alone.steps if step.stage == "effects"]
    assert dict(alone.left_out)["panels"] == "the headset composes them by itself, at its newest pose"
    both = plan_of(("panels", "occluded_panels"), takes_panels="the headset")
    (step,) = [step for step in both.steps if step.stage == "effects" and step.name == "panels"]
    assert step.reason.endswith("; the headset composes those that nothing hides")
    assert alone.hands_panels_on and both.hands_panels_on
    assert not plan_of(("overlay",), takes_panels="the headset").hands_panels_on
    assert not plan_of(("panels",)).hands_panels_on
