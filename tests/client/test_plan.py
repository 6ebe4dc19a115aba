"""The plan over every combination of registered passes. What runs, why, and that nothing else costs
anything."""

from __future__ import annotations

import itertools

import attrs
import moderngl
import pytest
from client_scene import ClientScene
from panels import headset_for
from together import together
from worlds import World

from hmdwarp.base import PlanError
from hmdwarp.client import (
    CLIENT_DEPTH,
    CLIENT_MODEL,
    PANEL,
    SHOWN,
    SHOWN_DEPTH,
    Compensator,
    PassInputs,
    Plan,
    build_plan,
    parse_fills,
)
from hmdwarp.client.effects import effects
from hmdwarp.client.fills import fills
from hmdwarp.client.lens import lenses
from hmdwarp.client.warps import warps
from hmdwarp.frames.layers import readable_names
from hmdwarp.frames.layers.scene_parts import Simplified
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, allocate

# Each warp with and without a fill, each fill after a warp that carries depth and one that cannot,
# chains; each lens; geometry or not.
_PAIRS = [
    *itertools.product(warps.names(), ("none", "interpolate")),
    *itertools.product(("forward", "environment"), fills.names()),
]
_PAIRS += [("iterative", "memory+pyramid"), ("none", "wide+stretch+constant"), ("rotation", "memory+model:share=0.05")]
_MANY = [(w, f, n, g) for (w, f), n, g in itertools.product(dict.fromkeys(_PAIRS), ("none", "radial"), (True, False))]
ALL = list(dict.fromkeys([*_MANY, *(("forward", "none", lens, True) for lens in lenses.names())]))


def _draws(warp: str, fill: str) -> bool:
    """Whether it wants the scene's triangles on the client."""
    entries = (warps.get(warp), *(fill.entry for fill in parse_fills(fill)))
    return any({CLIENT_DEPTH, CLIENT_MODEL} & {*entry.reads} for entry in entries)


POSSIBLE = [(w, f, n, g) for w, f, n, g in ALL if g or not _draws(w, f)]


def plan_of(warp: str, fill: str, lens: str, geometry: bool) -> Plan:
    return build_plan((), warp, fill, lens, client_geometry=geometry)


# --- what is in it ------------------------------------------------------------------------------


@together("choice", POSSIBLE)
def test_everything_read_was_written_before(choice):
    plan = plan_of(*choice)
    known = {*readable_names(), *((CLIENT_MODEL,) if choice[3] else ())}
    for step in plan.steps:
        assert set(step.reads) <= known, step.name
        known |= set(step.writes)
    assert SHOWN in known


@together("choice", POSSIBLE)
def test_every_stage_runs_or_is_left_out_with_a_reason(choice):
    warp, fill, lens, geometry = choice
    plan = plan_of(*choice)
    stages = [step.stage for step in plan.steps]
    left_out = dict(plan.left_out)
    order = [stage for stage in ("client_depth", "warp", "fill", "lens") if stage in stages]
    assert list(dict.fromkeys(stages)) == order and stages == sorted(stages, key=order.index), "in this order"
    chain, depth = (len(parse_fills(fill)), plan.warps_twice)
    assert stages.count("fill") == chain + depth and all(stages.count(stage) == 1 for stage in order if stage != "fill")
    assert set(stages) | set(left_out) == {"client_depth", "warp", "fill", "lens", *effects.names()}
    assert not set(stages) & set(left_out)
    assert all(reason.strip() for reason in [*left_out.values(), *(step.reason for step in plan.steps)])
    assert ("fill" in stages) == (fill != "none")
    assert ("lens" in stages) == (lens != "none")
    assert ("client_depth" in stages) == (CLIENT_DEPTH in warps.get(warp).reads)
    assert plan.draws_client_depth == ("client_depth" in stages)
    assert (plan.warp.name, plan.fill, plan.lens.name) == (warp, fill, lens)
    assert (PANEL in {w for step in plan.steps for w in step.writes}) == (lens != "none")


@together("choice", POSSIBLE)
def test_a_frame_carries_what_is_read_of_it_and_no_more(choice):
    plan = plan_of(*choice)
    read = [plan.warp.reads_for(plan.choice.settings), *(fill.entry.reads for fill in parse_fills(choice[1]))]
    wanted = {name for reads in read for name in reads if name in readable_names()}
    if plan.warps_twice:
        wanted.add("rendered.inverse_depth")
    elif plan.makes_shown_depth:
        wanted |= set(plan.warp.depth_reads or ()) & set(readable_names())
    assert set(plan.layers) == wanted


@pytest.mark.parametrize("registry", [warps, fills, lenses], ids=lambda r: r.kind)
def test_every_entry_says_what_it_is_and_reads_what_exists(registry):
    known = {*readable_names(), CLIENT_DEPTH, CLIENT_MODEL, SHOWN, SHOWN_DEPTH, PANEL}
    for entry in registry:
        assert entry.summary
        assert entry.source
        assert set(entry.reads) <= known
        if registry is warps:
            assert entry.kind in ("gather", "scatter", "draw")
            assert entry.exact_when
            assert entry.gets_wrong
        else:
            assert isinstance(entry.is_pass, bool)


# --- what is refused ----------------------------------------------------------------------------


def test_only_passes_that_draw_without_geometry_are_impossible():
    refused = set(ALL) - set(POSSIBLE)
    assert refused and all(_draws(warp, fill) and not geometry for warp, fill, _, geometry in refused)
    for choice in refused:
        with pytest.raises(PlanError, match="needs the scene's geometry on the client"):
            plan_of(*choice)


# --- what it costs ------------------------------------------------------------------------------

RENDERED_SIZE, SHOWN_SIZE = (33, 21), (29, 17)


@pytest.fixture
def made(monkeypatch) -> list:
    """Textures, buffers and framebuffers that are made from now on."""
    every: list = []

    def noting(make):
        return lambda *given, **named: (every.append(make(*given, **named)), every[-1])[1]

    for kind in ("texture", "buffer", "framebuffer"):
        monkeypatch.setattr(moderngl.Context, kind, noting(getattr(moderngl.Context, kind)))
    return every


def given_for(gpu, warp: str) -> PassInputs:
    """All that this warp and any fill read, for RENDERED_SIZE and SHOWN_SIZE."""
    world = World(gpu, 1, RENDERED_SIZE, SHOWN_SIZE, moved=False)
    world.bring(gpu, warps.get(warp))
    world.bring_layers(gpu, tuple(name for fill in fills for name in fill.reads))
    inputs = attrs.evolve(world.inputs(warps.get(warp)), client_inverse_depth=None)
    beside = {Simplified(): allocate(gpu.gl, RENDERED_SIZE, COLOUR)}
    return attrs.evolve(inputs, rendered=inputs.rendered.having(wide=world.rendered, difference=beside))


@pytest.fixture(scope="module")
def geometry(gpu):
    """Everything the client can draw, drawn once, so that what is compiled and allocated for it is
    there already."""
    scene = ClientScene(gpu)
    scene.server.draw_depth(
        View(Pose(), Fov(-0.7, 0.7, -0.7, 0.7)), SHOWN_SIZE, allocate(gpu.gl, SHOWN_SIZE, SCALAR), 0
    )
    return scene


@pytest.mark.parametrize("choice", POSSIBLE, ids=str)
def test_a_plan_runs_its_steps_makes_nothing_later_and_frees_all(gpu, choice, geometry, made):
    """What a pass that is left out spares is counted in tests/test_pays_nothing.py."""
    warp, fill, lens, _ = choice
    plan, inputs = plan_of(*choice), given_for(gpu, warp)
    for _ in range(2):  # what the client's model makes at its first use belongs to the geometry
        made.clear()
        compensator = Compensator(gpu, plan, headset_for(lens), RENDERED_SIZE, SHOWN_SIZE, geometry)
        for eye in (0, 1):
            compensator.run(attrs.evolve(inputs, eye=eye))
        gpu.timer.collect()
        before = len(made), len(gpu.shaders)
        result = [compensator.run(attrs.evolve(inputs, eye=eye)) for eye in (0, 1, 0)][-1]
        assert (len(made), len(gpu.shaders)) == before, "run() compiles and allocates nothing"
        assert (result.shown is result.warped) == (fill == "none")
        assert (result.panel is result.shown) == (lens == "none")
        assert [name for name, _ in result.filled] == [step.entry.name for step in parse_fills(fill)]
        assert [name for name, _ in gpu.timer.collect()] == [step.stage for step in plan.steps] * 3
        compensator.close()
    left = [thing for thing in made if not isinstance(thing.mglo, moderngl.InvalidObject)]
    # A framebuffer over a texture belongs to whoever draws into it, here the client's geometry.
    assert not left or (_draws(warp, fill) and all(isinstance(thing, moderngl.Framebuffer) for thing in left))


def test_a_runtime_corrects_the_lens_and_gets_the_depth():
    def plan(lens: str):
        return build_plan((), "iterative", "none", lens, client_geometry=False, distorts="R", takes_depth="R")

    assert plan("none").hands_depth_on
    assert ("lens", "R corrects the lens by itself") in plan("none").left_out
    assert any("depth of what it shows for R" in f"{step.name} {step.reason}" for step in plan("none").steps)
    with pytest.raises(PlanError, match="R corrects the lens by itself"):
        plan("radial")
