"""Reflections: of known mirrors, nearer to the truth than glued on; and from pictures alone."""

from __future__ import annotations

import numpy as np
import pytest
from golden_pictures import assert_golden, sheet
from mirrored import VIEW, mirrored_scene, moved
from reference.picture import HALF_UNIT
from worlds import read

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.client.effects import effects
from hmdwarp.client.effects.mirrors import PLANES, MirroredPass
from hmdwarp.frames import EyeImage, Mirrored, Needs, Others
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import COLOUR, SCALAR, allocate
from hmdwarp.sources.server import Server

LARGE = (160, 144)
SIZE = (160, 128)  # of pictures of a painted wall that mirrors a world behind it
FOV = Fov(-0.7, 0.7, -0.6, 0.6)
STRAIGHT = View(Pose(), FOV)
# As far apart in pixels as eyes and a walking head are in a picture of full size.
OTHERS = tuple(View(Pose(at), FOV) for at in ((0.2, 0.0, 0.0), (0.05, -0.15, 0.0), (-0.1, 0.1, 0.05)))
SHOWN = View(Pose((0.15, 0.06, 0.0)), FOV)
WALL_M, IMAGE_M = 1.5, 4.0  # a mirror on a wall across the view, and the mirrored world behind it
EVERY = ("planar_reflections", "glossy_reflections", "curved_reflections")


def waves(points: np.ndarray, per_m: float, seed: int) -> np.ndarray:
    """(..., 3) light of 0 to 1 that varies along x and y, the same from everywhere."""
    rng = np.random.default_rng(seed)
    total = sum(
        np.sin(points[..., :2] @ (per_m * rng.uniform(-1, 1, 2)) + rng.uniform(0, 6))[..., None]
        * rng.uniform(0.5, 1, 3)
        for _ in range(6)
    )
    return 0.5 + 0.5 * np.tanh(4 * total)  # patches with edges, as pictures have


def picture(view: View, share: float, size: tuple[int, int] = SIZE) -> tuple[np.ndarray, np.ndarray]:
    """(h, w, 4) and inverse depth of a painted wall that mirrors `share` of the image behind it."""
    rays = view.rays(size)
    eye = view.pose.position_m
    on_wall, on_image = (eye + rays * (far + eye[2]) for far in (WALL_M, IMAGE_M))
    light = 0.3 * waves(on_wall, 8.0, 1) + share * waves(on_image, 6.0, 2)
    depth = np.full(rays.shape[:2], 1 / (WALL_M + eye[2]))
    return np.concatenate([light, np.ones((*depth.shape, 1))], axis=-1), depth


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
    frame = server.draw_frame([VIEW], 0, LARGE, needs=plan.needs)
    compensator = Compensator(gpu, plan, None, LARGE, LARGE)
    result = compensator.run(PassInputs(frame.eyes[0], view, **inputs))
    out = read(result.shown.texture), read(result.warped.texture)[..., 3] > 0
    server.recycle(frame)
    compensator.close()
    return out


def mirrors_of(server: Server, view, needs: Needs) -> np.ndarray:
    frame = server.draw_frame([view], 0, LARGE, needs=needs)
    found = read(frame.eyes[0]["reflection"].surface)[..., 0] > 0
    server.recycle(frame)
    return found


def truth_of(server: Server, view) -> np.ndarray:
    eye = server.draw(view, LARGE)
    found = read(eye.colour)
    server.pool(LARGE).release(eye.colour)
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


# --- from pictures alone --------------------------------------------------------------------------


NAME = "reflections_from_pictures"


def image_of(gpu, view: View, colour: np.ndarray, depth: np.ndarray) -> EyeImage:
    size = depth.shape[1::-1]
    textures = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
    textures[0].write(colour.astype(np.float16).tobytes(), alignment=1)
    textures[1].write(depth.astype(np.float32).tobytes(), alignment=1)
    return EyeImage(view, *textures)


def inputs_of(gpu, share: float, others=OTHERS, shown: View = SHOWN, size: tuple[int, int] = SIZE) -> PassInputs:
    rendered, *rest = (image_of(gpu, view, *picture(view, share, size)) for view in (STRAIGHT, *others))
    return PassInputs(rendered, shown, others=tuple(rest))


def made(gpu, size: tuple[int, int] = SIZE) -> MirroredPass:
    return MirroredPass(gpu, frozenset({NAME}), size, size, tools=None)  # type: ignore[arg-type]


def shown_truth(inputs: PassInputs, share: float) -> np.ndarray:
    """The rendered wall with the light that the shown eye sees in it: the pass's ideal result."""
    rays, eye = STRAIGHT.rays(SIZE), inputs.shown.pose.position_m
    surface = rays * WALL_M
    way = surface - eye
    image = eye + way * ((IMAGE_M + eye[2]) / -way[..., 2])[..., None]
    return 0.3 * waves(surface, 8.0, 1) + share * waves(image, 6.0, 2)


def test_a_mirror_shows_what_the_eye_sees_in_it_now(gpu, tmp_path):
    """The image stands at a known depth behind the wall; it is found, and most of it moves."""
    inputs, one = inputs_of(gpu, 0.5), made(gpu)
    out = read(one.run(inputs).rendered.colour)
    truth, glued = shown_truth(inputs, 0.5), picture(STRAIGHT, 0.5)[0]
    inner = np.s_[24:-24, 24:-24]  # what was beside the picture cannot be known
    left, before = (np.abs(each[..., :3] - truth)[inner].mean() for each in (out, glued))
    assert left < 0.5 * before
    # The planes divide the inverse depth of the wall. Windows of 72 pixels reach beyond the border.
    high, wide = one.image_depth.height, one.image_depth.width
    blocks = np.frombuffer(one.image_depth.read(alignment=1), np.float32).reshape(high, wide, 2)[4:-4, 4:-4]
    assert (blocks[..., 1] == 1).all()
    assert np.median(np.abs(blocks[..., 0] - 1 / IMAGE_M)) < 1 / WALL_M / PLANES
    assert_golden("effects/reflections_from_pictures", sheet((out, None), (read(one.light), None)), tmp_path)
    one.close()


def test_a_wall_that_mirrors_nothing_stays_bit_for_bit(gpu):
    inputs, one = inputs_of(gpu, 0.0), made(gpu)
    out = one.run(inputs).rendered.colour
    assert np.array_equal(read(out), read(inputs.rendered.colour))
    assert (read(one.trust) == 0).all()
    one.close()


@pytest.mark.parametrize(
    "asked",
    [
        {"others": ()},
        {"others": (STRAIGHT, STRAIGHT)},
        {"others": (View(Pose((0, 0, 0), (0, 0.05, 0, 1)), FOV),)},
        {"shown": View(Pose((0, 0, 0), (0.05, 0, 0, 1)), FOV)},
    ],
    ids=["no other picture", "all from one place", "turned only", "shown from where it was drawn"],
)
def test_without_parallax_nothing_is_touched(gpu, asked):
    inputs, one = inputs_of(gpu, 0.5, **asked), made(gpu)
    assert one.run(inputs) is inputs
    one.close()


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (37, 61), (65, 33)])
def test_odd_sizes_holes_and_highlights_give_finite_pictures(gpu, size):
    """Holes stay holes, what has no depth stays as it is, and lamps do not overflow."""
    rng, views = np.random.default_rng(3), (STRAIGHT, *OTHERS)
    images = []
    for view in views:
        colour, depth = picture(view, 0.5, size)
        colour[rng.uniform(size=depth.shape) < 0.02, :3] = 60_000
        holes = rng.uniform(size=depth.shape) < 0.1
        colour[holes], depth[holes] = 0, -1
        depth[rng.uniform(size=depth.shape) < 0.05] = 0
        depth[rng.uniform(size=depth.shape) < 0.02] = np.inf
        depth[rng.uniform(size=depth.shape) < 0.02] = np.nan
        images.append(image_of(gpu, view, colour, depth))
    one = made(gpu, size)
    out = read(one.run(PassInputs(images[0], SHOWN, others=tuple(images[1:]))).rendered.colour)
    before, known = read(images[0].colour), np.isfinite(read(images[0].inverse_depth)[..., 0])
    assert np.isfinite(out).all() and (out >= 0).all()
    assert np.array_equal(out[..., 3], before[..., 3])
    assert np.array_equal(out[~known], before[~known])
    one.close()


def test_a_thing_that_has_moved_is_no_mirror(gpu):
    """A square that stands elsewhere in the older pictures: the other eye sees it where it is."""
    images = []
    for view, column in zip((STRAIGHT, *OTHERS), (60, 60, 40, 20), strict=True):
        colour, depth = picture(view, 0.0)
        there = column - round(SIZE[0] / 2 / np.tan(0.7) * view.pose.position_m[0])
        colour[40:80, there : there + 30, :3], depth[40:80, there : there + 30] = (0.9, 0.1, 0.1), 1.0
        images.append(image_of(gpu, view, colour, depth))
    one = made(gpu)
    out = read(one.run(PassInputs(images[0], SHOWN, others=tuple(images[1:]))).rendered.colour)
    assert np.abs(out - read(images[0].colour)).mean() < 1e-3
    one.close()


def test_it_stands_in_for_known_mirrors():
    effect = effects.get(NAME)
    assert effect.by_name_only and effect.needs.others == Others(past=2, spacing_ns=300_000_000, other_eye=True)
    plan = build_plan((NAME, *effect.instead_of), "iterative", "none", "none", client_geometry=False, named=(NAME,))
    assert plan.effects == (NAME,)
    assert all((name, f"{NAME} stands in for it") in plan.left_out for name in effect.instead_of)
    assert "reflection" not in plan.needs
