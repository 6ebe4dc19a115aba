"""The inverse depth of the shown picture. Written beside the colour by warps that can, else carried
along by a second run."""

from __future__ import annotations

import numpy as np
import pytest
from golden_pictures import assert_golden, sheet
from reference.shown_depth import shown_depth
from worlds import World, has_twin, read, shown_by, twin_of

from hmdwarp.client import Carry, ShownDepth, parse_warp, pictures_read
from hmdwarp.client.warps import Output, warps
from hmdwarp.gpu import SCALAR, allocate

CARRYING = [warp.name for warp in warps if warp.carries]
BESIDE = [warp.name for warp in warps if warp.depth_reads is not None and warp.kind != "draw"]
SIZE = (67, 53)


def depth_of(gpu, world: World, name: str) -> np.ndarray:
    choice = parse_warp(name)
    world.bring(gpu, choice.entry)
    if choice.entry.depth_reads is not None:
        return _beside(gpu, world, name)[1]
    warp = choice.entry(gpu, world.size, world.shown_size, choice.settings)
    depth = ShownDepth(
        gpu, Carry(warp), pictures_read(choice.entry.needs(choice.settings)), world.size, world.shown_size
    )
    into = allocate(gpu.gl, world.shown_size, SCALAR)
    depth.run(world.inputs(choice.entry), into)
    gpu.gl.memory_barrier()
    found = read(into)[..., 0]
    for thing in (depth, warp):
        thing.close()
    into.release()
    return found


def _beside(gpu, world: World, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Colour and depth of one run."""
    entry = parse_warp(name).entry
    world.bring(gpu, entry)
    return shown_by(gpu, name, world.inputs(entry), world.shown_size, Output(depth=True))


@pytest.mark.parametrize("name", BESIDE)
def test_the_depth_beside_it_leaves_the_colour_as_it_is(gpu, name):
    """An invocation may handle fewer rows then and round elsewhere: one pixel of 100, in noise."""
    world = World(gpu, 7, SIZE)
    got, plain = _beside(gpu, world, name)[0], world.warp(gpu, name)
    assert (np.abs(got - plain).max(axis=-1) <= 4 * 2.0**-10).mean() > 0.99


@pytest.mark.parametrize("name", [name for name in CARRYING if has_twin(name)])
def test_it_equals_its_twin_under_every_warp(gpu, name):
    world = World(gpu, 4, SIZE, (SIZE[0] + 6, SIZE[1] - 5))
    got = depth_of(gpu, world, name)
    wanted = shown_depth(world.asked(parse_warp(name).settings), twin_of(name))
    decided = ~wanted.undecided
    assert decided.mean() > 0.9
    covered = wanted.colour[..., 3] > 0
    assert np.array_equal((got >= 0)[decided], covered[decided])
    both = decided & covered
    assert (np.abs(got - wanted.colour[..., 0]) <= wanted.tolerance)[both].all()
    assert set(np.unique(got[got < 0])) <= {-1.0}


def test_the_depth_of_warps_without_a_twin_is_as_before(gpu, tmp_path):
    found = []
    for name in (name for name in CARRYING if not has_twin(name)):
        world = World(gpu, 4, (45, 37), (51, 32))
        found.append((world.warp(gpu, name), depth_of(gpu, world, name)))
    share = 1 / 1000 if gpu.is_software else 1 / 20  # as the pictures, tests/client/test_contract.py
    assert_golden("effects/shown_depth", sheet(*found), tmp_path, share=share)
