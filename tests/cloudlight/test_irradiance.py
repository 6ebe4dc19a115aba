"""Late indirect light: direct light is of now, the atlas of when it was solved."""

from __future__ import annotations

import numpy as np
import pytest
from client_scene import ClientScene
from replays import run
from worlds import read, shown_by

from hmdwarp.client import PassInputs
from hmdwarp.client.warps import Output
from hmdwarp.frames import Needs
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.link.codec import Coding
from hmdwarp.scenes import scenes

SIZE = (64, 56)
FOV = Fov(-0.8, 0.75, -0.7, 0.65)
HERE, THERE = View(Pose((0.05, 1.6, 0.1)), FOV), View(Pose((0.3, 1.5, -0.2), (0.05, 0.3, 0.02, 0.95)), FOV)
LIT = [name for name in scenes.names() if scenes.get(name).build().lamps]


def shown(gpu, geometry, frame, view, time_ns):
    inputs = PassInputs(frame.eyes[0], view, shown_ns=time_ns)
    return shown_by(gpu, "irradiance", inputs, SIZE, Output(depth=True), geometry)


def frame_of(geometry, time_ns, updates=10.0):
    return geometry.server.draw_frame([HERE, HERE], time_ns, SIZE, needs=Needs(irradiance=updates))


@pytest.mark.parametrize("scene", LIT)
def test_with_the_light_of_now_it_is_the_truth_bit_for_bit(gpu, scene):
    """Whatever the frame was drawn for, from the same atlas and by the same passes."""
    geometry = ClientScene(gpu, scene)
    time_ns = 700_000_000
    got = shown(gpu, geometry, frame_of(geometry, time_ns), THERE, time_ns)
    truth = geometry.server.draw(THERE, SIZE, time_ns=time_ns)
    assert np.array_equal(got[0], read(truth.colour))
    assert np.array_equal(got[1], read(truth.inverse_depth)[..., 0])


def test_each_update_is_whole_so_that_a_lost_one_is_no_matter(gpu):
    """Frames between updates carry the last one again; older frames show the older light."""
    geometry = ClientScene(gpu, "lantern")
    times = (100_000_000, 150_000_000, 199_000_000, 200_000_000, 650_000_000)
    frames = [frame_of(geometry, time_ns) for time_ns in times]
    atlases = [read(frame.eyes[0]["irradiance"]) for frame in frames]
    assert np.array_equal(atlases[0], atlases[1]) and np.array_equal(atlases[0], atlases[2])
    assert not np.array_equal(atlases[0], atlases[3])
    assert frames[0].eyes[0]["irradiance"] is frames[0].eyes[1]["irradiance"]
    in_order = [shown(gpu, geometry, frame, HERE, 700_000_000)[0] for frame in frames]
    turned_round = [shown(gpu, geometry, frame, HERE, 700_000_000)[0] for frame in reversed(frames)]
    assert all(np.array_equal(a, b) for a, b in zip(in_order, reversed(turned_round), strict=True))


@pytest.mark.parametrize("codec", ["none", "h264"])
def test_a_replay_sends_the_atlas_alone(tmp_path, codec):
    """Coded, the atlas errs by a code's error; colour and depth cross in neither case."""
    asked = {"scene": "lantern", "warp": "irradiance"}
    summary = run(tmp_path, **asked, coding=Coding(codec), latency_ms=100.0).summary
    assert set(summary["link"]["layers_mbit_s"]) == {"irradiance"}
    assert summary["quality"]["psnr_db"]["mean"] > 35
