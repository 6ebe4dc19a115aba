"""One contract for every registered warp and fill, on the shader and on its float64 twin."""

from __future__ import annotations

import numpy as np
import pytest
from golden_pictures import assert_golden, name_of, names_in, sheet
from holed import Holed
from together import together
from worlds import World, assert_equals_twin, every_choice, has_twin

from hmdwarp.base import InputError
from hmdwarp.client import every_fill, parse_fills, parse_warp
from hmdwarp.client.warps.mesh import MOST_SIDE
from hmdwarp.geometry import GuardBand

CHOICES = every_choice()
# Numbers that nobody's baseline is; words are among the choices.
SETTINGS = [
    "iterative:slanted=3",
    "iterative:seed=rotation,steps=5",
    "iterative:steps=1,tolerance=0.1,converged=2",
    "mesh_adaptive:tolerance=0",
    "mesh_adaptive:block=4,tolerance=0.02",
    "mesh:grid=2",
    "mesh:grid=9",
    "mesh:grid=17,ring=0.1",
    "mesh:grid=30,ring=0",
]
SIZES = [(67, 53), (64, 64), (1, 1), (129, 2), (31, 127)]


@pytest.mark.parametrize("name", CHOICES)
@together("size", SIZES)
def test_same_pose_gives_the_same_picture_bit_for_bit(gpu, name, size):
    world = World(gpu, 1, size, moved=False)
    wanted = world.look_along_a_face(gpu, 1) if parse_warp(name).entry.resamples else world.colour
    assert np.array_equal(world.warp(gpu, name), wanted)


@pytest.mark.parametrize("name", [name for name in [*CHOICES, *SETTINGS] if has_twin(name)])
@together("seed", range(7))
def test_shader_equals_the_float64_twin(gpu, name, seed):
    """The last time with an uneven guard band; hard cases have what holds of every picture."""
    size = (60, 44) if seed == 6 else SIZES[seed % len(SIZES)]
    shown = size if seed % 2 or seed == 6 else (size[0] + 6, max(size[1] - 5, 1))
    world = World(gpu, seed, size, shown)
    if seed == 6:
        world.render_wider(gpu, (1.5, 1.1))
    assert_equals_twin(world.warp(gpu, name), world.reference(name))


WITHOUT_TWIN = [name for name in [*CHOICES, *SETTINGS] if not has_twin(name)]


def steep_world(gpu) -> World:
    """Floors to the horizon again and again, in each column curved more than in the last."""
    world = World(gpu, 4, (45, 37))
    y, x = np.mgrid[:37, :45]
    steeper = 1.1 + 0.5 * x / 45
    depth = 1e-4 + 0.05 * (steeper ** (y % 9) - 1) / (steeper - 1)
    world.inverse_depth = np.where(world.inverse_depth < 0, -1, depth).astype(np.float32).astype(np.float64)
    world.upload(gpu)
    return world


@pytest.mark.parametrize("name", WITHOUT_TWIN)
def test_random_worlds_are_warped_as_before(gpu, tmp_path, name):
    """Larger, smaller, with an uneven guard band, and steep. A GPU snaps corners to 1/256 of a
    pixel: beside edges, a twentieth of noise, it may show another surface."""
    worlds = [World(gpu, 0, (45, 37), (51, 32)), World(gpu, 3, (64, 48), (29, 23)), World(gpu, 6, (30, 24))]
    worlds[-1].render_wider(gpu, (1.5, 1.1))
    found = sheet(*((world.warp(gpu, name), None) for world in (*worlds, steep_world(gpu))))
    assert_golden(f"warps/{name_of(name)}", found, tmp_path, share=1 / 1000 if gpu.is_software else 1 / 20)


def test_every_warp_without_a_twin_has_a_golden_picture():
    assert names_in("warps") == {name_of(name) for name in WITHOUT_TWIN}


@pytest.mark.parametrize("name", CHOICES)
@together("guard", [1.3, (1.1, 1.4), GuardBand(size=(85, 50))])
def test_a_guard_band_is_cut_off_exactly(gpu, name, guard):
    world = World(gpu, 5, (60, 44), moved=False)
    if parse_warp(name).entry.resamples:
        wanted = world.look_along_a_face(gpu, 1, margin=7)
        assert np.array_equal(world.warp(gpu, name), wanted)
        return
    inner = world.shown_size
    world.render_wider(gpu, guard)
    fov, size = world.rendered_view.fov, world.size
    left, right, down, up = fov.tangents
    x = round((world.shown_view.fov.tangents[0] - left) / (right - left) * size[0])
    y = round((world.shown_view.fov.tangents[2] - down) / (up - down) * size[1])
    cut = np.s_[y : y + inner[1], x : x + inner[0]]
    world.client = world.inverse_depth[cut]
    world.upload(gpu)
    assert np.array_equal(world.warp(gpu, name), world.colour[cut])


@pytest.mark.parametrize(
    ("name", "size", "most"),
    [
        ("forward", (16384, 16384), "a rendered picture of 16384x16384: 'forward' takes at most"),
        ("forward_raster", (16385, 2), "a rendered picture of 16385x2: 'forward_raster' takes at most 16384 pixels a"),
        ("mesh", (MOST_SIDE + 1, 4), f"at most {MOST_SIDE}"),
    ],
)
def test_a_rendered_picture_beyond_what_names_its_pixels_is_refused(gpu, name, size, most):
    choice = parse_warp(name)
    with pytest.raises(InputError, match=most):
        choice.entry(gpu, size, (8, 8), choice.settings)


FILLS = [name for name in every_fill() if parse_fills(name)]


@pytest.mark.parametrize("name", FILLS)
@together("size", SIZES)
def test_fill_leaves_what_is_covered_alone(gpu, name, size):
    holed = Holed(gpu, 7, size, empty=0.3)
    got, depth = holed.fill(gpu, name)
    covered = holed.colour[..., 3] > 0
    assert np.array_equal(got[covered], holed.colour[covered])
    assert np.array_equal(depth[covered], holed.inverse_depth[covered])
    assert set(np.unique(got[..., 3])) <= {0.0, 1.0}
    assert (got[got[..., 3] == 0] == 0).all()
    assert np.isfinite(got).all()
    assert np.isfinite(depth).all()


@pytest.mark.parametrize("name", FILLS)
def test_a_complete_fill_leaves_nothing_empty(gpu, name):
    (choice,) = parse_fills(name)
    if not choice.entry.complete:
        pytest.skip(f"fill '{name}' does not say that it is complete")
    for size, empty in (((67, 53), 0.5), ((31, 127), 0.999), ((1, 1), 0.0), ((129, 2), 0.9)):
        holed = Holed(gpu, 9, size, empty)
        holed.keep_one()
        assert (holed.fill(gpu, name)[0][..., 3] == 1).all(), size


@pytest.mark.parametrize("name", FILLS)
def test_pictures_without_holes_and_without_colour_are_filled(gpu, name):
    for empty in (0.0, 1.0):
        holed = Holed(gpu, 11, (19, 23), empty)
        got, _ = holed.fill(gpu, name)
        assert np.isfinite(got).all()
        if not empty:
            assert np.array_equal(got, holed.colour)
