"""Pictures of a scene with lamps, against rays in float64 by another route."""

from __future__ import annotations

import attrs
import numpy as np
from lit_rooms import placed
from worlds import read

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.scenes import load_scene, with_lamps_stopped

SIZE = (48, 40)
FOV = Fov(-0.8, 0.75, -0.7, 0.65)
VIEW = View(Pose((0.1, 1.5, 0.4), (0.02, 0.1, 0.0, 0.99)), FOV)


def test_a_door_is_lit_and_casts_its_shadow_wherever_it_has_been(serve):
    """As where it stands still there. Places turned by a float32 matrix err by 1e-6 m: the light of
    a pixel by no more than a half float rounds, but at an edge of shadow, in few."""
    scene = load_scene("doorway")
    server = serve(scene)
    for time_ns in (2_500_000_000, 1_000_000_000):
        got = read(server.draw(VIEW, SIZE, time_ns=time_ns).colour)
        there = serve(placed(scene, time_ns))
        wanted = read(there.draw(VIEW, SIZE, time_ns=9).colour)
        assert np.isclose(got, wanted, rtol=2e-3, atol=1e-4).all(axis=2).mean() > 0.99


def test_a_shut_door_keeps_the_light_out_and_an_open_one_lets_it_in(serve):
    """With the bright room's lamp alone, to the last bit: no ray passes beside a shut door."""
    scene = load_scene("doorway")
    scene = attrs.evolve(scene, lamps=scene.lamps[:1])
    server = serve(scene)
    shut, open_ = (read(server.draw(VIEW, SIZE, time_ns=ms * 1_000_000).colour)[..., :3] for ms in (200, 2500))
    assert (shut == 0).all()
    assert (open_ > 0).mean() > 0.95, "hardly a place has no light at all"


def test_baked_light_stays_where_a_door_moves(serve):
    """At the instant of the light it is the truth; later surfaces keep their light, bit for bit."""
    scene = load_scene("doorway")
    server, baked = serve(scene), serve(with_lamps_stopped(scene, 500_000_000))
    first, later = ([each.draw(VIEW, SIZE, time_ns=ms * 1_000_000) for each in (server, baked)] for ms in (500, 2500))
    truth, same, moved, stayed = (read(eye.colour)[..., :3] for eye in (*first, *later))
    seen = [read(eye.inverse_depth) for eye in (first[1], later[1])]
    assert np.array_equal(truth, same)
    rest = np.equal(*seen)[..., 0]
    assert 0.3 < rest.mean() < 1
    assert np.array_equal(stayed[rest], same[rest])
    assert moved[rest].mean() > 1.5 * stayed[rest].mean()
