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

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import Quad, load_scene
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


def test_the_guarded_picture_contains_the_unguarded_one(planes):
    view, size = random_view(1, wide=0.8), (90, 64)
    plain = planes.draw(view, size)
    frame = planes.draw_frame([view], 7, size, guard=1.3)
    grown = frame.eyes[0]
    fov, grown_size = view.fov.guarded(1.3, size)
    assert (frame.drawn_ns, grown.size, grown.view.fov) == (7, grown_size, fov)
    left = round((view.fov.tangents[0] - fov.tangents[0]) * size[0] / np.ptp(view.fov.tangents[:2]))
    down = round((view.fov.tangents[2] - fov.tangents[2]) * size[1] / np.ptp(view.fov.tangents[2:]))
    assert left > 0
    assert down > 0
    inside = np.s_[down : down + size[1], left : left + size[0]]
    hits = cast_planes(view, size)
    exact, shape = (a.reshape(size[::-1]) for a in (hits.inverse_depth, hits.shape))
    safe = away_from_edges(shape)
    # Both projections round differently, each within the bound of the rays.
    difference = np.abs(pixels(grown.inverse_depth)[inside] - pixels(plain.inverse_depth))
    assert (difference <= 2 * depth_tolerance(exact))[safe].all()
    a, b = pixels(grown.colour)[inside], pixels(plain.colour)
    # A colour may move by 2 SNAP_PX of a pixel: that much of the swing to the neighbours, plus two
    # half-float roundings.
    swing = sum(np.abs(np.diff(b, axis=axis, prepend=np.nan)) for axis in (0, 1)) + sum(
        np.abs(np.diff(b, axis=axis, append=np.nan)) for axis in (0, 1)
    )
    assert (np.abs(a - b) <= 4 * SNAP_PX * swing + 2**-9)[safe].all()
    planes.recycle(frame)
    planes.pool(size).release(plain.colour)


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
