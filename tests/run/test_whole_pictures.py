"""An imposter beside other warps: it shows what it would show in a run of its own."""

from __future__ import annotations

import numpy as np
import pytest
from replays import small

from hmdwarp.client import build_plan
from hmdwarp.gpu import download
from hmdwarp.link import LinkOptions
from hmdwarp.run import set_up_replay
from hmdwarp.run.truth import WholePictures
from hmdwarp.scenes import scenes

CALLING = [name for name in scenes.names() if scenes.get(name).effects]
PLAN = build_plan((), "none", "none", "none", client_geometry=True)


def refreshed(setup):
    """The third refresh shown."""
    shown = 0
    for _, instant_ns in setup.schedule.numbered():
        setup.loop.draw(instant_ns)
        refresh = setup.loop.show(instant_ns)
        shown += refresh is not None
        if shown == 3:
            return refresh
    raise AssertionError("the recording is too short")


@pytest.mark.parametrize("scene", CALLING)
def test_none_beside_another_warp_is_none_alone(scene):
    asked = {"scene": scene, "latency_ms": 50.0}
    with set_up_replay(small(warp="none", **asked)) as setup:
        alone = [download(eye.panel.texture) for eye in refreshed(setup).eyes]
    with set_up_replay(small(warp="forward", **asked)) as setup:
        refresh, whole, beside = refreshed(setup), WholePictures(setup.server), setup.compensator(PLAN)
        for _ in range(2):  # again, from what is held
            inputs = whole.inputs(setup.loop, refresh, PLAN)
            pictures = [download(beside.run(eye_inputs).panel.texture) for eye_inputs in inputs]
            # Drawn twice, a GPU may blend with another last bit: 2^-10 of a stored half float.
            off = max(np.abs(a.astype(float) - b).max() for a, b in zip(pictures, alone, strict=True))
            assert off <= (0 if setup.target.gpu.is_software else 2.0**-10)
        # The run's own plan gets what was sent.
        own = whole.inputs(setup.loop, refresh, setup.plans[0])
        assert all(one.rendered is sent.rendered for one, sent in zip(own, refresh.inputs, strict=True))
        whole.close()


@pytest.mark.parametrize("warp", ["model", "model:arrives=progressive", "points", "irradiance", "photons"])
def test_a_picture_that_no_plan_reads_is_not_drawn_and_shows_the_same(warp):
    asked = small(scene="lantern", latency_ms=50.0, warp=warp, fill="none", effects="none")
    with set_up_replay(asked) as setup:
        drawn = refreshed(setup)
        assert not any(eye.left_out for eye in drawn.frame.eyes)
        expected = [download(eye.panel.texture) for eye in drawn.eyes]
        late = [download(eye.colour) for eye in drawn.frame.eyes]
    with set_up_replay(asked, alone=True) as setup:
        refresh, whole = refreshed(setup), WholePictures(setup.server)
        for eye, wanted in zip(refresh.eyes, expected, strict=True):
            assert np.array_equal(download(eye.panel.texture), wanted)
        for eye in refresh.frame.eyes:
            assert eye.left_out
            # Holes all over, should anything read it.
            assert not download(eye.colour).any() and (download(eye.inverse_depth) == -1).all()
        beside = setup.compensator(PLAN)
        for one, colour in zip(whole.inputs(setup.loop, refresh, PLAN), late, strict=True):
            assert np.array_equal(download(one.rendered.colour), colour)
            assert download(beside.run(one).panel.texture)[..., 3].any()
        whole.close()


@pytest.mark.parametrize("warp", ["forward", "model"])
def test_pictures_are_drawn_where_they_say_what_has_changed(warp):
    asked = small(latency_ms=50.0, warp=warp, fill="none", effects="none", network=LinkOptions(send="changes"))
    with set_up_replay(asked, alone=True) as setup:
        assert not any(eye.left_out for eye in refreshed(setup).frame.eyes)
