"""The twins themselves.

Known pictures, brute force, and error bounds that hold and are not empty.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from strategies import METRES, neighbouring_views

from hmdwarp.geometry import Fov, Pose, View, WarpMap
from hmdwarp.headsets import load_headset
from reference import gather, scatter
from reference._rays import pixel_error_bound, project, world_directions
from reference.interpolate import interpolate
from reference.lens import radial
from reference.picture import TwinInputs, near_edge, sample_covered
from reference.raycast import cast_quads, cast_spheres, cast_triangles, nearest

FOV = Fov.from_tangents([-1, 1, -1, 1])
STRAIGHT = View(Pose(), FOV)
SIZES = st.tuples(st.integers(1, 40), st.integers(1, 40))


def full(size: tuple[int, int], value: float = 1.0) -> np.ndarray:
    """(h, w, 4) of one grey, covered."""
    return np.dstack([np.full((size[1], size[0], 3), value), np.ones((size[1], size[0]))])


def random_picture(seed: int, size: tuple[int, int], holes: float = 0.0) -> np.ndarray:
    rng = np.random.default_rng(seed)
    picture = np.dstack([rng.uniform(0, 1, (size[1], size[0], 3)), np.ones((size[1], size[0]))])
    picture[rng.uniform(size=(size[1], size[0])) < holes] = 0
    return picture


# --- rays ---------------------------------------------------------------------------------------


@given(neighbouring_views(METRES), SIZES, SIZES, st.floats(0, 3))
def test_rays_and_the_warp_map_agree(views, size, to_size, inverse_depth):
    """Two routes to the same place: what makes the twins proof for shaders that multiply by H."""
    frm, to = views
    own = np.full(size[::-1], inverse_depth)
    pixels, depth, w = project(world_directions(frm, size), frm.pose.position_m - to.pose.position_m, own, to, to_size)
    centres = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in size)), axis=-1)
    map_pixels, map_depth, map_w = WarpMap.between(frm, size, to, to_size).apply(centres, own)
    ahead = w > 0.05
    # Terms of up to 3 m * 3 / m and tangents below 3, through a turn: 64 units of 20; over w 0.05
    # and 40 / 0.2 pixels per tangent.
    assert np.abs(w - map_w).max() <= 2e-13
    assert np.abs(pixels - map_pixels)[ahead].max(initial=0) <= 1e-7
    assert np.abs(depth - map_depth)[ahead].max(initial=0) <= 1e-9


@settings(max_examples=60)
@given(neighbouring_views(METRES), SIZES, SIZES, st.integers(0, 99))
def test_a_float32_map_stays_within_its_bound(views, size, to_size, seed):
    """What a shader does, in NumPy's float32.

    The error is below the bound, and the bound is no excuse for anything.
    """
    frm, to = views
    own = np.random.default_rng(seed).uniform(0, 2, size[::-1]).astype(np.float32).astype(np.float64)
    warp = WarpMap.between(frm, size, to, to_size)
    centres = np.stack(np.meshgrid(*(np.arange(n) + 0.5 for n in size)), axis=-1)
    exact, _, w = warp.apply(centres, own)
    bound = pixel_error_bound(warp, size, own)
    H, e, p = (a.astype(np.float32) for a in (warp.H, warp.e, centres))
    q = (H[:, 0] * p[..., :1] + H[:, 1] * p[..., 1:]) + H[:, 2] + e * own.astype(np.float32)[..., None]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        got = (q[..., :2] / q[..., 2:]).astype(np.float64)
    sure = np.isfinite(bound) & (w > 0)
    assert (np.abs(got - exact).max(axis=-1) <= bound)[sure].all()
    plain = w > 0.5
    # Pictures of 40 pixels: positions below 1e4 (a view far off its axis), 24 units of them, over
    # w.
    assert bound[plain].max(initial=0) < 0.05


def test_a_bound_beside_the_eye_is_infinite():
    behind = WarpMap.between(STRAIGHT, (4, 4), View(Pose((0, 0, -1)), FOV), (4, 4))
    bound = pixel_error_bound(behind, (4, 4), np.ones((4, 4)))  # all points in the plane of the other eye
    assert np.isinf(bound).all()


# --- looking into a picture ---------------------------------------------------------------------


def test_a_look_between_two_texels_is_their_mean():
    picture = np.dstack([np.array([[0.2, 0.6]])] * 3 + [np.ones((1, 2))])
    looked = sample_covered(picture, np.array([[[1.0, 0.5], [0.5, 0.5], [1.25, 0.2]]]), np.zeros((1, 3)))
    assert looked.colour[0, :, 0] == pytest.approx([0.4, 0.2, 0.5])
    assert (looked.colour[..., 3] == 1).all()


def test_a_hole_does_not_darken_its_neighbour_and_wins_with_more_than_half():
    picture = np.zeros((1, 2, 4))
    picture[0, 0] = (0.5, 0.5, 0.5, 1)
    looked = sample_covered(picture, np.array([[[0.7, 0.5], [0.9, 0.5], [1.1, 0.5]]]), np.zeros((1, 3)))
    assert looked.colour[0, :, 0] == pytest.approx([0.5, 0.5, 0])
    assert looked.colour[0, :, 3].tolist() == [1, 1, 0]
    assert (looked.colour[0, 2] == 0).all()


@pytest.mark.parametrize("place", [(-0.01, 1), (2.0, 1), (1, -0.01), (1, 2.0), (math.nan, 1)])
def test_outside_there_is_nothing(place):
    looked = sample_covered(full((2, 2)), np.array([[place]], float), np.zeros((1, 1)))
    assert (looked.colour == 0).all()


def test_pixels_that_rounding_may_decide_are_marked():
    places = np.array([[[0.5, 1.0], [0.001, 1.0], [1.999, 1.0], [1.0, 0.001], [math.nan, 1.0], [1.0, 1.0]]])
    marked = near_edge(places, (2, 2), np.full((1, 6), 0.01))
    assert marked.tolist() == [[False, True, True, True, False, False]]
    half = np.zeros((1, 2, 4))
    half[0, 0] = 1
    looked = sample_covered(half, np.array([[[1.0, 0.5]]]), np.full((1, 1), 1e-3))
    assert looked.undecided.all(), "coverage one half: either side is right"


@given(st.integers(0, 50), st.floats(0, 0.05))
def test_the_tolerance_covers_a_moved_look(seed, error):
    """Looking `error` beside the place in any direction changes the colour by no more than the
    tolerance says.
    """
    rng = np.random.default_rng(seed)
    picture = random_picture(seed, (9, 9), holes=0.2)
    places = rng.uniform(1, 8, (5, 5, 2))
    looked = sample_covered(picture, places, np.full((5, 5), error), 0.0)
    moved = sample_covered(picture, places + rng.uniform(-1, 1, places.shape) * error, np.zeros((5, 5)), 0.0)
    decided = ~looked.undecided
    assert np.array_equal(moved.colour[..., 3][decided], looked.colour[..., 3][decided])
    difference = np.abs(moved.colour[..., :3] - looked.colour[..., :3]).max(axis=-1)
    assert (difference <= looked.tolerance)[decided].all()


# --- the warps ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "twin",
    [gather.none, gather.shift, gather.similarity, gather.rotation, gather.planar, scatter.forward],
    ids=lambda t: t.__name__,
)
def test_an_unmoved_eye_sees_the_picture_itself(twin):
    picture, depth = random_picture(1, (9, 7)), np.random.default_rng(2).uniform(0, 2, (7, 9))
    got = twin(TwinInputs(picture, depth, STRAIGHT, STRAIGHT, (9, 7)))
    # The ring of the twin of similarity is 1e-4 wide: differences of pixels near 10 over that.
    assert np.abs(got.colour - picture).max() <= 1e-10


def test_known_shifts():
    """10 pixels over 90 degrees, so 5 per tangent.

    0.2 m to the right of a plane at 1 m is one pixel to the left.
    """
    picture, depth = random_picture(3, (10, 10)), np.ones((10, 10))
    right = View(Pose((0.2, 0, 0)), FOV)
    for twin in (gather.planar, scatter.forward):
        got = twin(TwinInputs(picture, depth, STRAIGHT, right, (10, 10))).colour
        assert np.abs(got[:, :9] - picture[:, 1:]).max() <= 1e-9
        assert (got[:, 9] == 0).all()
    for twin in (gather.none, gather.rotation):
        assert np.abs(twin(TwinInputs(picture, depth, STRAIGHT, right, (10, 10))).colour - picture).max() <= 1e-9
    up = View(Pose((0, 0.4, 0)), FOV)
    assert (
        np.abs(scatter.forward(TwinInputs(picture, depth, STRAIGHT, up, (10, 10))).colour[:8] - picture[2:]).max()
        <= 1e-9
    )


def test_a_quarter_roll_turns_the_picture():
    """The head rolls to the left, so the picture rolls to the right.

    What was above is now at the right.
    """
    picture = random_picture(4, (8, 8))
    rolled = View(Pose(orientation_xyzw=(0, 0, math.sqrt(0.5), math.sqrt(0.5))), FOV)
    got = gather.rotation(TwinInputs(picture, np.ones((8, 8)), STRAIGHT, rolled, (8, 8))).colour
    # Bottom row first: the new column x, row y shows what was at row x, from the right by y.
    wanted = picture.transpose(1, 0, 2)[::-1]
    assert np.abs(got - wanted).max() <= 1e-9


def test_shift_keeps_the_picture_upright_and_similarity_rolls_it():
    picture = random_picture(4, (8, 8))
    rolled = View(Pose(orientation_xyzw=(0, 0, math.sqrt(0.5), math.sqrt(0.5))), FOV)
    asked = TwinInputs(picture, np.ones((8, 8)), STRAIGHT, rolled, (8, 8))
    assert np.abs(gather.shift(asked).colour - picture).max() <= 1e-9
    assert np.abs(gather.similarity(asked).colour - gather.rotation(asked).colour).max() <= 1e-7


def test_similarity_scales_about_the_middle():
    """Half way to a wall at 2 m everything is twice as large."""
    picture = random_picture(6, (8, 8))
    nearer = View(Pose((0, 0, -1)), FOV)
    asked = TwinInputs(picture, np.full((8, 8), 0.5), STRAIGHT, nearer, (8, 8))
    got, wanted = (twin(asked).colour for twin in (gather.similarity, gather.planar))
    assert np.abs(got - wanted).max() <= 1e-7
    assert np.abs(gather.shift(asked).colour - picture).max() <= 1e-9


def test_a_small_turn_shifts_by_the_offset_of_the_middle():
    """5 pixels per tangent: a turn by atan 0.2 to the right moves the middle by one pixel."""
    picture, half = random_picture(7, (10, 10)), math.atan(0.2) / 2
    right = View(Pose(orientation_xyzw=(0, -math.sin(half), 0, math.cos(half))), FOV)
    got = gather.shift(TwinInputs(picture, np.ones((10, 10)), STRAIGHT, right, (10, 10))).colour
    assert np.abs(got[:, :9] - picture[:, 1:]).max() <= 1e-9 and (got[:, 9] == 0).all()


def test_none_keeps_the_angle_when_the_fields_of_view_differ():
    wide, narrow = View(Pose(), Fov.from_tangents([-2, 2, -2, 2])), View(Pose((5, 5, 5), (1, 0, 0, 0)), FOV)
    picture = random_picture(5, (8, 8))
    got = gather.none(TwinInputs(picture, np.ones((8, 8)), wide, narrow, (4, 4))).colour
    assert np.abs(got - picture[2:6, 2:6]).max() <= 1e-9


@settings(max_examples=30)
@given(neighbouring_views(METRES), st.integers(0, 999))
def test_forward_is_what_a_loop_over_pixels_finds(views, seed):
    frm, to = views
    size, shown_size = (9, 7), (8, 8)
    rng = np.random.default_rng(seed)
    picture = random_picture(seed, size)
    depth = rng.choice([-1.0, 0.0, 0.3, 1.0, 2.0], (7, 9)) * rng.choice([1, 1.5])
    got = scatter.forward(TwinInputs(picture, depth, frm, to, shown_size))
    warp, best = WarpMap.between(frm, size, to, shown_size), {}
    for index in range(9 * 7):
        y, x = divmod(index, 9)
        if depth[y, x] < 0:
            continue
        (px, py), shown, w = warp.apply((x + 0.5, y + 0.5), depth[y, x])
        if w > 0 and 0 <= px < shown_size[0] and 0 <= py < shown_size[1]:
            slot = (int(py), int(px))
            if slot not in best or shown > best[slot][0]:
                best[slot] = (float(shown), index)
    wanted = np.zeros((8, 8, 4))
    for slot, (_, index) in best.items():
        wanted[slot] = picture[divmod(index, 9)]
    decided = ~got.undecided
    assert np.array_equal(got.colour[decided], wanted[decided])


@settings(max_examples=40)
@given(st.floats(0.1, 2), st.tuples(*[st.floats(-0.2, 0.2)] * 3), st.tuples(*[st.floats(-0.2, 0.2)] * 3))
def test_planar_meets_a_real_plane(r, step, turn):
    """A checked wall at 1/r metres, ray-cast from both eyes.

    The warped rendered picture is the other one, where it was seen.
    """
    rendered, shown = STRAIGHT, View(Pose(step, (*turn, 1)), FOV)
    assume(1 - r * -step[2] > 0.2)
    size = (16, 16)
    wall = np.array([[[0, 0, -1 / r], [50 / r, 0, 0], [0, 50 / r, 0]]])

    def picture(view):
        hits = cast_quads(wall, view.pose.position_m, world_directions(view, size).reshape(-1, 3))
        # A linear colour is reproduced exactly by a bilinear look only from the rendered eye, which
        # faces the wall.
        colour = np.column_stack(
            [hits.uv[:, 0] * 50 * 0.1 + 0.5, hits.uv[:, 1] * 50 * 0.1 + 0.5, np.full(len(hits.uv), 0.5), hits.shape + 1]
        )
        return colour.reshape(16, 16, 4), hits.inverse_depth.reshape(16, 16)

    colour, depth = picture(rendered)
    got = gather.planar(TwinInputs(colour, depth, rendered, shown, size))
    truth, _ = picture(shown)
    inner = (got.colour[..., 3] == 1) & (truth[..., 3] == 1)
    # A look within half a pixel of the border meets the clamped edge, where the picture is not
    # linear.
    place = project(
        world_directions(shown, size), shown.pose.position_m, _depth_from(shown, wall, size), rendered, size
    )[0]
    inner &= ((place > 0.5) & (place < 15.5)).all(axis=-1)
    assert np.abs(got.colour - truth)[inner].max(initial=0) <= 1e-9


def _depth_from(view, wall, size):
    hits = cast_quads(wall, view.pose.position_m, world_directions(view, size).reshape(-1, 3))
    return hits.inverse_depth.reshape(size[1], size[0])


# --- fill and lens ------------------------------------------------------------------------------


def test_interpolate_takes_the_median_of_enough_neighbours():
    picture = np.zeros((3, 3, 4))
    for (y, x), value in {(0, 0): 0.1, (0, 1): 0.9, (2, 2): 0.4}.items():
        picture[y, x] = (value, value / 2, 0, 1)
    got = interpolate(picture, 3)
    assert got[1, 1] == pytest.approx([0.4, 0.2, 0, 1])
    assert (got[1, 0] == 0).all(), "two neighbours are not enough"
    assert np.array_equal(interpolate(picture, 4), picture)
    picture[2, 0] = (0.8, 0.4, 1, 1)
    assert interpolate(picture, 4)[1, 1] == pytest.approx([0.6, 0.3, 0, 1]), "of four the mean of the middle two"


def test_the_lens_twin_shows_the_middle_at_the_axis():
    headset = load_headset("rift-dk1")
    x = np.broadcast_to(np.linspace(-1.0924, 1.0587, 65)[None, :, None], (65, 65, 4))
    got = radial(np.ascontiguousarray(x), headset.eyes[0].fov, headset, 0, (640, 800))
    at = round((0.03744 + 0.00569) / 0.07488 * 640)
    assert abs(got[400, at - 1 : at + 1, 1].mean()) < 0.02, "tangent 0 lies on the axis, 5.69 mm from the middle"


# --- casting rays -------------------------------------------------------------------------------


def test_rays_meet_known_shapes():
    rays = np.array([[0, 0, -1.0], [1, 0, -1], [0, 0.5, -1], [0, 0, 1]])
    quad = cast_quads([[[0, 0, -2], [1, 0, 0], [0, 1, 0]]], np.zeros(3), rays)
    assert quad.inverse_depth.tolist() == [0.5, 0, 0.5, 0]
    assert quad.uv[2] == pytest.approx([0, 1])
    ball = cast_spheres([[0, 0, -3, 1]], np.zeros(3), rays)
    assert ball.inverse_depth == pytest.approx([0.5, 0, 0, 0])
    assert ball.cosine[0] == pytest.approx(1)
    triangle = cast_triangles([[[-1, -1, -4], [3, -1, -4], [-1, 3, -4]]], np.zeros(3), rays)
    assert triangle.inverse_depth == pytest.approx([0.25, 0, 0.25, 0])
    first = nearest(ball, quad, triangle)
    assert first.inverse_depth == pytest.approx([0.5, 0, 0.5, 0])
    assert first.shape.tolist() == [0, -1, 1, -1]
