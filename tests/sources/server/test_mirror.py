"""What mirrors show, against rays mirrored in the world, and how it gets into the picture."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from mirrored import BALLS, CHROME, FLOOR, VIEW, WALL, mirrored_scene, moved
from reference._rays import world_directions
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
