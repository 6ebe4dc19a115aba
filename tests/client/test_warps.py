"""Each warp by pictures whose result is known: beyond the eye, at edges, with too little."""

from __future__ import annotations

import math

import numpy as np
import pytest
from reference.gather import median_inverse_depth

from hmdwarp.client import build_plan
from hmdwarp.client.warp_kinds import GatherSettings
from hmdwarp.client.warps import warps
from hmdwarp.frames import EyeSizes, frame_bytes
from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.gpu import SCALAR, allocate

from .rendered_pictures import FOV, square_before_a_wall, warped

# --- homographies: behind the eye, through the plane, without a turn ------------------------------


SMALL = (19, 13)


def of_one_depth(
    gpu, name: str, shown: Pose, depth: float, seed: int | None = None, rendered: Pose | None = None
) -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 4) the rendered picture (white, or noise) and the shown one, bottom row first."""
    picture = np.ones((SMALL[1], SMALL[0], 4))
    if seed is not None:
        picture[..., :3] = np.random.default_rng(seed).uniform(0, 1, (SMALL[1], SMALL[0], 3))
    picture = picture.astype(np.float16).astype(np.float64)
    return picture, warped(gpu, name, picture, np.full(SMALL[::-1], depth), shown, rendered)


def test_an_eye_that_has_passed_the_plane_sees_nothing_ahead_and_the_plane_behind(gpu):
    """The plane lies 2 m ahead of the rendered eye; the shown one stands 3 m ahead."""
    _, out = of_one_depth(gpu, "planar", Pose((0, 0, -3)), 0.5)
    assert (out == 0).all()
    turned = Pose((0, 0, -3), (0, 1, 0, 0))
    _, out = of_one_depth(gpu, "planar", turned, 0.5)
    assert (out == 1).all(), "looking back from 1 m behind it, the plane fills the view"


# --- colour sampled by a cubic --------------------------------------------------------------------


SHARPER = [warp.name for warp in warps if issubclass(warp.Settings, GatherSettings)]
SIDE = 48


def turned(degrees: float) -> Pose:
    """A head turned about the axis between up and left."""
    half, part = math.radians(degrees) / 2, math.sqrt(0.5)
    return Pose(orientation_xyzw=(part * math.sin(half), part * math.sin(half), 0, math.cos(half)))


@pytest.mark.parametrize("name", [name for name in SHARPER if name != "backward"])
def test_sharp_samples_neither_ring_nor_leave_the_range(gpu, name):
    """The brightest half float beside black, and holes: no colour but between those around it."""
    picture = np.zeros((SIDE, SIDE, 4))
    picture[..., 3] = 1
    picture[10:20, :, :3] = 65504.0
    picture[:, 20:30, 1] = 65504.0
    picture[30:34, 30:34] = 0
    out = warped(gpu, f"{name}:resample=catmull-rom", picture, np.where(picture[..., 3] > 0, 0.5, -1), turned(1.3))
    assert np.isfinite(out).all()
    assert out.min() == 0 and out.max() <= 65504.0
    assert (out[out[..., 3] == 0] == 0).all()
    # Red is bright in ten rows: half a pixel beside them it is as dark as before.
    assert ((out[..., 0] > 0).any(axis=1).sum()) <= 10 + 2 + 2 * math.ceil(SIDE * math.tan(math.radians(1.3)))


# --- backward: what the rendered picture did not see stays empty ----------------------------------


def backward(gpu, depth: np.ndarray, own: np.ndarray, pose: Pose, depth_error: float = 0.0) -> np.ndarray:
    """What the eye at `pose` sees of something white; own: the client's own depth."""
    return warped(gpu, "backward", np.ones((*depth.shape, 4)), depth, pose, client_depth=own, depth_error=depth_error)


@pytest.mark.parametrize("turn", [(0, 0.01, 0), (0.02, 0, 0), (0.01, -0.02, 0.3), (0, 0, 0)])
@pytest.mark.parametrize("rendered", [1.0, -1.0])
def test_sky_that_was_behind_a_wall_stays_empty_up_to_the_border(gpu, turn, rendered):
    """Beyond the border of the rendered picture there is no depth, and above all not that of the
    sky."""
    size = (13, 11)
    got = backward(gpu, np.full(size[::-1], rendered), np.zeros(size[::-1]), Pose(orientation_xyzw=(*turn, 1)))
    assert (got == 0).all()


def test_without_the_test_the_rendered_depth_is_not_in_the_frame(gpu):
    plan = build_plan((), "backward:test=off", "interpolate", "none", client_geometry=True)
    assert plan.layers == ("rendered.colour",)
    assert plan.draws_client_depth
    sizes = EyeSizes((40, 30), (40, 30), (FOV, FOV))
    with_test = build_plan((), "backward", "interpolate", "none", client_geometry=True)
    weights = [frame_bytes(tried.needs, sizes, tried.layers) for tried in (plan, with_test)]
    assert set(weights[1]) - set(weights[0]) == {"rendered.inverse_depth"}
    assert sum(weights[1].values()) - sum(weights[0].values()) == 2 * 4 * 40 * 30
    # A fill that reads the shown picture's depth gets it from the warp.
    filled = build_plan((), "backward:test=off", "pyramid", "none", client_geometry=True)
    assert filled.layers == plan.layers


def test_without_own_depth_nothing_is_known(gpu):
    got = backward(gpu, np.full((5, 5), 0.5), np.full((5, 5), -1.0), Pose((0.01, 0, 0)))
    assert (got == 0).all()


def test_depth_that_was_coded_coarsely_leaves_no_holes_where_the_frame_says_so(gpu):
    """Half a step of 2^-7 is more than the test allows at 10 m: 0.03 * (0.1 + 0.02) per metre."""
    size, depth, wrong = (13, 11), 0.1, 2.0**-8
    own, coded = (np.full(size[::-1], value) for value in (depth, depth + wrong))
    assert (backward(gpu, coded, own, Pose())[..., 3] == 0).all()
    assert (backward(gpu, coded, own, Pose(), depth_error=wrong)[..., 3] == 1).all()
    behind = np.full(size[::-1], depth + 3 * wrong)
    assert (backward(gpu, behind, own, Pose(), depth_error=wrong)[..., 3] == 0).all()


# --- iterative: mixed colours move with the thing in front ----------------------------------------


def antialiased_thing(left: float, right: float) -> np.ndarray:
    """(60, 60, 4): white from left to right before 0.2; each pixel is the mean of its area."""
    x = np.arange(60)
    share = np.clip(np.minimum(x + 1, right) - np.maximum(x, left), 0, 1)
    return np.tile(np.append(np.repeat(0.2 + 0.8 * share[:, None], 3, axis=1), np.ones((60, 1)), axis=1), (60, 1, 1))


def test_mixed_pixels_move_with_the_thing_in_front(gpu):
    """Its sides lie at 20.4 and 40.3, so pixels 20 and 40 are mixed; the latter's centre is wall.
    Moved by 12 pixels, and the wall by 3: at 43 - 3 = 37 such a pixel of the wall would be seen."""
    colour, depth = antialiased_thing(20.4, 40.3), square_before_a_wall(np.s_[:, 20:40])[1]
    truth = antialiased_thing(20.4 - 12, 40.3 - 12)
    now, before = (
        warped(gpu, spec, colour, depth, Pose((0.4, 0, 0))) for spec in ("iterative", "iterative:fringe=own")
    )
    seen = now[..., 3] == 1
    assert seen[:, 7:29].all()
    assert np.abs(now - truth)[seen].max() <= 2.0**-9
    assert before[0, 28, 3] == 0
    assert np.abs(before[:, 37, 0] - colour[0, 40, 0]).max() <= 2.0**-9  # a ghost on the wall


def test_a_silhouette_moves_smoothly_where_surfaces_part_by_less_than_a_pixel(gpu):
    """Each step moves the thing by 0.03 pixels, so 0.024 of the contrast of 0.8, and a sheet of 0.7
    pixels stretches that by less than 1.5. Without a sheet a mixed pixel of 0.3 leaps at once."""
    colour, depth = antialiased_thing(20.4, 40.3), square_before_a_wall(np.s_[:, 20:40])[1]

    def largest_step(spec: str) -> float:
        moved = [warped(gpu, spec, colour, depth, Pose((x, 0, 0)))[30, 15:45] for x in np.arange(0, 0.03, 0.001)]
        return np.abs(np.diff(moved, axis=0)).max()

    assert largest_step("iterative") < 1.5 * 0.024
    assert largest_step("iterative:sheet=0") > 0.2


# --- splat ----------------------------------------------------------------------------------------


def centres(size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the pixel centres, 0 to 1 over the picture."""
    y, x = np.mgrid[: size[1], : size[0]]
    return (x + 0.5) / size[0], (y + 0.5) / size[1]


def ramps(size: tuple[int, int]) -> np.ndarray:
    """A picture that says where each of its points is."""
    x, y = centres(size)
    return np.stack([x, y, np.zeros_like(x), np.ones_like(x)], axis=-1)


def splatted(gpu, depth, colour, shown: Pose, shown_size=None, spec="splat") -> np.ndarray:
    return warped(gpu, spec, np.asarray(colour), np.asarray(depth), shown, shown_size=shown_size)


def places(size, depth_of_shown: np.ndarray, shown: Pose) -> np.ndarray:
    """(h, w, 2) where in the rendered picture, 0 to 1, each shown pixel's point is, its inverse
    depth in the shown view given."""
    high, wide = depth_of_shown.shape
    y, x = np.mgrid[:high, :wide] + 0.5
    backward = WarpMap.between(View(shown, FOV), (wide, high), View(Pose(), FOV), size)
    return backward.apply(np.stack([x, y], axis=-1), depth_of_shown)[0] / size


@pytest.mark.parametrize("closer", [1.3, 2.0, 3.7, 20.0])
def test_a_plane_that_comes_closer_has_no_cracks_and_is_smooth(gpu, closer):
    """From 2 m to 2 m / closer: the middle of the picture, magnified. Each pixel where it belongs
    to a hundredth of a rendered one."""
    size, moved = (64, 48), 2 - 2 / closer
    shown = Pose((0.013, -0.007, -moved))
    out = splatted(gpu, np.full(size[::-1], 0.5), ramps(size), shown)
    assert (out[..., 3] == 1).all()
    wanted = places(size, np.full(size[::-1], 0.5 * closer), shown)
    # Half floats below 1 are off by 2^-11.
    assert np.abs(out[..., :2] - wanted).max() * 64 < 0.01 + 64 * 2.0**-11


@pytest.mark.parametrize("reach", [1, 4, 16])
def test_one_pixel_covers_no_more_than_its_reach(gpu, reach):
    """A single drawn pixel before an eye that sees it 60 pixels wide. 2 reach of them, and no more
    work than that."""
    out = splatted(gpu, np.full((1, 1), 0.5), np.ones((1, 1, 4)), Pose((0, 0, -1e-3)), (60, 60), f"splat:reach={reach}")
    assert (out[..., 3] == 1).sum() == (2 * reach) ** 2
    assert (out[30 - reach : 30 + reach, 30 - reach : 30 + reach, 3] == 1).all()


# --- mesh -----------------------------------------------------------------------------------------


FLOOR = (64, 48)
TALL = Fov(*np.deg2rad([-45, 45, -40, 40]))


@pytest.mark.parametrize("spec", ["mesh", "mesh_adaptive"])
def test_a_floor_to_the_horizon_stays_whole(gpu, spec):
    """Its last rows are much steeper than any limit. That they go on straight is what keeps them
    together."""
    down, up = TALL.tangents[2:]
    tangent = down + (up - down) * (np.arange(FLOOR[1]) + 0.5) / FLOOR[1]
    floor = np.broadcast_to(np.maximum(-tangent / 1.6, 0)[:, None], FLOOR[::-1])  # 1.6 m below; sky above
    out = warped(gpu, spec, np.ones((*FLOOR[::-1], 4)), floor, Pose((0.15, 0.3, 0)), fov=TALL)
    assert (out[:, 8:-8, 3] == 1).all()


# --- the median depth of planar and similarity ----------------------------------------------------


GRID = 64


def gpu_median(gpu, depth: np.ndarray) -> np.float32:
    """What the shader leaves in its buffer for an (h, w) float32 picture, bottom row first."""
    size = depth.shape[1::-1]
    texture = allocate(gpu.gl, size, SCALAR)
    texture.write(np.ascontiguousarray(depth, np.float32).tobytes(), alignment=1)
    buffer = gpu.gl.buffer(np.full(4, np.nan, np.float32).tobytes())
    program = gpu.shaders.compute("warps/median.comp")
    texture.use(1)
    buffer.bind_to_storage_buffer(0)
    program.uniforms.set(rendered_inverse_depth=1, rendered_size=size)
    program.run(1)
    gpu.gl.memory_barrier()
    out = np.frombuffer(buffer.read(), np.float32)
    assert np.isnan(out[1:]).all(), "it writes one number"
    buffer.release()
    texture.release()
    return out[0]


def random_depth(seed: int, size: tuple[int, int]) -> np.ndarray:
    rng = np.random.default_rng(seed)
    depth = rng.exponential(0.5, (size[1], size[0])).astype(np.float32)
    depth[rng.uniform(size=depth.shape) < 0.1] = 0
    depth[rng.uniform(size=depth.shape) < 0.1] = -1
    return depth


@pytest.mark.parametrize(
    "size", [(1, 1), (3, 5), (67, 53), (129, 2), (2, 129), (1000, 3), (63, 65), (641, 401), (128, 128)]
)
def test_any_size_gives_the_median_of_the_cells(gpu, size):
    depth = random_depth(sum(size), size)
    assert gpu_median(gpu, depth) == median_inverse_depth(depth.astype(np.float64))


def test_neighbouring_floats_are_told_apart(gpu):
    values = np.full(GRID * GRID, np.float32(0.1))
    values[: GRID * GRID // 2 - 1] = np.nextafter(np.float32(0.1), np.float32(0))
    values[-3:] = np.nextafter(np.float32(0.1), np.float32(1))
    assert gpu_median(gpu, values.reshape(GRID, GRID)) == np.float32(0.1)
    values[: GRID * GRID // 2] = np.nextafter(np.float32(0.1), np.float32(0))
    assert gpu_median(gpu, values.reshape(GRID, GRID)) == np.nextafter(np.float32(0.1), np.float32(0))
