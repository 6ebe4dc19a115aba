"""The server against rays cast in float64, and what a frame must promise to those who warp it."""

from __future__ import annotations

import attrs
import moderngl
import numpy as np
import pytest
from mirrored import shapes_of
from reference._rays import world_directions
from reference.raycast import Hits, away_from_edges, cast_quads
from scipy.spatial.transform import Rotation
from worlds import pixels

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import Background, Quad, Scene, load_scene
from hmdwarp.sources.server import Server

QUADS = shapes_of("planes", Quad)
SIZE = (97, 61)
FLOAT32_UNIT = 2.0**-24
# A rasteriser may snap corners to 1/256 pixel, half of it each way in each axis (measured on
# llvmpipe: it interpolates unsnapped).
SNAP_PX = 1 / 256
# Interpolation a + b x + c y: three rounded coefficients of a handful of operations each, on
# numbers up to the largest in the picture.
ROUNDING = 16 * FLOAT32_UNIT


def random_view(seed: int, wide: float = 1.0) -> View:
    """An eye near (0, 1.6, 0), turned anywhere within about 45 degrees of -z, with an asymmetric
    field of view."""
    rng = np.random.default_rng(seed)
    turn = Rotation.from_euler("YXZ", rng.uniform((-45, -30, -40), (45, 30, 40)), degrees=True)
    fov = Fov(
        -wide * rng.uniform(0.3, 0.9),
        wide * rng.uniform(0.3, 0.9),
        -wide * rng.uniform(0.2, 0.8),
        wide * rng.uniform(0.3, 0.7),
    )
    return View(Pose(rng.uniform((-0.3, 1.3, -0.3), (0.3, 1.9, 0.3)), turn.as_quat()), fov)


def cast_planes(view: View, size: tuple[int, int]) -> Hits:
    quads = [(q.centre, q.right, q.up) for q in QUADS]
    return cast_quads(quads, view.pose.position_m, world_directions(view, size).reshape(-1, 3))


def depth_tolerance(exact: np.ndarray) -> np.ndarray:
    """SNAP_PX times the slope of inverse depth per pixel, plus float32 rounding of the largest
    value."""
    slope = np.abs(np.gradient(exact, axis=0)) + np.abs(np.gradient(exact, axis=1))
    return SNAP_PX * slope + ROUNDING * exact.max()


@pytest.fixture(scope="module")
def planes(gpu):
    server = Server(gpu, load_scene("planes"))
    yield server
    server.close()


@pytest.mark.parametrize("seed", range(8))
def test_inverse_depth_of_planes_is_that_of_rays(planes, seed):
    view = random_view(seed)
    hits = cast_planes(view, SIZE)
    exact, shape = (a.reshape(SIZE[::-1]) for a in (hits.inverse_depth, hits.shape))
    with_target = planes.draw(view, SIZE)
    drawn = pixels(with_target.inverse_depth)
    planes.pool(SIZE).release(with_target.colour)
    safe = away_from_edges(shape)
    assert safe.mean() > 0.5
    assert (np.abs(drawn - exact) <= depth_tolerance(exact))[safe].all()
    assert (drawn[safe & (shape < 0)] == 0).all()


def test_a_guarded_picture_is_the_one_of_a_larger_view(planes):
    view, size = random_view(1, wide=0.8), (90, 64)
    frame = planes.draw_frame([view], 7, size, guard=1.3)
    (grown,) = frame.eyes
    fov, grown_size = view.fov.guarded(1.3, size)
    assert (frame.drawn_ns, grown.size, grown.view.fov) == (7, grown_size, fov) and min(grown_size) > 64
    alone = planes.draw(attrs.evolve(view, fov=fov), grown_size)
    assert (grown.colour.read(), grown.inverse_depth.read()) == (alone.colour.read(), alone.inverse_depth.read())
    planes.recycle(frame)
    planes.pool(grown_size).release(alone.colour)


def test_a_scene_a_million_metres_away_draws_the_same_picture_to_the_last_bit(serve):
    near, offset = (
        load_scene("planes"),
        np.array([2.0**20, -(2.0**19), 2.0**21]),
    )  # powers of two: adding them rounds nothing here
    view = View(Pose((0.125, 1.625, 0.25), random_view(4).pose.orientation_xyzw), random_view(4).fov)
    far_view = View(Pose(view.pose.position_m + offset, view.pose.orientation_xyzw), view.fov)
    pictures = []
    for scene, eye in ((near, view), (attrs.evolve(near, origin_m=offset), far_view)):
        server = serve(scene)
        drawn = server.draw(eye, SIZE)
        pictures.append((drawn.colour.read(), drawn.inverse_depth.read()))
    assert pictures[0] == pictures[1]


def test_drawing_leaves_culling_depth_test_and_framebuffer_as_they_were(planes):
    gl = planes.gpu.gl
    texture = gl.texture((4, 4), 1, dtype="f4")
    framebuffer = gl.framebuffer([texture], gl.depth_renderbuffer((4, 4)))
    program = gl.program(
        vertex_shader="#version 430\nvoid main() { int i = gl_VertexID; "
        "gl_Position = vec4(i == 2 ? 3 : -1, i == 1 ? 3 : -1, 0.5, 1); }",
        fragment_shader="#version 430\nout float value; void main() { value = 1.0; }",
    )
    framebuffer.use()
    framebuffer.clear(depth=0.0)
    eye_image = planes.draw(random_view(0), (8, 8))
    # Clockwise, and farther than the depth buffer says: with culling or the depth test left on,
    # nothing is drawn.
    gl.vertex_array(program, []).render(moderngl.TRIANGLES, vertices=3)
    assert gl.fbo is framebuffer
    assert (pixels(texture) == 1).all()
    planes.pool((8, 8)).release(eye_image.colour)


FEW = (64, 48)
FRONT, BACK = np.array([0.75, 0.25, 0.5]), np.array([0.125, 0.5, 1.0])
AHEAD = View(Pose(), Fov.from_tangents((-1, 1, -0.75, 0.75)))  # 1/32 of tangent a pixel
SLOPE = 0.3  # tangents that the silhouette moves aside for each it goes up
HALF = 2.0**-11  # relative rounding of a colour in 16 bits


def before_a_wall() -> Scene:
    """A sheet at 1 m left of a slanted silhouette, before a wall at 4 m."""
    corners = [(-3.0, -1.0, -1.0), (-SLOPE, -1.0, -1.0), (SLOPE, 1.0, -1.0), (-3.0, 1.0, -1.0)]
    near, far = (Quad((0, 0, -4), (9, 0, 0), (0, 9, 0), -1, light).mesh("sheet") for light in (FRONT, BACK))
    meshes = (attrs.evolve(near, positions=corners), far)
    return Scene("two", "", meshes, background=Background.uniform((9,) * 3))


def covered_by_the_sheet() -> np.ndarray:
    """The share of each pixel left of the silhouette, bottom row first, from 32x32 points of it."""
    fine = 32
    x = (np.arange(FEW[0] * fine) + 0.5) / (FEW[0] * fine) * 2 - 1
    y = ((np.arange(FEW[1] * fine) + 0.5) / (FEW[1] * fine) * 2 - 1) * 0.75
    left = x[None, :] < SLOPE * y[:, None]
    return left.reshape(FEW[1], fine, FEW[0], fine).mean(axis=(1, 3))


def test_a_silhouette_mixes_colours_by_coverage_and_has_the_depth_of_one_surface(serve):
    server = serve(before_a_wall(), samples=4)
    eye = server.draw(AHEAD, FEW)
    colour, depth = pixels(eye.colour)[..., :3], pixels(eye.inverse_depth)
    share = covered_by_the_sheet()
    mixed = (share > 0) & (share < 1)

    weight = (colour - BACK) @ (FRONT - BACK) / ((FRONT - BACK) ** 2).sum()
    assert np.abs(colour - (BACK + weight[..., None] * (FRONT - BACK))).max() < 2 * HALF
    # Four samples: the mixture is of quarters.
    assert np.abs(weight - np.round(4 * weight) / 4).max() < 8 * HALF
    assert np.abs(weight - share).max() < 0.5  # one of four samples at the very edge, and its area
    assert abs((weight - share)[mixed].mean()) < 0.05
    assert (weight[mixed] > 0.1).sum() > 20 and (weight[mixed] < 0.9).sum() > 20

    assert ((np.abs(depth - 1) < 1e-6) | (np.abs(depth - 0.25) < 1e-6)).all()  # never a mean of 1 and 1/4
    alone = serve(before_a_wall())
    assert np.array_equal(depth, pixels(alone.draw(AHEAD, FEW).inverse_depth))


def test_a_body_has_its_number_at_each_pixel_that_has_its_depth(serve):
    scene, needs = load_scene("workshop"), Needs(ids=True)
    view, found = View(Pose((0, 1.6, 0)), Fov.symmetric(0.8, 0.85)), []
    for samples in (1, 4):
        server = serve(scene, samples=samples)
        (eye,) = server.draw_frame([view], 10**9, (160, 200), needs=needs).eyes
        found.append((pixels(eye.get("ids").numbers), pixels(eye.inverse_depth)))
    (plain, depth), (centre, centre_depth) = found
    assert (plain > 0).any()
    assert np.array_equal(plain, centre) and np.array_equal(depth, centre_depth)
