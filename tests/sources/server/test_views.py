"""Further views: where they are drawn from, and what they show."""

from __future__ import annotations

import numpy as np
import pytest
from replays import each_refresh, small

from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download
from hmdwarp.sources.server.parts.views import LEAST_M, chosen, motion_of, moved, seen

FOV = Fov.from_tangents((-1, 1, -0.8, 0.8))
SIZE = (120, 96)
WALL_M, SQUARE_M, HALF_M = 3.0, 1.0, 0.25
MS = 1_000_000
RIGHT = np.array([0.1, 0, 0])


def view_at(place) -> View:
    return View(Pose(place), FOV)


def depth_of(view: View) -> np.ndarray:
    """A square 1 m before the origin and a wall behind it, which all views look straight at."""
    x, y, z = view.pose.position_m
    rays = view.rays(SIZE)
    away = SQUARE_M + z
    on_square = (np.abs(x + away * rays[..., 0]) <= HALF_M) & (np.abs(y + away * rays[..., 1]) <= HALF_M)
    return np.where(on_square, 1 / away, 1 / (WALL_M + z))


@pytest.mark.parametrize("sign", [1, -1])
def test_the_first_view_is_taken_from_where_the_eye_goes(sign):
    view = view_at((0, 0, 0))
    motion = motion_of(view, sign * np.array([0.5, 0, 0]), 0.2)
    first, second = chosen(view, SIZE, motion, 2, depth_of)
    assert first @ RIGHT * sign > 0 and np.linalg.norm(first) >= 0.04
    assert not np.array_equal(first, second)
    target = moved(view, motion[0])
    wanted = depth_of(target)

    def empty(*ways) -> float:
        shown = [seen(place, depth_of(place), target, wanted, SIZE) for way in ways for place in [moved(view, way)]]
        return 1 - np.any(shown, axis=0).mean()

    assert empty(np.zeros(3), first) < 0.2 * empty(np.zeros(3))
    assert empty(np.zeros(3), first, second) <= empty(np.zeros(3), first)


def test_the_server_draws_them_as_any_other_picture(serve):
    server, needs, age_ns = serve("room"), Needs(views=2), 400 * MS
    place = server.scene.viewpoint.position_m
    for number in range(3):
        eyes = [view_at(place + (0.03 * number + x, 0, 0)) for x in (-0.03, 0.03)]
        frame = server.draw_frame(eyes, number * 100 * MS, SIZE, needs=needs, age_ns=age_ns)
        ways = [[view.view.pose.position_m - eye.view.pose.position_m for view in eye["views"]] for eye in frame.eyes]
        assert np.allclose(ways[0], ways[1]), "as far from each eye"
        # 0.3 m/s for 0.4 s, once there is a frame before.
        assert np.linalg.norm(ways, axis=-1).max() <= (0.12 if number else LEAST_M) + 1e-9
        for view in (view for eye in frame.eyes for view in eye["views"]):
            again = server.draw(view.view, SIZE, time_ns=frame.drawn_ns)
            assert np.array_equal(download(again.colour), download(view.colour))
            server.pool(SIZE).release(again.colour)
        server.recycle(frame)
    assert server.pool(SIZE).made == 2 * 3 + 1, "two eyes of three pictures, and the one to compare with"


def test_an_eye_that_turns_away_falls_back_on_an_older_frame():
    found: list[int] = []
    options = {"warp": "multi:views=2,frames=1,eye=own,spacing=50", "latency_ms": 50.0, "size": (32, 24)}
    each_refresh(small(**options), lambda setup, number, refresh: found.append(len(refresh.inputs[0].others)))
    assert found[-1] == 3, "two views and the older frame"
