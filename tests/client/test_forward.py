"""Who wins where several drawn pixels land in one: the nearest, or by order from the epipole."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from worlds import World, read

from hmdwarp.base import InputError
from hmdwarp.client import PassInputs, parse_warp
from hmdwarp.client.warps import warps
from hmdwarp.frames import EyeImage
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import COLOUR, SCALAR, Canvas, allocate

FOV = Fov.from_tangents([-1, 1, -1, 1])
FAR = 2.0**-20  # 1/m: farther pixels are ordered by their index alone


def numbered(size: tuple[int, int]) -> np.ndarray:
    """A picture in which each pixel says its index: (column, row, 0) with coverage 1. Both below
    2048 are exact as half floats."""
    y, x = np.mgrid[: size[1], : size[0]]
    return np.stack([x, y, np.zeros_like(x), np.ones_like(x)], axis=-1).astype(np.float16)


class Scatter:
    """One scatter warp of fixed sizes, run on several depth pictures in turn (bottom row first)."""

    def __init__(
        self, gpu, size, shown_size, rendered_pose: Pose | None = None, shown_pose: Pose | None = None, spec="forward"
    ) -> None:
        self.gpu, self.size, self.shown_size = gpu, size, shown_size
        self.rendered_view, self.shown_view = View(rendered_pose or Pose(), FOV), View(shown_pose or Pose(), FOV)
        choice = parse_warp(spec)
        self.warp, self.canvas = choice.entry(gpu, size, shown_size, choice.settings), Canvas(gpu.gl, shown_size)
        colour, self.depth = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
        colour.write(numbered(size).tobytes(), alignment=1)
        self.rendered = EyeImage(self.rendered_view, colour, self.depth)

    def run(self, depth: np.ndarray) -> np.ndarray:
        """(h, w) index of the drawn pixel that each shown pixel shows, -1 for none."""
        self.depth.write(np.ascontiguousarray(depth, np.float32).tobytes(), alignment=1)
        self.warp.run(PassInputs(self.rendered, self.shown_view), self.canvas)
        self.gpu.gl.memory_barrier()
        return self.winners(self.canvas)

    def winners(self, canvas: Canvas) -> np.ndarray:
        """The same, of any picture made of this one's pixels."""
        out = read(canvas.texture).astype(np.int64)
        return np.where(out[..., 3] > 0, out[..., 1] * self.size[0] + out[..., 0], -1)

    def wanted(self, depth: np.ndarray) -> np.ndarray:
        """The same by sorting, for `forward`; only for maps whose w does not depend on the pixel.
        Equal depths stay equal in float32."""
        forward = WarpMap.between(self.rendered_view, self.size, self.shown_view, self.shown_size)
        assert np.array_equal(forward.H[2], [0, 0, 1])
        y, x = (a.ravel() for a in np.mgrid[: self.size[1], : self.size[0]])
        flat = np.asarray(depth, np.float32).astype(np.float64).ravel()
        pixels, shown_depth, w = forward.apply(np.stack([x, y], axis=-1) + 0.5, flat)
        # Sizes are chosen so that nothing lands near a border between pixels: rounding decides
        # nothing here.
        apart = np.abs(pixels - np.round(pixels))[(flat >= 0) & (w > 0)]
        assert apart.size == 0 or apart.min() > 1e-3
        key_depth = np.where(shown_depth < FAR, 0, np.minimum(shown_depth, 2.0**11 * (1 - 2.0**-24)))
        tie = np.where(key_depth > 0, (y % 4) * 4 + x % 4, 0)
        lands = (flat >= 0) & (w > 0) & (pixels >= 0).all(axis=1) & (pixels < self.shown_size).all(axis=1)
        source = np.flatnonzero(lands)
        slot = np.floor(pixels[source]).astype(int) @ [1, self.shown_size[0]]
        order = np.lexsort((source, tie[source], -key_depth[source], slot))
        first = np.unique(slot[order], return_index=True)
        out = np.full(self.shown_size[0] * self.shown_size[1], -1)
        out[first[0]] = source[order][first[1]]
        return out.reshape(self.shown_size[::-1])

    def check(self, depth: np.ndarray) -> np.ndarray:
        got = self.run(depth)
        assert np.array_equal(got, self.wanted(depth))
        return got


# Rendered and shown sizes; the ratio on each axis is odd or a power of two, so that no pixel centre
# lands on a border.
MINIFIED = [
    ((60, 45), (20, 15)), ((64, 48), (16, 12)), ((64, 64), (8, 8)), ((99, 77), (9, 7)), ((225, 150), (75, 50)),
    ((65, 63), (1, 1)), ((15, 1), (5, 1)),
]  # fmt: skip


@pytest.mark.parametrize(("size", "shown_size"), MINIFIED, ids=str)
def test_a_plane_facing_the_eye_ties_everywhere(gpu, size, shown_size):
    scatter = Scatter(gpu, size, shown_size)
    got = scatter.check(np.full(size[::-1], 0.5))
    assert (got >= 0).all()


@pytest.mark.parametrize(("size", "shown_size"), MINIFIED, ids=str)
@pytest.mark.parametrize("far", [0.0, 2.0**-21, 1e-30])
def test_in_the_sky_the_lowest_index_wins(gpu, size, shown_size, far):
    scatter = Scatter(gpu, size, shown_size)
    got = scatter.check(np.full(size[::-1], far))
    y, x = (np.arange(n) * (m // n) for n, m in ((shown_size[1], size[1]), (shown_size[0], size[0])))
    assert np.array_equal(got, y[:, None] * size[0] + x)


@pytest.mark.parametrize(("size", "shown_size"), MINIFIED, ids=str)
@pytest.mark.parametrize("seed", range(3))
def test_the_nearest_wins_among_few_depths_holes_and_sky(gpu, size, shown_size, seed):
    rng = np.random.default_rng(seed)
    Scatter(gpu, size, shown_size).check(
        rng.choice([-1.0, 0.0, 0.25, 0.5, 1.0], size[::-1], p=[0.3, 0.3, 0.2, 0.1, 0.1])
    )


@pytest.mark.parametrize("seed", range(3))
def test_neighbouring_floats_are_told_apart(gpu, seed):
    """All 24 bits of the significand count, at every power of two from 2^-20 to 2^10."""
    rng = np.random.default_rng(seed)
    base = np.float32(2.0) ** rng.integers(-20, 11, (8, 8)).astype(np.float32)
    base = np.nextafter(base * np.float32(rng.uniform(1, 1.99)), np.float32(4))
    steps = rng.integers(0, 3, (64, 64))
    depth = np.kron(base, np.ones((8, 8), np.float32)).astype(np.float32)
    for k in (1, 2):
        depth = np.where(steps >= k, np.nextafter(depth, np.float32(np.inf)), depth)
    got = Scatter(gpu, (64, 64), (8, 8)).check(depth)
    y, x = np.divmod(got, 64)
    assert (steps[y, x] == steps.reshape(8, 8, 8, 8).max(axis=(1, 3))).all()


def test_runs_do_not_remember_each_other(gpu):
    """Ties, none, other ties, only sky, nothing: each picture as if it were the first."""
    scatter, rng = Scatter(gpu, (64, 64), (8, 8)), np.random.default_rng(0)
    ties, unique = np.full((64, 64), 0.5), rng.permutation(64 * 64).reshape(64, 64) / 1000 + 0.1
    shifted = np.where(np.mgrid[:64, :64][1] % 8 < 5, -1, 0.5)
    for depth in (ties, unique, shifted, np.zeros((64, 64)), np.full((64, 64), -1.0), ties, shifted, ties):
        scatter.check(depth)


@pytest.mark.parametrize("axis", [0, 1])
def test_the_near_border_is_inside_and_the_far_one_is_not(gpu, axis):
    """A step of exactly half a pixel puts centres on borders. 4 pixels per tangent, 0.25 m, inverse
    depth 0.5."""
    depth, step = np.full((8, 8), 0.5), np.eye(3)[axis] * 0.25
    index = np.arange(64).reshape(8, 8)
    backwards = Scatter(gpu, (8, 8), (8, 8), shown_pose=Pose(step)).run(depth)
    assert np.array_equal(backwards, index), "what lands at 0.0 is in pixel 0"
    forwards = Scatter(gpu, (8, 8), (8, 8), shown_pose=Pose(-step)).run(depth)
    wanted = np.full((8, 8), -1)
    if axis == 0:
        wanted[:, 1:] = index[:, :-1]
    else:
        wanted[1:] = index[:-1]
    assert np.array_equal(forwards, wanted), "what lands at 8.0 of 8 is outside, and not at the start of the next row"


def test_a_pixel_that_leaves_at_the_right_hides_nothing_in_the_next_row(gpu):
    """The last column lands at exactly 8.0 of 8, before a sky that stays where it is."""
    depth = np.zeros((8, 8))
    depth[:, 7] = 0.5
    got = Scatter(gpu, (8, 8), (8, 8), shown_pose=Pose((-0.25, 0, 0))).run(depth)
    wanted = np.arange(64).reshape(8, 8)
    wanted[:, 7] = -1
    assert np.array_equal(got, wanted)


def test_a_shown_picture_beyond_the_room_for_keys_is_refused(gpu):
    side = gpu.max_texture_size
    if side * side <= gpu.gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"] // 4:
        pytest.skip(f"this GPU has room for the keys of its largest picture, {side}x{side}")
    with pytest.raises(InputError, match="[48] bytes a pixel"):
        warps.get("forward")(gpu, (16, 16), (side, side))


# --- the order from the epipole -------------------------------------------------------------------


@pytest.mark.parametrize("spec", ["forward_ordered:sheets=rings", "forward_ordered:sheets=rows"])
@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("where", ["inside", "centre", "behind", "infinite", "none", "outside", "corner"])
def test_wherever_the_epipole_lies_the_painted_twin_agrees(gpu, spec, seed, where):
    world = World(gpu, seed, (67, 53), (70, 50))
    rendered, rng = world.rendered_view, np.random.default_rng(seed)
    left, right, down, up = rendered.fov.tangents
    half_pixel = np.array([right - left, up - down]) / np.array(world.size)
    tangent = {
        "inside": (left + rng.uniform() * (right - left), down + rng.uniform() * (up - down)),
        "centre": (left + 20.5 * half_pixel[0], down + 30.5 * half_pixel[1]),
        "behind": (left + rng.uniform() * (right - left), down + rng.uniform() * (up - down)),
        "infinite": tuple(rng.normal(size=2)),
        "none": (0, 0),
        "outside": tuple(rng.normal(scale=20, size=2)),
        "corner": (left, down),
    }[where]
    along = {"behind": 1.0, "infinite": 0.0, "none": 0.0}.get(where, -1.0)
    step = np.array([-along * tangent[0], -along * tangent[1], along]) if along else np.array([*tangent, 0.0])
    step *= 0.05 / max(np.linalg.norm(step), 1)
    turn = Rotation.from_rotvec(np.deg2rad(rng.normal(scale=3, size=3)))
    pose = Pose(
        rendered.pose.position_m + rendered.pose.rotation.apply(step), (rendered.pose.rotation * turn).as_quat()
    )
    world.shown_view = View(pose, rendered.fov)
    got, wanted = world.warp(gpu, spec), world.reference(spec)
    assert np.isfinite(got).all()
    decided = ~wanted.undecided
    assert decided.mean() > 0.9
    assert np.array_equal(got[decided], wanted.colour[decided])
