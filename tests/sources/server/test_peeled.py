"""The cube, the layers behind the picture and the further views that the server draws."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from reference._rays import world_directions
from replays import each_refresh, small
from worlds import pixels

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View, cube_size, face_views
from hmdwarp.geometry.cube import FACES
from hmdwarp.gpu import download
from hmdwarp.scenes import Background, Quad, Scene
from hmdwarp.sources.server.parts.views import LEAST_M, chosen, motion_of, moved, seen

VIEW = View(Pose((0.3, 1.5, -0.2), (0.1, 0.2, -0.05, 0.9)), Fov(-0.7, 0.8, -0.6, 0.75))
SIZE = (61, 47)


def test_each_face_is_the_picture_of_its_view(serve):
    server = serve("room")
    frame = server.draw_frame([VIEW], 0, SIZE, needs=Needs(cube=True))
    eye = frame.eyes[0]
    assert eye["cube"].size == cube_size(VIEW.fov, SIZE)
    side, cube = eye["cube"].size[0] // 3, pixels(eye["cube"])
    assert (cube[..., 3] == 1).all()
    for face, view in zip(FACES, face_views(VIEW, side), strict=True):
        alone = server.draw(view, (side, side))
        drawn = cube[face.row * side : (face.row + 1) * side, face.column * side : (face.column + 1) * side]
        # The same triangles in another place of the framebuffer: a rasteriser may round an edge
        # otherwise, and mipmaps with it.
        same = np.abs(drawn.astype(float) - pixels(alone.colour)).max(axis=-1) <= 2**-9
        assert same.mean() > 0.99, face.name
        server.pool((side, side)).release(alone.colour)


FOV = Fov(-0.6, 0.7, -0.5, 0.55)
SKY = (0.25, 0.5, 1.0)
AHEAD = View(Pose(), FOV)


def walls(*depths_m: float, half: float = 0.3, double_sided: bool = False, facing: float = 1) -> Scene:
    """Squares of half edge `half` times their distance, one behind the other before the origin,
    number k of brightness k + 1."""
    meshes = [
        Quad((0, 0, -z), (half * z * facing, 0, 0), (0, half * z, 0), -1, (k + 1.0,) * 3).mesh(f"wall {k}")
        for k, z in enumerate(depths_m)
    ]
    meshes = [attrs.evolve(mesh, double_sided=double_sided) for mesh in meshes]
    return Scene("walls", "", meshes, background=Background.uniform(SKY))


def peeled(serve, scene: Scene, count: int, view: View = AHEAD) -> list[tuple[np.ndarray, np.ndarray]]:
    """(colour, inverse depth) of the visible layer and `count` behind it."""
    server = serve(scene)
    eye = server.draw_frame([view], 0, SIZE, needs=Needs(peeled=count)).eyes[0]
    assert len(eye["peeled"]) == count
    return [(pixels(each.colour), pixels(each.inverse_depth)) for each in (eye, *eye["peeled"])]


def middle() -> np.ndarray:
    """Pixels whose rays pass well within the squares."""
    rays = world_directions(AHEAD, SIZE)
    return (np.abs(rays[..., :2] / rays[..., 2:]) < 0.27).all(axis=-1)


def test_walls_one_behind_the_other_then_the_sky_then_nothing(serve):
    layers = peeled(serve, walls(1, 2, 5), 4)
    for k, (colour, depth) in enumerate(layers[:3]):
        assert depth[middle()] == pytest.approx(1 / (1, 2, 5)[k], rel=1e-6)
        assert (colour[middle()] == (k + 1, k + 1, k + 1, 1)).all()
    sky_colour, sky_depth = layers[3]
    assert (sky_depth[middle()] == 0).all()
    assert np.abs(sky_colour[middle()] - (*SKY, 1)).max() < 1e-3
    nothing_colour, nothing_depth = layers[4]
    assert (nothing_depth == -1).all()
    assert (nothing_colour == 0).all()


def test_close_behind_is_behind_and_a_surface_is_not_behind_itself(serve):
    """1 mm at 2 m: a picture on a wall."""
    layers = peeled(serve, walls(2, 2.001), 2)
    assert layers[1][1][middle()] == pytest.approx(1 / 2.001, rel=1e-6)
    assert (layers[2][1][middle()] == 0).all()


@pytest.mark.parametrize("double_sided", [False, True])
def test_backs_are_left_out_as_in_the_picture_itself(serve, double_sided):
    layers = peeled(serve, walls(1, 2, double_sided=double_sided, facing=-1), 1)
    assert layers[0][1][middle()] == pytest.approx(1.0 if double_sided else 0)
    assert layers[1][1][middle()] == pytest.approx(0.5 if double_sided else -1)


WIDE = Fov.from_tangents((-1, 1, -0.8, 0.8))
SCREEN = (120, 96)
WALL_M, SQUARE_M, HALF_M = 3.0, 1.0, 0.25
MS = 1_000_000
RIGHT = np.array([0.1, 0, 0])


def view_at(place) -> View:
    return View(Pose(place), WIDE)


def depth_of(view: View) -> np.ndarray:
    """A square 1 m before the origin and a wall behind it, which all views look straight at."""
    x, y, z = view.pose.position_m
    rays = view.rays(SCREEN)
    away = SQUARE_M + z
    on_square = (np.abs(x + away * rays[..., 0]) <= HALF_M) & (np.abs(y + away * rays[..., 1]) <= HALF_M)
    return np.where(on_square, 1 / away, 1 / (WALL_M + z))


def hidden_behind_square(view: View, target: View) -> np.ndarray:
    """Which points of the wall in the target's pixels lie behind the square, by straight lines."""
    (x, y, z), from_eye = target.pose.position_m, view.pose.position_m
    rays = target.rays(SCREEN)
    wall = np.stack([x + (WALL_M + z) * rays[..., 0], y + (WALL_M + z) * rays[..., 1]], axis=-1)
    part = (SQUARE_M + from_eye[2]) / (WALL_M + from_eye[2])
    through = from_eye[:2] + part * (wall - from_eye[:2])
    return (np.abs(through) <= HALF_M).all(axis=-1) & (depth_of(target) < 0.5)


@pytest.mark.parametrize("way", [RIGHT, -RIGHT, (0.05, 0.08, 0), (0, 0, -0.2), (0, 0, 0.3)], ids=str)
def test_a_picture_shows_what_no_straight_line_to_it_meets_anything_before(way):
    view, target = view_at((0, 0, 0)), view_at(way)
    found = seen(view, depth_of(view), target, depth_of(target), SCREEN)
    hidden = hidden_behind_square(view, target)
    tangents = target.pose.position_m[:2] + (1 / depth_of(target))[..., None] * target.rays(SCREEN)[..., :2]
    away = 1 / depth_of(target) - target.pose.position_m[2] + view.pose.position_m[2]
    outside = (np.abs(tangents / away[..., None]) >= (1, 0.8)).any(axis=-1)
    wrong = found == (hidden | outside)
    # Only where the nearest pixel of the picture lies across an edge: beside the outline of the
    # square, at most one pixel on either side, and beside the picture's own.
    outline = 2 * 4 * 2 * HALF_M / SQUARE_M * SCREEN[0] / 2 / 0.8
    assert wrong.sum() <= outline + 2 * sum(SCREEN)
    assert way[0] == 0 or hidden.sum() > 30


@pytest.mark.parametrize("sign", [1, -1])
def test_the_first_view_is_taken_from_where_the_eye_goes(sign):
    view = view_at((0, 0, 0))
    motion = motion_of(view, sign * np.array([0.5, 0, 0]), 0.2)
    first, second = chosen(view, SCREEN, motion, 2, depth_of)
    assert first @ RIGHT * sign > 0 and np.linalg.norm(first) >= 0.04
    assert not np.array_equal(first, second)
    target = moved(view, motion[0])
    wanted = depth_of(target)

    def empty(*ways) -> float:
        shown = [seen(place, depth_of(place), target, wanted, SCREEN) for way in ways for place in [moved(view, way)]]
        return 1 - np.any(shown, axis=0).mean()

    assert empty(np.zeros(3), first) < 0.2 * empty(np.zeros(3))
    assert empty(np.zeros(3), first, second) <= empty(np.zeros(3), first)


def test_the_server_draws_them_as_any_other_picture(serve):
    server, needs, age_ns = serve("room"), Needs(views=2), 400 * MS
    place = server.scene.viewpoint.position_m
    for number in range(3):
        eyes = [view_at(place + (0.03 * number + x, 0, 0)) for x in (-0.03, 0.03)]
        frame = server.draw_frame(eyes, number * 100 * MS, SCREEN, needs=needs, age_ns=age_ns)
        ways = [[view.view.pose.position_m - eye.view.pose.position_m for view in eye["views"]] for eye in frame.eyes]
        assert np.allclose(ways[0], ways[1]), "as far from each eye"
        # 0.3 m/s for 0.4 s, once there is a frame before.
        assert np.linalg.norm(ways, axis=-1).max() <= (0.12 if number else LEAST_M) + 1e-9
        assert not number or ways[0][0] @ RIGHT > 0, "the first is taken from where the head goes"
        for view in (view for eye in frame.eyes for view in eye["views"]):
            again = server.draw(view.view, SCREEN, time_ns=frame.drawn_ns)
            assert np.array_equal(download(again.colour), download(view.colour))
            server.pool(SCREEN).release(again.colour)
        server.recycle(frame)
    assert server.pool(SCREEN).made == 2 * 3 + 1, "two eyes of three pictures, and the one to compare with"


def test_an_eye_that_turns_away_falls_back_on_an_older_frame():
    found: list[int] = []
    options = {"warp": "multi:views=2,frames=1,eye=own,spacing=50", "latency_ms": 50.0, "size": (32, 24)}
    each_refresh(small(**options), lambda setup, number, refresh: found.append(len(refresh.inputs[0].others)))
    assert found[-1] == 3, "two views and the older frame"
