"""The second, wide and coarse view. How large it is, what the server draws, and what the fill makes
of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from worlds import read

from client.test_multi import HALF_FLOAT, WALL, scene_of, square
from hmdwarp.client import PassInputs, ShownPicture, parse_fills
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View, wide_fov, wide_size, wide_view
from hmdwarp.gpu import SCALAR, Canvas, allocate
from hmdwarp.sources.server import Server

SIZE = (120, 96)
FOV = Fov.from_tangents((-1, 1, -0.8, 0.8))


def turned(degrees: float) -> View:
    return View(Pose((0, 0, 0), Rotation.from_euler("y", degrees, degrees=True).as_quat()), FOV)


def test_it_is_150_by_140_degrees_or_the_eyes_own_where_that_is_more():
    wide = wide_fov(FOV)
    assert math.degrees(wide.right - wide.left) == pytest.approx(150)
    assert math.degrees(wide.up - wide.down) == pytest.approx(140)
    wider = Fov(-1.5, 0.5, -0.1, 0.1)
    assert wide_fov(wider).left == pytest.approx(-1.5)
    assert wide_fov(wider).right == pytest.approx(math.radians(75))


def test_a_frame_brings_it_only_where_it_is_asked_for_and_takes_it_back(gpu):
    server = Server(gpu, scene_of(WALL))
    assert all("wide" not in eye for eye in server.draw_frame([turned(0)], 0, SIZE).eyes)
    for _ in range(2):
        frame = server.draw_frame([turned(0), turned(3)], 70, SIZE, 1.5, Needs(wide=True))
        for eye, view in zip(frame.eyes, (turned(0), turned(3)), strict=True):
            assert eye["wide"].size == wide_size(FOV, SIZE)
            assert eye["wide"].view.fov == wide_view(view).fov
            assert eye["wide"].view.pose.isclose(view.pose)
            assert eye["wide"].drawn_ns == 70
            assert (read(eye["wide"].colour)[..., 3] == 1).all()
        server.recycle(frame)
    assert server.pool(wide_size(FOV, SIZE)).made == 2
    assert server.pool(wide_size(FOV, SIZE)).live == 0
    server.close()


def test_a_turn_past_the_rendered_picture_is_filled_with_real_scenery(gpu):
    """45 degrees to the side the rendered picture has ended. A wall with a square on it stands
    there."""
    scene = scene_of(square(2.9, (-3.5, 0), 0.6, 0.5), WALL)
    server = Server(gpu, scene)
    frame = server.draw_frame([turned(0)], 0, SIZE, 1.0, Needs(wide=True))
    shown = turned(45)
    truth = read(server.draw(shown, SIZE).colour)
    (choice,) = parse_fills("wide")
    fill = choice.entry(gpu, SIZE, SIZE, choice.settings)
    empty, into = (ShownPicture(Canvas(gpu.gl, SIZE), allocate(gpu.gl, SIZE, SCALAR)) for _ in range(2))
    empty.colour.clear()
    fill.run(PassInputs(frame.eyes[0], shown), empty, into)
    gpu.gl.memory_barrier()
    out = read(into.colour.texture)
    within = out[..., 3] > 0
    # 75 degrees are in the wide view; the shown one reaches to 90, whose tangents are none.
    assert within.mean() > 0.6
    assert (np.abs(out - truth).max(axis=-1) <= HALF_FLOAT)[within].mean() > 0.97, (
        "all but the outline, a few shown pixels wide"
    )
    assert ((np.abs(truth[..., 0] - 0.5) <= HALF_FLOAT) & within).sum() > 100
    fill.close()
    server.close()
