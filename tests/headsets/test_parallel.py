"""Frames drawn with parallel views and shown with the canted ones that they hold."""

from __future__ import annotations

import numpy as np
import pytest
from replays import run
from worlds import read

from hmdwarp.client import PassInputs
from hmdwarp.client.warps import warps
from hmdwarp.errors import InputError
from hmdwarp.geometry import Fov, ParallelEyes, Pose, View, WarpMap
from hmdwarp.gpu import Canvas
from hmdwarp.headsets import load_headset
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

HEAD = Pose((0.2, 1.6, 0.1), (0.05, 0.3, 0.1, 0.94))
CANTED = ("index", "pimax-8k")


@pytest.mark.parametrize("name", CANTED)
def test_they_look_ahead_and_hold_what_each_eye_sees(name):
    headset = load_headset(name)
    for eye, drawn in zip(headset.views(HEAD), ParallelEyes(headset).views(HEAD), strict=True):
        assert drawn.pose.rotation_matrix == pytest.approx(HEAD.rotation_matrix, abs=1e-12)
        assert drawn.pose.position_m == pytest.approx(eye.pose.position_m, abs=1e-12)
        rays = eye.rays((60, 60)).reshape(-1, 3) @ (drawn.pose.rotation_matrix.T @ eye.pose.rotation_matrix).T
        tangents = rays[:, :2] / -rays[:, 2:]
        left, right, down, up = drawn.fov.tangents
        assert (tangents > (left, down)).all() and (tangents < (right, up)).all()
        # Where an eye sees, the drawn view does; and little else: a pixel on either side.
        size = (400, 400)
        place = ((tangents - (left, down)) / (right - left, up - down) * size).astype(int)
        seen, wanted = drawn.hidden.seen(drawn.fov, size), eye.seen((60, 60))[::-1].ravel()
        assert (seen[place[:, 1], place[:, 0]] == wanted).mean() > 0.98


def test_views_that_are_parallel_stay_as_they_are():
    headset = load_headset("flat-90")
    for eye, drawn in zip(headset.views(HEAD), ParallelEyes(headset).views(HEAD), strict=True):
        assert drawn.fov.tangents == pytest.approx(eye.fov.tangents) and drawn.seen((40, 40)).all()
    assert ParallelEyes(headset).size((64, 48)) == (64, 48)


@pytest.mark.parametrize("name", CANTED)
def test_at_the_same_pose_the_picture_is_the_canted_one(gpu, name):
    """Up to its sampling: no worse than a canted picture that is nowhere denser."""
    headset, size = load_headset(f"{name}:hidden=drawn"), (150, 160)
    parallel, server = ParallelEyes(headset), Server(gpu, load_scene("room"))
    eye, drawn = headset.views(HEAD)[0], parallel.views(HEAD)[0]
    truth = read(server.draw(eye, size).colour)[..., :3]

    def error(view: View, its_size: tuple[int, int]) -> float:
        canvas = Canvas(gpu.gl, size)
        warps.get("rotation")(gpu, its_size, size).run(PassInputs(server.draw(view, its_size), eye), canvas)
        gpu.gl.memory_barrier()
        found = read(canvas.texture)
        assert (found[1:-1, 1:-1, 3] == 1).all()
        return float(np.abs(found[..., :3] - truth)[1:-1, 1:-1].mean())

    # Pixels of the parallel picture in one of the canted one: its map's area, at the corners too.
    to_drawn = WarpMap.between(eye, size, drawn, parallel.size(size)).H
    x, y = np.meshgrid(np.linspace(0, size[0], 9), np.linspace(0, size[1], 9))
    depth = to_drawn[2] @ np.stack([x.ravel(), y.ravel(), np.ones(81)])
    least = np.sqrt(np.abs(np.linalg.det(to_drawn) / depth**3).min())
    coarse = (int(least * size[0]), int(least * size[1]))
    assert 0.6 < least <= 1
    assert error(drawn, parallel.size(size)) < error(eye, coarse)
    server.close()


def test_a_run_draws_them_and_says_what_they_cost(gpu, tmp_path):
    common = {"gpu": gpu, "size": (80, 84), "seconds": 0.1, "warp": "iterative", "guard": 1.1, "latency_ms": 50}
    canted, parallel = (
        run(tmp_path / name[-4:], headset=name, **common).summary for name in ("index", "index:render=parallel")
    )
    cost = parallel["rendered"]["parallel"]
    assert 1.05 < cost < 1.6 and "parallel" not in canted["rendered"]
    assert cost == pytest.approx(parallel["rendered"]["pixels"] / canted["rendered"]["pixels"], rel=1e-3)
    assert parallel["size"] == canted["size"]
    # All that the guard band holds is drawn.
    assert parallel["quality"]["hole_share"]["mean"] <= canted["quality"]["hole_share"]["mean"] + 0.002


def test_an_eye_that_sees_beyond_ninety_degrees_is_refused():
    class Wide:
        def views(self, world_from_head):
            place = Pose((0, 0, 0), (0, np.sin(0.5), 0, np.cos(0.5)))
            return (View(world_from_head @ place, Fov(-1.0, 1.0, -0.5, 0.5), place),)

    with pytest.raises(InputError, match="no parallel view holds that"):
        ParallelEyes(Wide()).views(Pose())
