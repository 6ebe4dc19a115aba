"""Fields of view: what is refused, where pixels lie, and guard bands that keep the pixel grid."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import FOVS, SIZES

from hmdwarp.base import InputError
from hmdwarp.geometry import Fov, GuardBand, Pose, View, guarded_eyes

UNIT = 2.0**-53
SIDES = ("left", "right", "down", "up")
LIMIT = math.radians(89.5)


def test_views_guards_and_cameras_that_cannot_be_are_refused():
    nan, inf, fine = math.nan, math.inf, {"left": -0.5, "right": 0.5, "down": -0.5, "up": 0.5}
    for side in SIDES:
        for bad in (nan, inf, -inf, LIMIT + 1e-6, -LIMIT - 1e-6, 2.0):
            with pytest.raises(InputError, match="no field of view"):
                Fov(**{**fine, side: bad})
    for angles in ((0.5, -0.5, -0.5, 0.5), (0.1, 0.1, -1, 1), (-0.5, 0.5, 0.3, 0.3), (-0.5, 0.5, 0.5, -0.5)):
        with pytest.raises(InputError, match="left < right, down < up"):
            Fov(*angles)
    for factor in (0.999, 0, -1, nan, inf):
        with pytest.raises(InputError, match="guard"):
            Fov(**fine).guarded(factor, (10, 10))
    with pytest.raises(InputError, match="no field of view"):
        Fov(-1.2, 1.2, -1.2, 1.2).guarded(60, (10, 10))
    with pytest.raises(InputError, match="rendered size 1600x700 is smaller than the shown picture's 1280x800"):
        Fov(**fine).guarded(GuardBand(size=(1600, 700)), (1280, 800))
    for camera in ((0, 500, 1, 1, 9, 9), (500, -1, 1, 1, 9, 9), (500, 500, nan, 1, 9, 9), (500, 500, 1, 1, 0, 9)):
        with pytest.raises(InputError, match="no camera: fx"):
            Fov.from_intrinsics(*camera)
    with pytest.raises(InputError, match="no field of view"):
        Fov.from_intrinsics(1, 1, 320, 240, 640, 480)


@given(FOVS)
def test_tangents_and_back(fov):
    again = Fov.from_tangents(fov.tangents)
    # d(atan)/dt <= 1, tan and atan are good to 2 units of tangents below 2.2.
    assert max(abs(getattr(again, s) - getattr(fov, s)) for s in SIDES) <= 16 * UNIT


@given(FOVS, st.tuples(st.integers(1, 60), st.integers(1, 60)))
def test_rays_go_through_the_pixel_centres(fov, size):
    rays = View(Pose(), fov).rays(size)
    assert rays.shape == (size[1], size[0], 3)
    assert (rays[..., 2] == -1).all()
    on_plane = np.concatenate([rays[..., :2], np.ones((*rays.shape[:2], 1))], axis=-1)
    pixels = on_plane @ fov.pixel_from_tangent(size).T
    y, x = np.mgrid[: size[1], : size[0]]
    # Bottom row first, column by column; positions below 1e3 pixels from tangent 0.
    assert np.abs(pixels[..., 0] - (x + 0.5)).max() <= 16 * UNIT * 1e3
    assert np.abs(pixels[..., 1] - (y + 0.5)).max() <= 16 * UNIT * 1e3


def test_a_known_view():
    # 90 degrees over 4 pixels: tangents -1..1, pixel centres at -0.75, -0.25, 0.25, 0.75; the first
    # row is the bottom one.
    rays = View(Pose(), Fov.symmetric(math.pi / 2, math.pi / 2)).rays((4, 2))
    assert np.abs(rays[0, :, 0] - [-0.75, -0.25, 0.25, 0.75]).max() <= 4 * UNIT
    assert np.abs(rays[:, 0, 1] - [-0.5, 0.5]).max() <= 4 * UNIT
    # TUM's first Kinect: 640x480, its principal point given for whole-numbered centres.
    edges = [-(318.6 + 0.5) / 517.3, (639.5 - 318.6) / 517.3, -(479.5 - 255.3) / 516.5, (255.3 + 0.5) / 516.5]
    assert Fov.from_intrinsics(517.3, 516.5, 318.6, 255.3, 640, 480).tangents == pytest.approx(edges)


@given(FOVS, SIZES)
def test_pixels_per_degree_is_what_a_small_turn_moves(fov, size):
    left, right, down, up = fov.tangents
    per_px, step = fov.pixel_from_tangent(size), math.radians(1e-4)
    x, y = math.atan(min(max(0, left), right)), math.atan(min(max(0, down), up))
    moved = [
        per_px[0, 0] * (math.tan(x + step) - math.tan(x - step)),
        per_px[1, 1] * (math.tan(y + step) - math.tan(y - step)),
    ]
    # A central difference over 2e-4 degrees: the cubic term is below 1e-9, cancellation below 1e-9.
    assert fov.pixels_per_degree(size) == pytest.approx(np.mean(moved) / 2e-4, rel=1e-8)


# --- guard bands --------------------------------------------------------------------------------

FACTORS = st.one_of(st.sampled_from([1.0, 1 + 1e-12, 1.1, 1.25, 1.5, 2.0]), st.floats(1, 2))
GUARDS = st.one_of(FACTORS, st.tuples(FACTORS, FACTORS))
# Up to 50 degrees: twice the tangent of 65 would be fine, but thrice is not tested here.
GUARDABLE = st.builds(lambda a, b, c, d: Fov(-a, b, -c, d), *[st.floats(0.1, math.radians(50))] * 4)


def pads(fov: Fov, size, grown: Fov) -> np.ndarray:
    """Pixels added on each side, from the tangents alone."""
    per = np.repeat([size[0] / (fov.tangents[1] - fov.tangents[0]), size[1] / (fov.tangents[3] - fov.tangents[2])], 2)
    return (grown.tangents - fov.tangents) * per * (-1, 1, -1, 1)


@given(GUARDABLE, SIZES, GUARDS)
def test_a_guard_adds_whole_pixels_and_keeps_the_grid(fov, size, factor):
    grown, grown_size = fov.guarded(factor, size)
    added = pads(fov, size, grown)
    # tan(atan(t)) is good to 8 units of tangents below 2.4, times up to 4096 / 0.2 pixels per
    # tangent, on both edges.
    assert np.abs(added - np.round(added)).max() <= 4e-11
    added = np.round(added)
    assert grown_size == (size[0] + added[0] + added[1], size[1] + added[2] + added[3])
    assert all(isinstance(n, int) for n in grown_size)


@given(GUARDABLE, SIZES, GUARDS)
def test_a_guard_is_at_least_the_factor_and_less_than_a_pixel_more(fov, size, factor):
    grown, _ = fov.guarded(factor, size)
    per = np.repeat([size[0] / (fov.tangents[1] - fov.tangents[0]), size[1] / (fov.tangents[3] - fov.tangents[2])], 2)
    factors = np.repeat(np.broadcast_to(factor, 2), 2)
    over = (np.abs(grown.tangents) - np.abs(fov.tangents) * factors) * per
    # 1e-9 pixels: what guarded() itself gives away so that rounding adds no pixel.
    assert over.min() >= -1.1e-9
    assert over.max() < 1 + 1e-9


def test_a_view_beside_its_axis_grows_on_both_sides():
    # Both edges right of the axis: the pad is the edge's distance from the axis on either side.
    grown, size = Fov.from_tangents([0.5, 1.5, -1, 1]).guarded(1.1, (100, 100))
    assert grown.tangents[:2] == pytest.approx([0.45, 1.65], abs=1e-12)
    assert size == (120, 110)


MORE = st.integers(0, 500)


@given(GUARDABLE, GUARDABLE, SIZES, MORE, MORE)
def test_pixels_are_drawn_as_said_and_shared_out_by_the_tangents(left, right, size, wider, higher):
    wanted = (size[0] + wider, size[1] + higher)
    fovs, common = guarded_eyes([View(Pose(), fov) for fov in (left, right)], GuardBand(size=wanted), size)
    assert common == wanted
    for fov, grown in zip((left, right), fovs, strict=True):
        added = pads(fov, size, grown)
        # tan(atan(t)) as above; the view may reach nearly 90 degrees, where 1 + tan^2 is as large.
        steepest = 1 + np.abs(grown.tangents).max() ** 2
        assert np.abs(added - np.round(added)).max() <= 4e-11 * steepest
        for first, more in ((0, wider), (2, higher)):
            sides = np.abs(fov.tangents[first : first + 2])
            assert abs(round(added[first]) - more * sides[0] / sides.sum()) <= 0.5 + 1e-9


def test_the_thesis_sizes():
    """1600x900 and 1920x1080 for 1280x800."""
    square = Fov.symmetric(math.pi / 2, math.pi / 2)
    for guard, size, pixels in (((1.25, 1.125), (1600, 900), 1.40625), ((1.5, 1.35), (1920, 1080), 2.025)):
        grown, found = square.guarded(guard, (1280, 800))
        assert found == size and found[0] * found[1] / (1280 * 800) == pixels
        assert grown.tangents == pytest.approx([-guard[0], guard[0], -guard[1], guard[1]])
        assert square.guarded(GuardBand(size=size), (1280, 800)) == (grown, found)
        assert GuardBand(size=size).factors((1280, 800)) == GuardBand(*guard)


def test_a_guard_band_that_is_no_enlargement_is_refused():
    with pytest.raises(InputError, match=r"guard 1\.5x0\.9 is no enlargement"):
        GuardBand(1.5, 0.9)


@given(GUARDABLE, GUARDABLE, SIZES, GUARDS)
def test_eyes_that_differ_get_one_size(left, right, size, factor):
    views = [View(Pose(), fov) for fov in (left, right)]
    fovs, common = guarded_eyes(views, factor, size)
    alone = [fov.guarded(factor, size) for fov in (left, right)]
    assert common == tuple(max(each[1][axis] for each in alone) for axis in range(2))
    for fov, grown, (own, own_size) in zip((left, right), fovs, alone, strict=True):
        # As many pixels as the common size says, of the same grid; more at the right and top.
        assert np.abs(np.round(pads(fov, size, grown)) - pads(fov, size, grown)).max() <= 4e-11
        assert tuple(np.round(pads(fov, size, grown)).reshape(2, 2).sum(axis=1) + size) == common
        assert (np.abs(grown.tangents) - np.abs(own.tangents)).min() >= -16 * UNIT
        assert grown == own or own_size != common
        np.testing.assert_allclose(grown.tangents[::2], own.tangents[::2], rtol=1e-9)


@given(FOVS, SIZES, st.sampled_from([0.0, 0.5]), st.integers(0, 10**6))
def test_a_camera_projects_each_pixel_where_the_view_has_its_ray(fov, size, centre, pick):
    """Through the pinhole equation x = fx X / Z + cx, of a camera that looks along +z, y down."""
    fx, fy, cx, cy = fov.intrinsics(size, centre=centre)
    column, row = pick % size[0], pick // size[0] % size[1]
    x, y, z = View(Pose(), fov).rays(size)[size[1] - 1 - row, column] * (1, -1, -1)
    # A pixel's coordinate, up to the tangent's share of a very narrow view's focal length.
    assert fx * x / z + cx == pytest.approx(column + centre, abs=1e-6 + 1e-12 * fx)
    assert fy * y / z + cy == pytest.approx(row + centre, abs=1e-6 + 1e-12 * fy)


@pytest.mark.parametrize("seed", range(20))
def test_a_projection_matrix_gives_the_edges_that_it_puts_at_one(seed):
    """Of random frusta as OpenGL, WebXR, Unity, Direct3D, Vulkan and reversed depth have them."""
    rng = np.random.default_rng(seed)
    left, right, down, up = tangents = rng.uniform(0.2, 1.5, 4) * (-1, 1, -1, 1)
    near, far = 0.1, 50.0
    matrix = np.zeros((4, 4))
    # glFrustum's, as its manual page has it.
    matrix[0, [0, 2]] = 2 / (right - left), (right + left) / (right - left)
    matrix[1, [1, 2]] = 2 / (up - down), (up + down) / (up - down)
    matrix[2, 2:], matrix[3, 2] = (-(far + near) / (far - near), -2 * far * near / (far - near)), -1
    reverse = matrix.copy()
    reverse[2] = 0, 0, 0, near
    for one in (matrix, matrix @ np.diag([1, 1, -1, 1]), np.diag([1, -1, 1, 1]) @ matrix, reverse):
        for form in (one, one.T, one.ravel(), one.T.ravel().tolist()):
            assert Fov.from_projection(form).tangents == pytest.approx(tangents, rel=1e-12)
    for wrong in (np.eye(4), np.zeros(5), matrix * np.nan, np.diag([1, 1, 0, 1]) @ matrix @ np.diag([0, 1, 1, 1])):
        with pytest.raises(InputError, match="perspective along z"):
            Fov.from_projection(wrong)
