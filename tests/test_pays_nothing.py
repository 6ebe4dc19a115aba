"""A scene pays for what it calls for, and for nothing else.

Shaders, textures, bytes and dispatches are counted.
"""

from __future__ import annotations

import ast

import attrs
import pytest
from costs import Costs, costs_of

from hmdwarp.client.effects import effects
from hmdwarp.frames.layers import layers
from hmdwarp.resources import folder
from hmdwarp.scenes import load_scene, scenes

SCENES = scenes.names()
PLAIN = [name for name in SCENES if not scenes.get(name).effects]
LONG_NAMES = {name for name in effects.names() if "_" in name}  # a layer is called "overlay" too
CALLING = [name for name in SCENES if scenes.get(name).effects]
# All that a plain scene may compile for warp `forward:path=portable` and fill `interpolate`. The
# path is named because GPUs with 64-bit atomics would take the other.
BASE_SHADERS = {
    "server/resolve.comp",
    "server/scene.vert", "server/scene.frag", "server/background.vert", "server/background.frag", "warps/forward.comp",
    "warps/forward_clear.comp", "fills/interpolate.comp",
}  # fmt: skip
# Effects that only a name asks for, and only scenes with their content get.
ASKED_WHERE_IT_IS = {
    effect.name
    for effect in effects
    if effect.by_name_only and effects.selected(effect.name, (), load_scene("planes")) == ()
}
PORTABLE = "forward:path=portable"


@pytest.mark.parametrize("scene", PLAIN)
def test_a_plain_scene_compiles_allocates_sends_and_runs_the_bare_minimum(scene):
    costs = costs_of(scene=scene, warp=PORTABLE, fill="interpolate", samples=4)
    assert costs.shaders == BASE_SHADERS
    # 96x80 pixels an eye of 8 bytes of colour and 4 of depth, and no more.
    assert costs.layers == {"rendered.colour": 2 * 96 * 80 * 8, "rendered.inverse_depth": 2 * 96 * 80 * 4}
    assert costs.sent == 2 * 96 * 80 * 12
    # Frames under way: 50 ms at 60 Hz are 3 refreshes, one more is shown, one is being drawn; each
    # has colour and depth for two eyes. The client has a canvas for the warp and one for the fill,
    # for each eye. The server draws all eyes into one of several samples.
    colour, depth = ((96, 80), 4, "f2"), ((96, 80), 1, "f4")
    assert {kind: count for kind, count in costs.textures.items() if kind[0] == (96, 80)} == {
        colour: 2 * 5 + 2 * 2 + 1,
        depth: 2 * 5,
    }


@pytest.mark.parametrize("scene", PLAIN)
def test_a_plain_scene_costs_the_same_whatever_is_allowed(scene):
    """Nothing to compensate is nothing to pay: `auto` and `none` are one."""
    assert costs_of(scene=scene, effects="auto") == costs_of(scene=scene, effects="none")


@pytest.mark.parametrize("scene", CALLING)
def test_forbidden_effects_cost_the_client_and_the_link_nothing(scene):
    with_all, without = (costs_of(scene=scene, effects=asked) for asked in ("auto", "none"))
    assert not {path for path in without.shaders if path.startswith("effects/")}
    assert set(without.layers) == {"rendered.colour", "rendered.inverse_depth"}
    assert without.sent < with_all.sent
    # The server draws into the picture what no layer has.
    assert _passes(without) <= _passes(with_all)
    assert sum(without.textures.values()) < sum(with_all.textures.values())


@pytest.mark.parametrize("scene", CALLING)
def test_each_effect_is_paid_by_those_who_call_for_it(scene):
    """Forbidding one takes its bytes off the link, unless another needs the same.

    Forcing what is there already changes nothing.
    """
    everything = costs_of(scene=scene)
    declared = scenes.get(scene).effects
    assert costs_of(scene=scene, effects=",".join(declared)) == everything
    for name in declared:
        fewer = costs_of(scene=scene, effects=f"no-{name}")
        assert fewer.sent <= everything.sent
        assert fewer != everything, f"{name} costs nothing at all"


@pytest.mark.parametrize("scene", SCENES)
def test_warp_none_is_an_imposter_in_every_scene(scene):
    """It shows the picture and nothing else is sent, whatever the scene calls for."""
    costs = costs_of(scene=scene, warp="none")
    assert not {path for path in costs.shaders if path.startswith("effects/")}
    assert set(costs.layers) == {"rendered.colour"}
    assert costs.sent == 2 * 96 * 80 * 8
    assert costs == costs_of(scene=scene, warp="none", effects="none")


@pytest.mark.parametrize("name", [name for name in effects.names() if name not in ASKED_WHERE_IT_IS])
def test_a_forced_effect_runs_its_pass_on_a_scene_that_has_nothing_of_it(name):
    plain, forced = (costs_of(scene="planes", effects=asked) for asked in ("auto", _with_what_it_refines(name)))
    assert forced.shaders > plain.shaders
    assert {path for path in forced.shaders if path.startswith("effects/")}
    if any(layers.get(layer).formats for layer in effects.get(name).needs):
        assert set(forced.layers) > set(plain.layers)
        # A layer that is as large as what it shows is of no size here.
        assert forced.sent >= plain.sent


@pytest.mark.parametrize("name", sorted(ASKED_WHERE_IT_IS))
def test_effects_that_a_scene_lacks_cost_nothing_even_if_named(name):
    assert costs_of(scene="planes", effects=name) == costs_of(scene="planes", effects="auto")


def test_every_effect_says_what_it_does():
    assert len({effect.order for effect in effects}) == len(effects.names())
    for effect in effects:
        assert effect.summary and effect.without and effect.source
        assert effect.refines == "" or effect.refines in effects.names()


def test_every_effect_has_a_scene_that_calls_for_it():
    assert {effect for name in SCENES for effect in scenes.get(name).effects} == {
        effect.name for effect in effects if not effect.by_name_only
    }


def names_effects(tree: ast.AST) -> list[int]:
    """Lines that hold an effect's long name, or that compare anything but needs with any name."""
    lines = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and node.value in LONG_NAMES:
            lines.append(node.lineno)
        elif isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            named = any(isinstance(side, ast.Constant) and side.value in effects.names() for side in sides)
            if named and not any(ast.unparse(side).endswith("needs") for side in sides):
                lines.append(node.lineno)
    return lines


def test_an_effect_is_named_only_where_it_is_declared_and_compensated():
    """A test for a name elsewhere would be a second opinion of what is to be done."""
    root = folder("shaders").parent / "hmdwarp"
    own = ("client/effects/", "scenes/library/", "client/strategies/")
    found = [
        f"{path.relative_to(root)}:{line}"
        for path in sorted(root.rglob("*.py"))
        if "_data" not in path.parts and not path.relative_to(root).as_posix().startswith(own)
        for line in names_effects(ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert not found, found


def _passes(costs: Costs) -> int:
    return sum(costs.work.values())


def _with_what_it_refines(name: str) -> str:
    refines = effects.get(name).refines
    return f"{name},{refines}" if refines else name


def test_the_counters_count():
    """Else the tests above would compare nothing with nothing."""
    costs = costs_of(scene="planes", warp=PORTABLE)
    assert all(costs.made.get(kind) for kind in ("texture", "buffer", "framebuffer", "vertex_array"))
    assert costs.work["ComputeShader.run"] >= 2 * 3 and costs.work["VertexArray.render"] >= 2 * 2
    assert costs != attrs.evolve(costs, sent=0)


def test_a_grid_of_voxels_is_paid_by_those_who_ask_for_it():
    """Frames weigh the same: the light is in the picture."""
    without, grid = (costs_of(scene="lantern", indirect=light) for light in ("converged", "voxels:size=16"))
    assert not {path for path in without.shaders if "voxel" in path}
    assert {"cloudlight/voxel_direct.comp", "cloudlight/voxel_fill.comp", "cloudlight/voxel_look.comp"} <= grid.shaders
    assert grid.layers == without.layers and grid.sent == without.sent
