"""Reflections after the warp. Nothing lost where nothing moved, better than glued on where
something did, and no black in mirrors."""

from __future__ import annotations

import numpy as np
import pytest
from mirrored import VIEW, mirrored_scene, moved
from reference.picture import HALF_UNIT
from worlds import read

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.client.effects import effects
from hmdwarp.errors import PlanError
from hmdwarp.frames import Mirrored, Needs
from hmdwarp.sources.server import Server

SIZE = (160, 144)
EVERY = ("planar_reflections", "glossy_reflections", "curved_reflections")
NAMES = ("planar_reflections", "glossy_reflections", "curved_reflections")


@pytest.fixture(scope="module")
def server(gpu):
    made = Server(gpu, mirrored_scene())
    yield made
    made.close()


def shown(
    gpu,
    server: Server,
    view,
    compensated: tuple[str, ...] = EVERY,
    warp: str = "iterative",
    fill: str = "none",
    **inputs,
):
    """(colour, coverage after the warp) of the rendered picture of VIEW in `view`."""
    plan = build_plan(compensated, warp, fill, "none", client_geometry=False, scanout="shown_last" in inputs)
    frame = server.draw_frame([VIEW], 0, SIZE, needs=plan.needs)
    compensator = Compensator(gpu, plan, None, SIZE, SIZE)
    result = compensator.run(PassInputs(frame.eyes[0], view, **inputs))
    out = read(result.shown.texture), read(result.warped.texture)[..., 3] > 0
    server.recycle(frame)
    compensator.close()
    return out


def mirrors_of(server: Server, view, needs: Needs) -> np.ndarray:
    frame = server.draw_frame([view], 0, SIZE, needs=needs)
    found = read(frame.eyes[0]["reflection"].surface)[..., 0] > 0
    server.recycle(frame)
    return found


def truth_of(server: Server, view) -> np.ndarray:
    eye = server.draw(view, SIZE)
    found = read(eye.colour)
    server.pool(SIZE).release(eye.colour)
    return found


@pytest.mark.parametrize("warp", ["iterative", "forward", "mesh", "none", "layered", "splat"])
def test_an_unmoved_view_is_the_whole_picture(gpu, server, warp):
    found, _ = shown(gpu, server, VIEW, warp=warp)
    truth = truth_of(server, VIEW)
    # What mirrors show, the surface, its depth and the picture each pass through one more half
    # float, and the sum is stored as one; a disturbed look that moves by the depth's share (2^-10
    # of a few pixels) meets a contrast of at most 1.
    apart = np.abs(found - truth).max(axis=-1)
    assert np.median(apart) == 0
    assert (apart <= 4 * HALF_UNIT * truth.max() + 0.01).mean() > 0.995


def error(found: np.ndarray, truth: np.ndarray, where: np.ndarray) -> float:
    apart = np.clip(found, 0, 1) ** (1 / 2.2) - np.clip(truth, 0, 1) ** (1 / 2.2)
    return float((apart[where][:, :3] ** 2).mean())


MOVES = [((0.12, 0.02, 0.0), 0.05), ((0.0, -0.1, 0.1), -0.1), ((-0.2, 0.05, 0.1), 0.1)]


@pytest.mark.parametrize(("by", "turn"), MOVES)
def test_mirrors_are_much_better_than_glued_on(gpu, server, by, turn):
    view = moved(by, turn)
    truth, where = truth_of(server, view), mirrors_of(server, view, Needs(reflection=Mirrored.PLANE))
    glued, covered = shown(gpu, server, view, ())
    where &= covered
    even, _ = shown(gpu, server, view, tuple(name for name in EVERY if name != "glossy_reflections"))
    found, _ = shown(gpu, server, view)
    assert error(found, truth, where) < 0.5 * error(glued, truth, where)
    assert error(found, truth, where) < error(even, truth, where)


@pytest.mark.parametrize("warp", ["forward", "iterative", "mesh"])
def test_no_black_in_mirrors_and_no_colour_in_holes(gpu, server, warp):
    """Every mirror of this scene shows something bright, its own colour is what is dark."""
    view = moved((0.25, 0.1, 0.15), 0.15)
    found, covered = shown(gpu, server, view, warp=warp)
    wall = mirrors_of(server, view, Needs(reflection=Mirrored.PLANE)) & covered
    assert np.isfinite(found).all()
    assert (found[~covered] == 0).all()
    assert set(np.unique(found[..., 3])) <= {0, 1}
    bright = truth_of(server, view)[..., :3].max(axis=-1)
    dark = wall & (found[..., :3].max(axis=-1) < 0.3 * bright)
    assert dark.sum() <= 0.02 * wall.sum()


@pytest.mark.parametrize("name", NAMES)
def test_each_effect_is_an_entry_of_the_one_pass(name):
    effect = effects.get(name)
    assert effect.made_by.name == "reflections"
    assert effect.needs["reflection"] in (Mirrored.PLANE, Mirrored.CURVED)
    plan = build_plan((effect.name,), "iterative", "none", "none", client_geometry=False)
    passes = [step for step in plan.steps if step.stage == "effects"]
    assert bool(passes) == (name != "glossy_reflections")  # which refines the plane ones
    assert ("rendered.reflection" in plan.layers) == bool(passes)


def test_a_frame_without_the_layer_is_told(gpu, server):
    plan = build_plan(EVERY, "iterative", "none", "none", client_geometry=False)
    compensator = Compensator(gpu, plan, None, SIZE, SIZE)
    eye = server.draw_frame([VIEW], 0, SIZE, needs=plan.needs).eyes[0]
    with pytest.raises(PlanError, match="no layer of them"):
        compensator.run(PassInputs(eye.having(reflection=None), VIEW))
    compensator.close()
