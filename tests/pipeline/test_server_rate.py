"""A server at a rate of its own: what is drawn, what is never shown, and how old it is."""

from __future__ import annotations

import numpy as np
import pytest
from replays import rows_of, run, small

from hmdwarp.frames import Needs
from hmdwarp.link import LinkOptions
from hmdwarp.pipeline.sizes import frames_held
from hmdwarp.run import set_up_replay


def at(rate_hz: float | None) -> LinkOptions:
    return LinkOptions(server_rate_hz=rate_hz)


@pytest.mark.parametrize(("rate_hz", "drawn", "step_ms"), [(30.0, 18, 1000 / 30), (25.0, 15, 40.0), (10.0, 6, 100.0)])
def test_a_slow_server_leaves_each_frame_on_the_screen_for_longer(tmp_path, rate_hz, drawn, step_ms):
    """0.5 s of refreshes, and 0.1 s before the first of them."""
    frames = run(tmp_path, latency_ms=100.0, network=at(rate_hz)).summary["link"]["frames"]
    assert (frames["drawn"], frames["never_shown"]) == (drawn, 0)
    rows = [row for row in rows_of(tmp_path) if row["eye"] == "0"]
    times = sorted({int(row["drawn_ns"]) for row in rows})
    assert np.diff(times) * 1e-6 == pytest.approx([step_ms] * (len(times) - 1), abs=2e-6)
    ages = [float(row["age_ms"]) for row in rows]
    # A frame stays until the first refresh that has the next one.
    assert min(ages) >= 100 - 1e-3 and max(ages) < 100 + step_ms + 1000 / 60


def test_a_server_faster_than_the_display_draws_in_vain_and_shows_younger_frames(tmp_path):
    found = {hz: run(tmp_path / f"{hz:g}", latency_ms=20.0, network=at(hz)).summary for hz in (60.0, 150.0)}
    frames = found[150.0]["link"]["frames"]
    assert found[60.0]["link"]["frames"]["never_shown"] == 0
    assert frames["shown"] <= 31, "one for each refresh at most"
    assert frames["never_shown"] == frames["superseded"] > 40
    assert found[150.0]["link"]["mbit_s"] == pytest.approx(2.5 * found[60.0]["link"]["mbit_s"], rel=0.05)
    ages = {hz: np.mean([float(row["age_ms"]) for row in rows_of(tmp_path / f"{hz:g}")]) for hz in found}
    assert ages[150.0] < ages[60.0] - 5, "20 ms are two refreshes of 60 Hz, and four periods of 150 Hz"
    assert found[150.0]["server_rate_hz"] == 150.0


@pytest.mark.parametrize("rate_hz", [None, 10.0, 25.0, 30.0, 60.0, 150.0])
@pytest.mark.parametrize("latency_ms", [0.0, 20.0, 100.0])
def test_no_more_frames_are_held_than_there_is_room_for(rate_hz, latency_ms):

    options = small(latency_ms=latency_ms, network=at(rate_hz))
    most = 0
    with set_up_replay(options) as setup:
        for number, now_ns in setup.schedule.numbered():
            for instant_ns in setup.channel.due(now_ns):
                setup.loop.draw_at(instant_ns)
                most = max(most, len(setup.channel.link))
            if number >= 0:
                assert setup.loop.show(now_ns) is not None
    assert most <= frames_held(options, 60.0, Needs())
