"""What mirrors show, against rays mirrored in the world, and how it gets into the picture."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from mirrored import BACK, BALLS, CHROME, FLOOR, PLAIN_SHAPES, VIEW, WALL, mirrored_scene, moved
from reference._rays import world_directions
from reference.mirrors import image_behind_ball
from reference.raycast import Hits, cast_quads, cast_spheres
from worlds import read

from hmdwarp.errors import UnknownNameError
from hmdwarp.frames import Mirrored, Needs
from hmdwarp.frames.layers import layers
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server
from hmdwarp.sources.server.parts import parts

SIZE = (97, 83)
EVERY = Needs(reflection=Mirrored.PLANE | Mirrored.CURVED)


@pytest.fixture(scope="module")
def server(gpu):
    made = Server(gpu, mirrored_scene())
    yield made
    made.close()


def layered(server: Server, view=VIEW, needs: Needs = EVERY):
    return server.draw_frame([view], 0, SIZE, needs=needs).eyes[0]


def quad_of(quad) -> tuple:
    return quad.centre, quad.right, quad.up


def plain_things(eye: np.ndarray, rays: np.ndarray) -> np.ndarray:
    """1 / way in units of each ray's length (0: none), of all that is no mirror."""
    balls = cast_spheres([(*ball.centre, ball.radius) for ball in BALLS], eye, rays)
    return np.maximum(balls.inverse_depth, cast_quads([quad_of(BACK)], eye, rays).inverse_depth)


def hits_of(quad, view, rays) -> Hits:
    return cast_quads([quad_of(quad)], view.pose.position_m, rays)


@pytest.mark.parametrize("view", [VIEW, moved((0.2, -0.1, 0.3), 0.15)], ids=["ahead", "turned"])
@pytest.mark.parametrize("quad", [FLOOR, WALL], ids=["floor", "wall"])
def test_the_depth_of_what_a_plane_mirror_shows_is_that_of_the_whole_path(server, quad, view):
    eye = layered(server, view)
    found = read(eye["reflection"].seen.inverse_depth)[..., 0].ravel()
    rays = world_directions(view, SIZE).reshape(-1, 3)
    met = hits_of(quad, view, rays).inverse_depth
    others = [hits_of(other, view, rays).inverse_depth for other in (FLOOR, WALL) if other is not quad]
    chrome = cast_spheres([(*CHROME.centre, CHROME.radius)], view.pose.position_m, rays).inverse_depth
    chosen = np.flatnonzero((met > 0) & (met > np.max(others, axis=0)) & (chrome == 0))
    normal = quad.normal
    expected = []
    for k in chosen:
        place = view.pose.position_m + rays[k] / met[k]
        mirrored = rays[k] - 2 * (rays[k] @ normal) * normal
        beyond = plain_things(place, mirrored[None])[0]
        chrome_there = cast_spheres([(*CHROME.centre, CHROME.radius)], place, mirrored[None]).inverse_depth[0]
        other_mirror = cast_quads(
            [quad_of(other) for other in (FLOOR, WALL) if other is not quad], place, mirrored[None]
        ).inverse_depth[0]
        beyond = max(beyond, chrome_there, other_mirror)
        expected.append(1 / (1 / met[k] + 1 / beyond) if beyond else 0.0)
    expected, chosen_found = np.array(expected), found[chosen]
    # Flat cells lie inside the balls by up to 1.5 mm; silhouettes are of one pixel; and the backs
    # of things are not drawn.
    close = np.abs(chosen_found - expected) <= 0.004 * expected + 1e-5
    assert len(chosen) > 200
    assert close.mean() > 0.95


def test_a_mirror_is_drawn_behind_what_stands_before_it_and_the_surface_is_not(server):
    eye = layered(server)
    rays = world_directions(VIEW, SIZE).reshape(-1, 3)
    ball = cast_spheres([(*BALLS[0].centre, BALLS[0].radius)], VIEW.pose.position_m, rays)
    wall = hits_of(WALL, VIEW, rays)
    hidden = ((ball.inverse_depth > 0) & (ball.cosine > 0.3) & (wall.inverse_depth > 0)).reshape(SIZE[::-1])
    assert hidden.sum() > 20
    assert (read(eye["reflection"].seen.colour)[hidden, 3] == 1).all()
    assert (read(eye["reflection"].surface)[hidden] == (0, 0, 0, 1)).all()


def test_the_surface_tells_reflectivity_where_the_picture_shows_a_mirror(server):
    eye = layered(server)
    surface = read(eye["reflection"].surface)
    rays = world_directions(VIEW, SIZE).reshape(-1, 3)
    everything = [*(quad_of(q) for q in (FLOOR, WALL))]
    near = cast_spheres([(*b.centre, b.radius) for b in (*BALLS, CHROME)], VIEW.pose.position_m, rays).inverse_depth
    met = cast_quads(everything, VIEW.pose.position_m, rays)
    for index, reflectivity in ((0, 0.3), (1, 0.9)):
        here = ((met.shape == index) & (met.inverse_depth > near)).reshape(SIZE[::-1])
        # one pixel at each silhouette may go the other way
        assert (np.abs(surface[here, 0] - reflectivity) < 1e-3).mean() > 0.97
    assert (surface[..., 3] == 1).all()
    assert (read(eye.inverse_depth)[..., 0] == read(server.draw(VIEW, SIZE).inverse_depth)[..., 0]).all()


def test_the_chrome_ball_shows_things_at_the_depth_of_the_mirror_formula(server):
    eye = layered(server)
    found = read(eye["reflection"].seen.inverse_depth)[..., 0].ravel()
    rays = world_directions(VIEW, SIZE).reshape(-1, 3)
    met = cast_spheres([(*CHROME.centre, CHROME.radius)], VIEW.pose.position_m, rays)
    chosen = np.flatnonzero((met.inverse_depth > 0) & (met.cosine > 0.35))
    wrong = 0
    for k in chosen:
        place = VIEW.pose.position_m + rays[k] / met.inverse_depth[k]
        length = np.linalg.norm(rays[k])
        normal = (place - CHROME.centre) / CHROME.radius
        mirrored = rays[k] / length - 2 * (rays[k] / length @ normal) * normal
        way = max(
            plain_things(place, mirrored[None])[0],
            *(cast_quads([quad_of(q)], place, mirrored[None]).inverse_depth[0] for q in (FLOOR, WALL)),
        )
        behind = image_behind_ball(1 / way if way else np.inf, CHROME.radius, met.cosine[k])
        expected = 1 / (1 / met.inverse_depth[k] + behind / length)
        # The ball's triangles are flat (normals are not: 1 mm in 2 m); what is looked up in the
        # cube is within a texel of an edge.
        wrong += abs(found[k] - expected) > 4e-3 * expected
    assert len(chosen) > 150
    assert wrong < 0.06 * len(chosen)


@pytest.mark.parametrize(
    "needs",
    [Needs(), Needs(reflection=Mirrored.PLANE), Needs(reflection=Mirrored.CURVED), EVERY],
    ids=["-", "plane", "ball", "both"],
)
def test_mirrors_needed_as_a_layer_alone_are_left_out_of_the_picture(server, needs):
    eye, whole = layered(server, needs=needs), read(server.draw(VIEW, SIZE).colour)
    changed = np.abs(read(eye.colour) - whole).max(axis=-1) > 0
    surface = read(eye["reflection"].surface)[..., 0] if "reflection" in eye else np.zeros(SIZE[::-1])
    # An uneven floor is looked into beside the pixel, which beside the ball may hold the ball, if
    # that is in the same layers.
    assert (changed & (surface == 0)).mean() <= (0.01 if needs == Needs(reflection=Mirrored.CURVED) else 0)
    assert ("reflection" in eye) == ("reflection" in needs)
    if "reflection" in eye:
        assert changed[surface > 0].mean() > 0.9
        assert sum(mirror.is_curved for mirror in eye["reflection"].mirrors) == (Mirrored.CURVED in needs["reflection"])


@pytest.mark.parametrize(
    "view",
    [
        VIEW,
        moved((0.2, -0.1, 0.3), 0.15),
        moved((0, 0.3, -1.2), 0.4),
        moved((0, 0.5, -1), 2.6),
        moved((-0.7, -0.3, -2.4)),
    ],
    ids=["ahead", "turned", "near the wall", "turned away", "beside the ball"],
)
@pytest.mark.parametrize("kinds", [Mirrored.PLANE, Mirrored.CURVED, Mirrored.PLANE | Mirrored.CURVED])
def test_the_layer_is_empty_beyond_its_bounds_and_not_sent(server, view, kinds):
    layer = layered(server, view, Needs(reflection=kinds))["reflection"]
    low_x, low_y, high_x, high_y = layer.bounds
    beyond = np.ones(SIZE[::-1], bool)
    beyond[low_y:high_y, low_x:high_x] = False
    colour, inverse_depth, surface = (read(texture) for texture in (*layer.seen.textures(), layer.surface))
    assert (colour[beyond] == 0).all() and (inverse_depth[beyond] == -1).all()
    assert (surface[beyond] == (0, 0, 0, 1)).all()
    assert layers.get("reflection").sent_bytes(layer) == 20 * (~beyond).sum()


def test_bounds_are_no_larger_than_what_mirrors(server):
    """A ball's are those of the cube around it: here a third wider and higher at most."""
    layer = layered(server, needs=Needs(reflection=Mirrored.CURVED))["reflection"]
    rows, columns = np.nonzero(read(layer.surface)[..., 0])
    low_x, low_y, high_x, high_y = layer.bounds
    assert high_x - low_x <= 4 / 3 * (np.ptp(columns) + 1) + 2
    assert high_y - low_y <= 4 / 3 * (np.ptp(rows) + 1) + 2


def test_targets_come_back_with_the_frame(server):
    server.recycle(server.draw_frame([VIEW], 0, SIZE, needs=EVERY))
    made = sum(pool.made for pool in server._pools.values())
    for _ in range(3):
        server.recycle(server.draw_frame([VIEW], 0, SIZE, needs=EVERY))
    assert sum(pool.made for pool in server._pools.values()) == made


def test_a_scene_without_mirrors_compiles_and_holds_nothing_of_them(gpu):
    server = Server(gpu, load_scene("planes"))
    server.draw(VIEW, SIZE)
    assert not parts.get("reflections").in_scene(server.scene)
    assert "reflections" not in {name for _, name in server._parts}
    server.close()


def test_reflection_layers_are_empty_where_nothing_mirrors(gpu):
    server = Server(gpu, load_scene("planes"))
    eye = layered(server)
    assert (read(eye["reflection"].seen.colour) == 0).all()
    assert (read(eye["reflection"].seen.inverse_depth) == -1).all()
    assert (read(eye["reflection"].surface) == (0, 0, 0, 1)).all()
    assert np.array_equal(read(eye.colour), read(server.draw(VIEW, SIZE).colour))
    server.close()


def test_no_mirror_shows_what_stands_behind_it(gpu):
    """A ball behind the wall mirror, which the mirrored eye would see first, is not in it."""
    scene = mirrored_scene(curved=False)
    behind = attrs.evolve(scene.meshes[0], positions=scene.meshes[0].positions + np.float32([0.2, 0.6, -2.6]))
    more = attrs.evolve(scene, meshes=(*scene.meshes, behind))
    pictures = []
    for each in (scene, more):
        server = Server(gpu, each)
        eye = layered(server, needs=Needs(reflection=Mirrored.PLANE))
        wall = np.abs(read(eye["reflection"].surface)[..., 0] - 0.9) < 1e-2
        pictures.append(read(eye["reflection"].seen.colour)[wall])
        server.close()
    assert len(pictures[0]) > 100
    assert np.array_equal(*pictures)


def test_a_marched_mirror_shows_what_the_picture_shows_and_nothing_else(gpu, server):
    marched = Server(gpu, mirrored_scene(), mirrors="screen")
    exact, found = layered(server)["reflection"], layered(marched)["reflection"]
    depth, marched_depth = (read(each.seen.inverse_depth)[..., 0] for each in (exact, found))
    floor = np.abs(read(exact.surface)[..., 0] - 0.3) < 1e-2
    hit = floor & (marched_depth >= 0) & (depth >= 0)
    assert 0.2 < hit.sum() / floor.sum() < 1
    # The late picture's own pixels and the thickness allowed limit it; silhouettes go either way.
    assert (np.abs(marched_depth - depth)[hit] <= 0.03 * depth[hit] + 1e-3).mean() > 0.85
    missed = marched_depth < 0
    assert (read(found.seen.colour)[missed & floor] == 0).all()
    assert np.array_equal(read(marched.draw(VIEW, SIZE).colour), read(server.draw(VIEW, SIZE).colour)), (
        "the truth is never marched"
    )
    marched.close()


def test_an_unknown_kind_of_mirrors_is_refused(gpu):
    with pytest.raises(UnknownNameError, match="kind of mirrors 'scren'"):
        Server(gpu, mirrored_scene(), mirrors="scren")


def test_plain_shapes_are_all_in_the_scene():
    assert len(mirrored_scene().meshes) == len(PLAIN_SHAPES) + 3
