"""The mesh.

What is cut where, what every pixel keeps, and that nothing leaks, mirrors, smears or speckles.
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from reference.picture import TwinInputs
from worlds import World, read, twin_of

from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.client.warp_kinds import steepest
from hmdwarp.client.warp_kinds.mesh import MOST_SIDE, reach
from hmdwarp.errors import InputError
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate

SIZE = (64, 48)
FOV = Fov(*np.deg2rad([-45, 45, -40, 40]))
CUTS = ["mesh", "mesh:cut=vertex", "mesh:cut=both", "mesh_adaptive"]
SIZES = [(67, 53), (64, 64), (1, 1), (129, 2), (31, 127)]


class Scene:
    """A rendered picture of chosen depth.

    Red grows to the right, green upwards, blue is 1 where it is nearer than 1 m.
    """

    def __init__(
        self, gpu, inverse_depth: np.ndarray, pose: Pose, fov: Fov = FOV, shown_size: tuple[int, int] | None = None
    ) -> None:
        self.gpu, high, wide = gpu, *inverse_depth.shape
        self.size, self.shown_size = (wide, high), shown_size or (wide, high)
        y, x = np.mgrid[:high, :wide]
        known = np.isfinite(inverse_depth) & (inverse_depth >= 0)
        colour = (
            np.stack([(x + 0.5) / wide, (y + 0.5) / high, inverse_depth > 1, np.ones((high, wide))], axis=-1)
            * known[..., None]
        )
        self.colour, self.inverse_depth = colour.astype(np.float16), inverse_depth.astype(np.float32)
        self.rendered, self.shown = View(Pose(), fov), View(pose, fov)
        self.textures = allocate(gpu.gl, self.size, COLOUR), allocate(gpu.gl, self.size, SCALAR)
        self.textures[0].write(self.colour.tobytes(), alignment=1)
        self.textures[1].write(self.inverse_depth.tobytes(), alignment=1)

    def warp(self, spec: str) -> np.ndarray:
        choice = parse_warp(spec)
        warp = choice.entry(self.gpu, self.size, self.shown_size, choice.settings)
        canvas = Canvas(self.gpu.gl, self.shown_size)
        warp.run(PassInputs(EyeImage(self.rendered, *self.textures), self.shown), canvas)
        self.gpu.gl.memory_barrier()
        out = read(canvas.texture)
        warp.close()
        canvas.release()
        return out

    def twin(self, spec: str):
        choice = parse_warp(spec)
        asked = TwinInputs(
            self.colour.astype(float), self.inverse_depth.astype(float), self.rendered, self.shown, self.shown_size
        )
        return twin_of(choice.entry.name)(attrs.evolve(asked, settings=choice.settings))


def block(near: float = 2.0, far: float = 0.25) -> np.ndarray:
    """A near square before a far wall."""
    depth = np.full(SIZE[::-1], far)
    depth[16:32, 24:40] = near
    return depth


def floor(fov: Fov = FOV) -> np.ndarray:
    """A floor 1.6 m below the eye up to its horizon, sky above."""
    high = SIZE[1]
    tangent = fov.tangents[2] + (fov.tangents[3] - fov.tangents[2]) * (np.arange(high) + 0.5) / high
    return np.broadcast_to(np.maximum(-tangent / 1.6, 0)[:, None], SIZE[::-1]).copy()


@pytest.mark.parametrize(
    "spec", ["mesh:cut=vertex", "mesh:cut=both", "mesh_adaptive:tolerance=0", "mesh_adaptive:block=4,tolerance=0.02"]
)
@pytest.mark.parametrize("seed", range(5))
def test_every_setting_equals_the_twin(gpu, spec, seed):
    world = World(gpu, seed + 20, SIZES[seed], SIZES[-seed])
    got, wanted = world.warp(gpu, spec), world.reference(spec)
    decided = ~wanted.undecided
    assert decided.mean() > 0.9 or decided.size < 1000
    assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
    assert (np.abs(got[..., :3] - wanted.colour[..., :3]).max(axis=-1) <= wanted.tolerance)[decided].all()


@pytest.mark.parametrize("spec", ["mesh:grid=2", "mesh:grid=9", "mesh:grid=17,ring=0.1", "mesh:grid=30,ring=0"])
@pytest.mark.parametrize("seed", range(3))
def test_a_grid_coarser_than_the_picture_equals_the_twin(gpu, spec, seed):
    world = World(gpu, seed + 40, (67, 53), SIZES[seed])
    got, wanted = world.warp(gpu, spec), world.reference(spec)
    decided = ~wanted.undecided
    # A GPU moves corners by up to half of 1/256 pixel, so a picture of one pixel may be undecided.
    assert decided.mean() > 0.9 or (decided.size == 1 and not gpu.is_software)
    assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
    assert (np.abs(got[..., :3] - wanted.colour[..., :3]).max(axis=-1) <= wanted.tolerance)[decided].all()


@pytest.mark.parametrize("spec", CUTS)
def test_an_edge_reveals_a_hole_and_each_surface_keeps_its_own_pixels(gpu, spec):
    """20 cm to the right a square at 0.5 m moves 12.8 pixels to the left of where infinity stays,
    the wall at 4 m 1.6.
    """
    scene = Scene(gpu, block(), Pose((0.2, 0, 0)))
    out = scene.warp(spec)
    near = out[..., 2] == 1
    # 16 x 16 pixels that keep half a pixel around each centre stay a square of 16 x 16.
    assert near.sum() == pytest.approx(256, abs=2 * 16)
    # The sampler rounds its weights; a sheet's first few hundredths, as steep as a surface may be,
    # are taken for one.
    bleeds = np.minimum(out[..., 2], 1 - out[..., 2])
    assert bleeds.max() <= (0.06 if "cut=vertex" in spec else 1e-5), "no colour of one surface bleeds into another"
    hole = out[..., 3] == 0
    assert 16 * 9 <= hole[16:32, 24:42].sum() <= 16 * 13, "11.2 pixels of wall were hidden"
    assert not hole[:14, :60].any() and not hole[34:, :60].any()


@pytest.mark.parametrize("spec", CUTS)
def test_a_floor_to_the_horizon_stays_whole(gpu, spec):
    """Its last rows are much steeper than any limit.

    That they go on straight is what keeps them together.
    """
    scene = Scene(gpu, floor(), Pose((0.15, 0.3, 0)))
    out = scene.warp(spec)
    if "cut" not in spec:
        assert (out[:, 8:-8, 3] == 1).all()
    wanted = scene.twin(spec)
    assert np.array_equal(out[..., 3][~wanted.undecided], wanted.colour[..., 3][~wanted.undecided])


@pytest.mark.parametrize("spec", CUTS)
def test_depths_of_a_millimetre_and_of_a_thousand_kilometres(gpu, spec):
    depth = np.full(SIZE[::-1], 1e-6)
    depth[10:20, 10:20], depth[30:40, 30:40] = 1e3, 0.0
    scene = Scene(gpu, depth, Pose((1e-4, 0, 0)))
    out, wanted = scene.warp(spec), scene.twin(spec)
    assert np.isfinite(out).all()
    assert np.array_equal(out[..., 3][~wanted.undecided], wanted.colour[..., 3][~wanted.undecided])


def test_the_limit_is_a_plane_at_that_angle():
    """A plane turned by 80 degrees about the vertical axis.

    Inverse depth along the middle row, by its geometry.
    """
    view, angle = View(Pose(), FOV), np.deg2rad(80)
    rays = view.rays((1001, 1))[0]
    normal = np.array([np.sin(angle), 0, np.cos(angle)])
    inverse = rays @ -normal / 2.0
    middle = inverse[500]
    assert abs(inverse[501] - inverse[500]) / middle == pytest.approx(steepest(view, (1001, 1), 80.0)[0], rel=1e-6)


def test_reach_bounds_how_far_depth_moves_a_point():
    rng = np.random.default_rng(2)
    for _ in range(20):
        rendered = View(Pose(rng.normal(size=3), rng.normal(size=4)), FOV)
        turn = Pose(rng.normal(scale=0.1, size=3), (*rng.normal(scale=0.05, size=3), 1))
        shown = View(rendered.pose @ turn, FOV)
        forward = WarpMap.between(rendered, SIZE, shown, SIZE)
        place = rng.uniform([0, 0], SIZE, (500, 2))
        before, _, w = forward.apply(place, np.full(500, 0.3))
        after, _, _ = forward.apply(place, np.full(500, 0.3 + 1e-6))
        inside = ((before >= 0) & (before <= SIZE)).all(axis=1)
        moved = np.linalg.norm(after - before, axis=1) * w / 1e-6
        assert (moved[inside] <= reach(forward, SIZE) * (1 + 1e-3)).all()


def test_a_picture_beyond_the_names_of_its_cells_is_refused(gpu):
    with pytest.raises(InputError, match=f"at most {MOST_SIDE}"):
        parse_warp("mesh").entry(gpu, (MOST_SIDE + 1, 4), (8, 8))
