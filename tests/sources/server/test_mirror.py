"""What mirrors show, against rays mirrored in the world, and how it gets into the picture."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from mirrored import BACK, BALLS, CHROME, FLOOR, VIEW, WALL, mirrored_scene, moved
from reference._rays import world_directions
from reference.mirrors import image_behind_ball
from reference.raycast import Hits, cast_quads, cast_spheres
from worlds import read

from hmdwarp.frames import Mirrored, Needs
from hmdwarp.frames.layers import layers
from hmdwarp.scenes import Quad
from hmdwarp.sources.server import Server

SIZE = (97, 83)
EVERY = Needs(reflection=Mirrored.PLANE | Mirrored.CURVED)


@pytest.fixture(scope="module")
def server(gpu):
    made = Server(gpu, mirrored_scene())
    yield made
    made.close()


def layered(server: Server, view=VIEW, needs: Needs = EVERY):
    return server.draw_frame([view], 0, SIZE, needs=needs).eyes[0]


def first(things, place: np.ndarray, rays: np.ndarray) -> Hits:
    """What rays meet first of some quads or balls."""
    if isinstance(things[0], Quad):
        return cast_quads([(quad.centre, quad.right, quad.up) for quad in things], place, rays)
    return cast_spheres([(*ball.centre, ball.radius) for ball in things], place, rays)


def way_on(mirror, place: np.ndarray, ray: np.ndarray) -> float:
    """1 / way in units of the ray's length to the first thing but this mirror (0: none)."""
    quads, balls = (
        [thing for thing in kind if thing is not mirror] for kind in ((BACK, FLOOR, WALL), (*BALLS, CHROME))
    )
    return max(first(things, place, ray[None]).inverse_depth[0] for things in (quads, balls))


@pytest.mark.parametrize("view", [VIEW, moved((0.2, -0.1, 0.3), 0.15)], ids=["ahead", "turned"])
@pytest.mark.parametrize("mirror", [FLOOR, WALL, CHROME], ids=["floor", "wall", "ball"])
def test_the_depth_of_what_a_mirror_shows_is_that_of_the_whole_path(server, mirror, view):
    """In a ball by the mirror formula. Its mirror shows what is behind things before it as well.
    Flat cells lie inside balls by up to 1.5 mm; what is looked up in the ball's cube is within a
    texel of an edge; silhouettes are of one pixel; and the backs of things are not drawn."""
    found = read(layered(server, view)["reflection"].seen.inverse_depth)[..., 0].ravel()
    eye, rays = view.pose.position_m, world_directions(view, SIZE).reshape(-1, 3)
    met, ball = first([mirror], eye, rays), first([CHROME], eye, rays)
    others = np.max([first([quad], eye, rays).inverse_depth for quad in (FLOOR, WALL) if quad is not mirror], axis=0)
    is_ball = mirror is CHROME
    seen = met.cosine > 0.35 if is_ball else (met.inverse_depth > others) & (ball.inverse_depth == 0)
    chosen, expected = np.flatnonzero((met.inverse_depth > 0) & seen), []
    for k in chosen:
        place, length = eye + rays[k] / met.inverse_depth[k], np.linalg.norm(rays[k])
        normal = (place - mirror.centre) / mirror.radius if is_ball else mirror.normal
        beyond = way_on(mirror, place, rays[k] / length - 2 * (rays[k] / length @ normal) * normal)
        way = 1 / beyond if beyond else np.inf
        way = image_behind_ball(way, mirror.radius, met.cosine[k]) if is_ball else way
        expected.append(1 / (1 / met.inverse_depth[k] + way / length))
    assert len(chosen) > 150
    assert (np.abs(found[chosen] - expected) <= 0.004 * np.array(expected) + 1e-5).mean() > 0.94


def test_the_surface_tells_reflectivity_where_the_picture_shows_a_mirror(server):
    """A mirror is drawn behind what stands before it, and its surface is not."""
    eye = layered(server)
    surface, rays = read(eye["reflection"].surface), world_directions(VIEW, SIZE).reshape(-1, 3)
    told = [(mirror.is_curved, mirror.reflectivity) for mirror in eye["reflection"].mirrors]
    assert told == [(False, 0.3), (False, 0.9), (True, 0.85)], "plane ones first"
    balls, quads = (first(things, VIEW.pose.position_m, rays) for things in ((*BALLS, CHROME), (FLOOR, WALL)))
    for index, reflectivity in ((0, 0.3), (1, 0.9)):
        here = ((quads.shape == index) & (quads.inverse_depth > balls.inverse_depth)).reshape(SIZE[::-1])
        # one pixel at each silhouette may go the other way
        assert (np.abs(surface[here, 0] - reflectivity) < 1e-3).mean() > 0.97
    hidden = ((balls.shape == 0) & (balls.cosine > 0.3) & (quads.shape == 1)).reshape(SIZE[::-1])
    assert hidden.sum() > 20 and (surface[hidden] == (0, 0, 0, 1)).all() and (surface[..., 3] == 1).all()
    assert (read(eye["reflection"].seen.colour)[hidden, 3] == 1).all()
    assert (read(eye.inverse_depth)[..., 0] == read(server.draw(VIEW, SIZE).inverse_depth)[..., 0]).all()


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


def test_no_mirror_shows_what_stands_behind_it(serve):
    """A ball behind the wall mirror, which the mirrored eye would see first, is not in it."""
    scene = mirrored_scene(curved=False)
    behind = attrs.evolve(scene.meshes[0], positions=scene.meshes[0].positions + np.float32([0.2, 0.6, -2.6]))
    more = attrs.evolve(scene, meshes=(*scene.meshes, behind))
    pictures = []
    for each in (scene, more):
        server = serve(each)
        eye = layered(server, needs=Needs(reflection=Mirrored.PLANE))
        wall = np.abs(read(eye["reflection"].surface)[..., 0] - 0.9) < 1e-2
        pictures.append(read(eye["reflection"].seen.colour)[wall])
    assert len(pictures[0]) > 100
    assert np.array_equal(*pictures)


def test_a_marched_mirror_shows_what_the_picture_shows_and_nothing_else(serve, server):
    marched = serve(mirrored_scene(), mirrors="screen")
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
