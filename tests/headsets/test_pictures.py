"""Pictures of canted and unequal eyes: what is drawn, warped and guarded for them."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from client.test_multi import WALL, scene_of, square
from hypothesis import given, settings
from hypothesis import strategies as st
from replays import run
from worlds import read

from hmdwarp.client import Compensator, PassInputs, build_plan
from hmdwarp.geometry import Pose
from hmdwarp.headsets import load_headset
from hmdwarp.sources.server import Server

from .test_eyes import MADE_UP

SIZE = (67, 53)
UNLIKE = ("index", "pimax-8k", "beyond-2e")
ANY = st.one_of(st.sampled_from(UNLIKE).map(load_headset), MADE_UP)


@given(ANY)
@settings(max_examples=8)
def test_left_and_right_exchanged_give_the_mirrored_picture(gpu, headset):
    other = attrs.evolve(headset, eyes=tuple(eye.mirrored() for eye in headset.eyes[::-1]))
    pictures = []
    for side, eyes in ((1, headset), (-1, other)):
        far, near = square(2.0, (side * 0.7, 0.3), 0.5, 0.5), square(1.5, (side * -0.2, -0.4), 0.3, 0.9)
        server = Server(gpu, scene_of(far, near, WALL))
        pictures.append([read(server.draw(view, SIZE).colour) for view in eyes.views(Pose((side * 0.1, 0, 0)))])
        server.close()
    for eye in (0, 1):
        found, wanted = pictures[0][eye], pictures[1][1 - eye][:, ::-1]
        # A pixel centre within rounding of an edge may fall to either side of it.
        assert (np.abs(found - wanted).max(axis=-1) > 2e-3).mean() < 0.002
        assert np.ptp(found[..., 0]) > 0.1


@pytest.mark.parametrize("warp", ["rotation", "iterative", "forward"])
@given(headset=MADE_UP)
@settings(max_examples=4)
def test_an_unmoved_head_sees_what_was_drawn_whatever_the_eyes(gpu, warp, headset):
    server = Server(gpu, scene_of(square(1.5, (0.1, -0.2), 0.4, 0.6), WALL))
    client = Compensator(gpu, build_plan((), warp, "none", "none", client_geometry=True), None, SIZE, SIZE, hides=True)
    for view in headset.views(Pose((0.1, 0, 0))):
        rendered = server.draw(view, SIZE)
        shown = read(client.run(PassInputs(rendered, view)).shown.texture)
        seen = view.hidden.seen(view.fov, SIZE)
        assert np.array_equal(shown[seen], read(rendered.colour)[seen]) and 0.3 < seen.mean() < 1
    client.close()
    server.close()


@pytest.mark.parametrize("name", UNLIKE)
@pytest.mark.parametrize("warp", ["rotation", "forward", "iterative", "mesh", "multi"])
def test_a_frame_without_latency_is_shown_as_it_is(gpu, tmp_path, name, warp):
    made = run(tmp_path, gpu=gpu, headset=name, warp=warp, latency_ms=0, size=SIZE, seconds=0.05)
    quality = made.summary["quality"]
    assert (quality["psnr_db"]["mean"], quality["hole_share"]["mean"]) == (100, 0)  # 100: equal


@pytest.mark.parametrize("name", UNLIKE)
def test_a_wide_guard_leaves_no_border(gpu, tmp_path, name):
    common = {
        "headset": name, "trace": "fast-turns", "start_s": 2.0, "warp": "rotation", "latency_ms": 30, "size": SIZE,
    }  # fmt: skip
    border = [
        run(tmp_path / str(guard), gpu=gpu, **common, guard=guard).summary["quality"]["border_share"]["mean"]
        for guard in (1.0, 2.0)
    ]
    assert border[0] > 0 == border[1]
