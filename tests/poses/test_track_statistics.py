"""The figures of a track against motions whose figures are known, and against another route."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from hmdwarp.poses import ERROR_PERCENTILES, LATENCIES_MS, PoseTrack, analyse, error_row, load_trace

from .traces import head


def spinning(deg_per_s: float, m_per_s: float = 0.0, seconds: float = 5.0) -> PoseTrack:
    t = np.arange(int(seconds * 90)) / 90
    place = t[:, None] * np.array([m_per_s, 0, 0])
    return PoseTrack(
        np.rint(t * 1e9).astype(np.int64),
        place,
        Rotation.from_euler("Y", deg_per_s * t[:, None], degrees=True).as_quat(),
    )


def test_a_steady_turn():
    figures = analyse(spinning(60, 0.5))
    # Stamps are rounded to 1 ns of 11 ms: 1e-7 of the speed.
    assert np.allclose(figures.angular_speed_deg_s, 60, rtol=2e-7)
    assert np.allclose(figures.linear_speed_m_s, 0.5, rtol=2e-7)
    for row in figures.errors:
        held, ahead = row.errors["none"], row.errors["constant_velocity"]
        assert np.allclose(held.percentiles, 0.06 * row.latency_ms, rtol=1e-6)
        assert held.lag == pytest.approx(0.06 * row.latency_ms, rel=1e-6) and held.lead == held.lead_share == 0
        assert np.allclose(ahead.percentiles, 0.06 * max(row.latency_ms - 100, 0), rtol=1e-6, atol=1e-4)


def test_rate_duration_gaps_and_jumps():
    track = head(100)
    late = track.time_ns + np.where(np.arange(100) > 49, 2_000_000_000, 0)
    figures = analyse(track.evolve(time_ns=late, jumps=(10,)))
    assert figures.samples == 100
    assert figures.duration_s == pytest.approx(99 / 60 + 2)
    assert figures.rate_hz == pytest.approx(60, rel=1e-6)
    assert figures.mean_rate_hz == pytest.approx(99 / (99 / 60 + 2))
    (gap,) = figures.gaps
    assert (gap["start_s"], round(gap["length_s"] * 1e3)) == (int(track.time_ns[49]) / 1e9, 2017)
    assert figures.jumps == 1


def test_statistics_stop_at_gaps():
    """Two turns at 30 deg/s, 90 degrees apart: the step between must not show."""
    a = spinning(30, seconds=2)
    b = Rotation.from_euler("Y", 90, degrees=True) * Rotation.from_quat(a.orientation_xyzw)
    track = PoseTrack(
        np.concatenate([a.time_ns, a.time_ns + 3_000_000_000]),
        np.zeros((2 * len(a), 3)),
        np.concatenate([a.orientation_xyzw, b.as_quat()]),
    )
    figures = analyse(track)
    assert np.allclose(figures.angular_speed_deg_s, 30, rtol=1e-6)
    assert all(np.allclose(r.errors["none"].percentiles, 0.03 * r.latency_ms, rtol=1e-6) for r in figures.errors)


@pytest.mark.parametrize("latency_ms", [20, 100, 400])
def test_the_error_table_by_another_route(latency_ms):
    """SciPy's Slerp and rotation objects on a plain grid, one instant after the other."""
    track = load_trace("look-around").track
    at = Slerp(track.time_ns / 1e9, Rotation.from_quat(track.orientation_xyzw))
    grid = np.arange(track.start_ns + (latency_ms + 50) * 1_000_000, track.end_ns + 1, 5_000_000)
    now, then, before = (at((grid - back * 1_000_000) / 1e9) for back in (0, latency_ms, latency_ms + 50))
    speed = (then * before.inv()).as_rotvec() / 0.05
    guesses = [then, Rotation.from_rotvec(speed * min(latency_ms / 1e3, 0.1)) * then]
    row = error_row(track, latency_ms)
    assert row.count == len(grid)
    for guess, found in zip(guesses, (row.errors["none"], row.errors["constant_velocity"]), strict=True):
        errors = np.degrees((guess.inv() * now).magnitude())
        # float seconds are good to 4e-15 s and the turn is at most 400 deg/s; predictions magnify
        # by up to 9.
        assert np.allclose(found.percentiles, np.percentile(errors, ERROR_PERCENTILES), rtol=0, atol=1e-9)
        assert found.mean == pytest.approx(errors.mean(), abs=1e-9)


def test_too_short_for_a_latency_is_nan_not_a_guess():
    figures = analyse(head(10))
    assert [r.count > 0 for r in figures.errors] == [ms + 50 <= 150 for ms in LATENCIES_MS]
    assert all(np.isnan(error.percentiles).all() for error in figures.errors[-1].errors.values())
    alone = analyse(PoseTrack([0], np.zeros((1, 3)), [[0, 0, 0, 1.0]]))
    assert np.isnan(alone.angular_speed_deg_s).all()


def test_a_very_long_track_is_thinned_evenly():
    hours = spinning(1, seconds=0.5)
    stretched = hours.evolve(time_ns=np.arange(len(hours)) * 10**11, max_gap_ns=10**12)
    row = error_row(stretched, 20)
    assert 150_000 < row.count <= 200_001
