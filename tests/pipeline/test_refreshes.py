"""Which refreshes a run has, also beside a server at a rate of its own, and how old frames are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from replays import rows_of, run, small

from hmdwarp.base import InputError
from hmdwarp.frames import Needs
from hmdwarp.link import Link, LinkOptions
from hmdwarp.pipeline.sizes import frames_held, refreshes_of
from hmdwarp.poses import PoseTrack
from hmdwarp.run import set_up_replay
from hmdwarp.run.run import schedule_of

BEGIN_NS = 5_000_000_123  # a trace's clock starts anywhere


def track(seconds: float) -> PoseTrack:
    time_ns = BEGIN_NS + np.array([0, round(seconds * 5e8), round(seconds * 1e9)])
    return PoseTrack(time_ns, np.zeros((3, 3)), np.tile([0.0, 0, 0, 1], (3, 1)), name="made")


def shown_ages(times, latency_ms: float) -> list[int | None]:
    """What the loop would show. The age of the newest frame at every shown refresh, in ns, None
    where none has arrived."""
    link: Link[int] = LinkOptions().link(times.link_latency_ns(small(latency_ms=latency_ms)))
    ages = []
    for number, now_ns in times.numbered():
        link.send(now_ns, now_ns)
        if number >= 0:
            drawn = link.newest(now_ns)
            ages.append(None if drawn is None else now_ns - drawn)
    return ages


@settings(max_examples=300)
@given(
    latency_ms=st.one_of(st.floats(0, 3000), st.integers(0, 300).map(float)),
    rate_hz=st.one_of(st.sampled_from([24.0, 59.94, 60.0, 72.0, 90.0, 120.0, 144.0, 128.0, 512.0]), st.floats(1, 1000)),
    seconds=st.one_of(st.none(), st.floats(0.001, 1)),
    start_s=st.floats(0, 4),
)
def test_every_shown_refresh_has_its_frame_at_its_age(latency_ms, rate_hz, seconds, start_s):
    made = track(4.5)
    assume(refreshes_of(latency_ms, rate_hz) / rate_hz <= 4.5)
    times = schedule_of(made, small(latency_ms=latency_ms, start_s=start_s, seconds=seconds), rate_hz)
    instants = list(times.numbered())
    shown = [at for number, at in instants if number >= 0]
    period_ns = 1e9 / rate_hz

    # From the start asked for, or from when a frame drawn at the trace's first instant is seen;
    # half a ns is rounding.
    earliest_s = max(start_s, times.age / rate_hz)
    assert abs(shown[0] - (made.start_ns + earliest_s * 1e9)) <= 1
    assert len(shown) == times.count and len(instants) == times.count + times.age
    fitting = min(math.inf if seconds is None else seconds, 4.5 - earliest_s) * rate_hz
    assert times.count == max(1, math.floor(fitting + 1e-6))
    # Nothing is drawn before the trace or shown after its end.
    assert instants[0][1] >= made.start_ns - 1 and shown[-1] <= made.end_ns + 1
    steps = np.diff([at for _, at in instants])
    assert (np.abs(steps - period_ns) <= 1).all()

    ages = shown_ages(times, latency_ms)
    assert None not in ages
    # Never early (but for the thousandth of a refresh that counts as none), and no more than one
    # refresh late.
    assert all(latency_ms * 1e6 - 1e-3 * period_ns - 2 <= age < latency_ms * 1e6 + period_ns + 2 for age in ages)
    assert max(ages) - min(ages) <= 2
    assert all(abs(age - times.age_ns) <= 2 for age in ages)


@pytest.mark.parametrize(
    ("latency_ms", "rate_hz", "age"),
    [(0, 60, 0), (200, 60, 12), (200, 90, 18), (205, 60, 13), (1, 60, 1), (16.67, 60, 1), (16.7, 60, 2),
     (16.6667, 60, 1), (33.3, 60, 2), (33.4, 60, 3), (11.11, 90, 1), (2500, 72, 180)],
)  # fmt: skip
def test_ages_people_would_expect(latency_ms, rate_hz, age):
    assert refreshes_of(latency_ms, rate_hz) == age


ONE_SAMPLE = PoseTrack(np.array([7]), np.zeros((1, 3)), np.array([[0.0, 0, 0, 1]]), name="one")


@pytest.mark.parametrize(
    ("made", "options", "told"),
    [
        (track(2.0), {"start_s": 2.0}, "start 2 s.*2.000 s long"),
        (track(2.0), {"start_s": 1e6}, "start"),
        (track(2.0), {"latency_ms": 2001.0}, "latency 2001 ms is longer"),
        # 120 refreshes after drawing at 60 Hz, 2000 ms; the last would be at 2.0167 s.
        (track(1.9995), {"latency_ms": 1999.0}, "latency 1999 ms is longer"),
        (track(2.0), {"latency_ms": 1e9}, "latency"),
        (ONE_SAMPLE, {}, "single sample"),
    ],
)
def test_a_run_without_a_frame_to_show_is_refused(made, options, told):
    with pytest.raises(InputError, match=told):
        schedule_of(made, small(**options), 60.0)


@pytest.mark.parametrize(("latency_ms", "age_ms"), [(0.0, 0.0), (10.0, 1000 / 60), (205.0, 13000 / 60)])
def test_rows_of_a_run_have_that_age_up_to_the_end_of_its_trace(latency_ms, age_ms, tmp_path):
    path, seconds = tmp_path / "short.txt", 77.0 if latency_ms else None
    rows = "".join(f"{i / 50} 0 1.6 0 0 0 0 1\n" for i in range(26))
    path.write_text("# timestamp tx ty tz qx qy qz qw\n" + rows, encoding="utf-8")
    rows = run(tmp_path / "out", trace=str(path), latency_ms=latency_ms, seconds=seconds).rows
    assert [row["frame"] for row in rows[::2]] == list(range(30 - round(age_ms * 60 / 1000)))  # 0.5 s at 60 Hz
    assert rows[0]["time_s"] == pytest.approx(age_ms * 1e-3, abs=2e-9)
    # The instants are whole nanoseconds.
    assert all(row["age_ms"] == pytest.approx(age_ms, abs=2e-6) and row["drawn_ns"] >= 0 for row in rows)
    assert {row["pose_origin"] for row in rows} <= {"measured", "interpolated"}


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
