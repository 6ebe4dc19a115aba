"""A scene pays for what it calls for, and for nothing else.

Shaders, textures, bytes and dispatches are counted.
"""

from __future__ import annotations

import functools
from collections import Counter

import attrs
import moderngl
import pytest
from replays import small

from hmdwarp.client.effects import effects
from hmdwarp.frames import frame_bytes
from hmdwarp.frames.layers import layers
from hmdwarp.gpu import ShaderLibrary, timers
from hmdwarp.run import set_up_replay
from hmdwarp.scenes import load_scene, scenes

ALLOCATIONS = ("texture", "buffer", "framebuffer", "depth_renderbuffer", "vertex_array")
WORK = ((moderngl.ComputeShader, "run"), (moderngl.ComputeShader, "run_indirect"), (moderngl.VertexArray, "render"))
WORK += ((moderngl.VertexArray, "render_indirect"),)


@attrs.frozen
class Costs:
    """shaders: the files of all programs compiled.

    made: how many of each kind of thing. work: dispatches and draws of one refresh, drawing the
    frame included. layers: bytes of each layer of a frame; sent: of a frame, as the link
    was told. textures: how many of each size, components and type.
    """

    shaders: frozenset[str]
    made: dict[str, int]
    work: dict[str, int]
    layers: dict[str, int]
    sent: int
    textures: dict[tuple, int]


def costs_of(refreshes: int = 3, **options: object) -> Costs:
    """Return the costs of a small run in its steady state; the same run is counted once."""
    return _costs_of(refreshes, tuple(sorted(options.items())))


@functools.cache
def _costs_of(refreshes: int, options: tuple[tuple[str, object], ...]) -> Costs:
    shaders: set[str] = set()
    made, work, textures = Counter(), Counter(), Counter()
    asked = small(latency_ms=50.0, rate_hz=60.0, **dict(options))
    with pytest.MonkeyPatch.context() as patch:
        get = ShaderLibrary._get

        def recorded(self, paths, defines, *more):
            shaders.update(paths)
            return get(self, paths, defines, *more)

        patch.setattr(ShaderLibrary, "_get", recorded)
        patch.setattr(timers, "check_clocks", _uncounted(timers.check_clocks, made, textures))
        for kind in ALLOCATIONS:
            patch.setattr(moderngl.Context, kind, _counted(getattr(moderngl.Context, kind), made, kind, textures))
        for owner, name in WORK:
            patch.setattr(owner, name, _counted(getattr(owner, name), work, f"{owner.__name__}.{name}", None))
        with set_up_replay(asked) as setup:
            shown = 0
            for number, instant_ns in setup.schedule.numbered():
                work.clear()
                setup.loop.draw(instant_ns)
                shown += number >= 0 and setup.loop.show(instant_ns) is not None
                if shown == refreshes:
                    break
            assert shown == refreshes
            layers = frame_bytes(setup.plans[0].needs, setup.sizes, setup.plans[0].layers)
            return Costs(
                frozenset(shaders), dict(made), dict(work), layers, setup.channel.transit.size_bytes, dict(textures)
            )


def _uncounted(probe, *counters: Counter):
    """What the probe of the clock makes is not the run's, and depends on how busy a machine is."""

    def call(gl):
        before = [Counter(counter) for counter in counters]
        found = probe(gl)
        for counter, old in zip(counters, before, strict=True):
            counter.clear()
            counter.update(old)
        return found

    return call


def _counted(function, counter: Counter, name: str, textures: Counter | None):
    def call(*args, **kwargs):
        counter[name] += 1
        if name == "texture" and textures is not None:
            textures[tuple(args[1]), args[2], kwargs.get("dtype", "f1")] += 1
        return function(*args, **kwargs)

    return call


SCENES = scenes.names()
PLAIN = [name for name in SCENES if not scenes.get(name).effects]
CALLING = [name for name in SCENES if scenes.get(name).effects]
# All that a plain scene may compile for warp `forward` and fill `interpolate`.
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


@pytest.mark.parametrize("scene", PLAIN)
def test_a_plain_scene_compiles_allocates_sends_and_runs_the_bare_minimum(scene):
    costs = costs_of(scene=scene, warp="forward", fill="interpolate", samples=4)
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


def test_every_effect_has_a_scene_that_calls_for_it():
    assert {effect for name in SCENES for effect in scenes.get(name).effects} == {
        effect.name for effect in effects if not effect.by_name_only
    }


def _passes(costs: Costs) -> int:
    return sum(costs.work.values())


def _with_what_it_refines(name: str) -> str:
    refines = effects.get(name).refines
    return f"{name},{refines}" if refines else name
