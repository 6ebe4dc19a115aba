"""One contract for every registered warp and fill, on the shader and on its float64 twin."""

from __future__ import annotations

import importlib
import pkgutil

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp import reference
from hmdwarp.client.fills import fills
from hmdwarp.client.fills.interpolate import MINIMUM_COUNT
from hmdwarp.client.plan import CLIENT_DEPTH
from hmdwarp.client.warps import warps
from hmdwarp.client.warps.backward import DEPTH_FLOOR, DEPTH_TOLERANCE
from hmdwarp.frame import EyeImage
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu.textures import COLOUR, SCALAR, Canvas, allocate
from hmdwarp.reference.interpolate import interpolate
from hmdwarp.reference.picture import GPU_SAMPLER_PIXELS


def twin_of(name: str):
    """The float64 twin of a warp: the public function of its name in a module of hmdwarp.reference."""
    modules = (importlib.import_module(f"hmdwarp.reference.{found.name}") for found in pkgutil.iter_modules(reference.__path__))
    twins = {module: vars(module)[name] for module in modules if name in vars(module) and vars(module)[name].__module__ == module.__name__}
    assert len(twins) == 1, f"warp '{name}' needs one function '{name}' in hmdwarp/reference, found {len(twins)}"
    return next(iter(twins.values()))


SIZES = [(67, 53), (64, 64), (1, 1), (129, 2), (31, 127)]


def read(texture) -> np.ndarray:
    """Texture to float64, bottom row first as stored."""
    dtype = {"f2": np.float16, "f4": np.float32}[texture.dtype]
    return np.frombuffer(texture.read(alignment=1), dtype).reshape(texture.height, texture.width, -1).astype(np.float64)


class World:
    """A late picture of a few planes with holes, and a shown view a plausible head motion away."""

    def __init__(self, gpu, seed: int, size: tuple[int, int], shown_size: tuple[int, int] | None = None, *, moved: bool = True) -> None:
        self.rng = rng = np.random.default_rng(seed)
        self.size, self.shown_size = size, shown_size or size
        fov = Fov(*np.deg2rad([-rng.uniform(30, 55), rng.uniform(30, 55), -rng.uniform(30, 55), rng.uniform(30, 55)]))
        self.late_view = View(Pose(rng.normal(size=3), rng.normal(size=4)), fov)
        turn = Rotation.from_rotvec(np.deg2rad(rng.normal(scale=5 if moved else 0, size=3)))
        step = rng.normal(scale=0.03 if moved else 0, size=3)
        pose = Pose(self.late_view.pose.position_m + step, (self.late_view.pose.rotation * turn).as_quat())
        self.shown_view = View(pose if moved else self.late_view.pose, fov)
        self._draw()
        self.client = self._client_depth()
        self.upload(gpu)
        # llvmpipe turns a place into 0..1 and back in float32: a division and a product, each half a unit of the place.
        self.sampler_pixels = 4 * 2.0**-24 * max(size) if gpu.is_software else GPU_SAMPLER_PIXELS

    def _draw(self) -> None:
        rng, (wide, high) = self.rng, self.size
        colour = rng.uniform(0, 2, (high, wide, 3))
        depth = np.full((high, wide), 0.2)
        y, x = np.mgrid[:high, :wide] / max(self.size)
        for _ in range(6):
            inside = (abs(x - rng.uniform(0, 1)) < rng.uniform(0.05, 0.2)) & (abs(y - rng.uniform(0, 1)) < rng.uniform(0.05, 0.2))
            plane = rng.uniform(0.05, 1.5) + rng.normal(scale=0.1) * x + rng.normal(scale=0.1) * y
            depth = np.where(inside & (plane > depth), plane, depth)
        depth[(x + y) % 0.3 < 0.03] = 0  # infinitely far
        if depth.size > 4:
            depth[rng.uniform(size=depth.shape) < 0.02] = -1  # no depth
        covered = depth >= 0
        self.inverse_depth = depth.astype(np.float32).astype(np.float64)
        self.colour = np.concatenate([colour * covered[..., None], covered[..., None]], axis=2).astype(np.float16).astype(np.float64)

    def _client_depth(self) -> np.ndarray:
        """Any depth will do for the contract: the late depth itself, resized, so that many pixels agree and many do not."""
        (wide, high), (w, h) = self.size, self.shown_size
        return self.inverse_depth[np.arange(h) * high // h][:, np.arange(w) * wide // w]

    def upload(self, gpu) -> None:
        texture, depth = allocate(gpu.gl, self.size, COLOUR), allocate(gpu.gl, self.size, SCALAR)
        texture.write(self.colour.astype(np.float16).tobytes(), alignment=1)
        depth.write(self.inverse_depth.astype(np.float32).tobytes(), alignment=1)
        self.late = EyeImage(self.late_view, texture, depth)
        self.client_texture = allocate(gpu.gl, self.shown_size, SCALAR)
        self.client_texture.write(self.client.astype(np.float32).tobytes(), alignment=1)

    def warp(self, gpu, name: str) -> np.ndarray:
        entry = warps.get(name)
        warp, canvas = entry(gpu, self.size, self.shown_size), Canvas(gpu.gl, self.shown_size)
        own = self.client_texture if CLIENT_DEPTH in entry.reads else None
        warp.run(self.late, self.shown_view, canvas, own)
        gpu.gl.memory_barrier()
        out = read(canvas.texture)
        warp.run(self.late, self.shown_view, canvas, own)  # a second run must not see what the first left behind
        gpu.gl.memory_barrier()
        assert np.array_equal(out, read(canvas.texture), equal_nan=True), "two runs differ"
        warp.close()
        canvas.release()
        return out

    def reference(self, name: str):
        return twin_of(name)(
            self.colour,
            self.inverse_depth,
            self.late_view,
            self.shown_view,
            self.shown_size,
            client_inverse_depth=self.client,
            tolerance=DEPTH_TOLERANCE,
            floor=DEPTH_FLOOR,
            sampler_pixels=self.sampler_pixels,
        )


@pytest.mark.parametrize("name", warps.names())
@pytest.mark.parametrize("size", SIZES, ids="{0[0]}x{0[1]}".format)
def test_same_pose_gives_the_same_picture_bit_for_bit(gpu, name, size):
    world = World(gpu, 1, size, moved=False)
    assert np.array_equal(world.warp(gpu, name), world.colour)


@pytest.mark.parametrize("name", warps.names())
@pytest.mark.parametrize("seed", range(6))
def test_shader_equals_the_float64_twin(gpu, name, seed):
    size = SIZES[seed % len(SIZES)]
    shown = size if seed % 2 else (size[0] + 6, max(size[1] - 5, 1))
    world = World(gpu, seed, size, shown)
    got, wanted = world.warp(gpu, name), world.reference(name)
    decided = ~wanted.undecided
    # Rounding may decide only near borders between pixels and near equal depths: a few pixels in a hundred at these sizes.
    if decided.size > 1000:
        assert decided.mean() > 0.9
    assert np.array_equal(got[..., 3][decided], wanted.colour[..., 3][decided])
    difference = np.abs(got[..., :3] - wanted.colour[..., :3]).max(axis=-1)
    assert (difference <= wanted.tolerance)[decided].all(), f"worst {difference[decided].max()}"


@pytest.mark.parametrize("name", warps.names())
def test_uncovered_is_black_with_alpha_zero_and_nothing_is_nan(gpu, name):
    out = World(gpu, 3, (67, 53)).warp(gpu, name)
    assert np.isfinite(out).all()
    assert set(np.unique(out[..., 3])) <= {0.0, 1.0}
    assert (out[out[..., 3] == 0] == 0).all()


@pytest.mark.parametrize("name", warps.names())
def test_a_guard_band_is_cut_off_exactly(gpu, name):
    world = World(gpu, 5, (60, 44), moved=False)
    fov, size = world.late_view.fov.guarded(1.3, world.size)
    inner, world.size = world.size, size
    world.late_view, world.shown_view = View(world.late_view.pose, fov), world.late_view
    world.shown_size = inner
    world._draw()
    left, right, down, up = fov.tangents
    x = round((world.shown_view.fov.tangents[0] - left) / (right - left) * size[0])
    y = round((world.shown_view.fov.tangents[2] - down) / (up - down) * size[1])
    cut = np.s_[y : y + inner[1], x : x + inner[0]]
    world.client = world.inverse_depth[cut]
    world.upload(gpu)
    assert np.array_equal(world.warp(gpu, name), world.colour[cut])


@pytest.mark.parametrize("name", fills.names())
@pytest.mark.parametrize("size", SIZES, ids="{0[0]}x{0[1]}".format)
def test_fill_leaves_what_is_covered_alone(gpu, name, size):
    entry = fills.get(name)
    if not entry.is_pass:
        pytest.skip(f"fill '{name}' is no pass: the plan leaves it out")
    world = World(gpu, 7, size)
    world.colour[world.rng.uniform(size=world.colour.shape[:2]) < 0.3] = 0
    warped, filled = Canvas(gpu.gl, size), Canvas(gpu.gl, size)
    warped.texture.write(world.colour.astype(np.float16).tobytes(), alignment=1)
    entry(gpu, size).run(warped, filled)
    gpu.gl.memory_barrier()
    got = read(filled.texture)
    covered = world.colour[..., 3] > 0
    assert np.array_equal(got[covered], world.colour[covered])
    assert (got[got[..., 3] == 0] == 0).all()


def test_interpolate_equals_its_twin(gpu):
    size = (67, 53)
    world = World(gpu, 8, size)
    world.colour[world.rng.uniform(size=world.colour.shape[:2]) < 0.5] = 0
    warped, filled = Canvas(gpu.gl, size), Canvas(gpu.gl, size)
    warped.texture.write(world.colour.astype(np.float16).tobytes(), alignment=1)
    fills.get("interpolate")(gpu, size).run(warped, filled)
    gpu.gl.memory_barrier()
    wanted = interpolate(world.colour, MINIMUM_COUNT)
    # The mean of two half floats is stored as a half float: up to 2^-10 relative (truncated), colours below 2.
    assert np.abs(read(filled.texture) - wanted).max() <= 2 * 2.0**-10
    assert (wanted[..., 3] > world.colour[..., 3]).any()
    assert (wanted[..., 3] == 0).any()
