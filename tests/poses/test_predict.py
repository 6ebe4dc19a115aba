"""Prediction.

Exact for a constant velocity, causal, capped, honest about where a pose came from.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hmdwarp.errors import InputError, UnknownNameError
from hmdwarp.geometry import Pose
from hmdwarp.poses import Origin, PoseTrack, predict
from hmdwarp.poses.predictors import predictors

from .traces import head

MS = 1_000_000
SPIN_RAD_S = np.array([0.3, 1.5, -0.2])
SPEED_M_S = np.array([0.5, 0.0, -1.0])


def steady(n: int = 100, step_ns: int = 11 * MS) -> PoseTrack:
    t = np.arange(n) * step_ns
    start = Rotation.from_euler("YXZ", [1.0, 0.3, 0.1])
    q = (Rotation.from_rotvec(t[:, None] * 1e-9 * SPIN_RAD_S) * start).as_quat()
    return PoseTrack(t, t[:, None] * 1e-9 * SPEED_M_S, q)


def part(track: PoseTrack, of: slice) -> PoseTrack:
    p, q = track.position_m[of], track.orientation_xyzw[of]
    return track.evolve(time_ns=track.time_ns[of], position_m=p, orientation_xyzw=q)


def truth(t_ns: int) -> Pose:
    start = Rotation.from_euler("YXZ", [1.0, 0.3, 0.1])
    return Pose(t_ns * 1e-9 * SPEED_M_S, (Rotation.from_rotvec(t_ns * 1e-9 * SPIN_RAD_S) * start).as_quat())


@given(st.integers(60 * MS, 1000 * MS), st.integers(1, 100 * MS))
def test_a_constant_velocity_is_predicted_exactly(now, ahead):
    track = steady()
    sample = predict(track, now, now + ahead, "constant_velocity", horizon_ns=10**12)
    assert sample.origin is Origin.PREDICTED
    assert sample.time_ns == now + ahead
    # Angles of 0.08 rad over 50 ms, known to 1e-16, carried on over at most 111 ms: a few 1e-16 per
    # pose, times 3.
    assert sample.pose.isclose(truth(now + ahead), atol=1e-14)


def test_the_horizon_caps_the_prediction():
    track = steady()
    now = int(track.time_ns[50])
    far = predict(track, now, now + 800 * MS, "constant_velocity")
    assert far.pose.isclose(truth(now + 100 * MS), atol=1e-14)
    assert far.time_ns == now + 800 * MS
    assert predict(track, now, now + 800 * MS, "constant_velocity", horizon_ns=0).origin is Origin.HELD


@pytest.mark.parametrize("method", predictors.names())
@given(now=st.integers(-20 * MS, 1700 * MS), ahead=st.integers(-50 * MS, 900 * MS))
def test_no_sample_after_now_is_looked_at(method, now, ahead):
    track = head(100)
    known = max(track.index_at(now), 0) + 1
    past = part(track, slice(known))
    a, b = predict(track, now, now + ahead, method), predict(past, now, now + ahead, method)
    assert a.origin is b.origin
    assert a.pose.isclose(b.pose, atol=0)


def test_a_known_instant_is_looked_up():
    track = head(100)
    now = int(track.time_ns[40])
    assert predict(track, now, int(track.time_ns[38])).origin is Origin.MEASURED
    assert predict(track, now, int(track.time_ns[38]) + 5).origin is Origin.INTERPOLATED


@pytest.mark.parametrize("method", predictors.names())
def test_prediction_stops_at_gaps_and_jumps(method):
    track = head(100)
    late = track.time_ns + np.where(np.arange(100) > 50, 900 * MS, 0)
    gapped = track.evolve(time_ns=late)
    within = int(late[50]) + 300 * MS
    assert predict(gapped, within, within + 50 * MS, method).origin is Origin.HELD
    after = int(late[51])
    assert predict(gapped, after, after + 50 * MS, method).origin is Origin.HELD
    jumped = track.evolve(jumps=(50,))
    at = int(track.time_ns[52])
    only_after = predict(jumped, at, at + 50 * MS, method)
    alone = predict(part(track, slice(51, None)), at, at + 50 * MS, method)
    assert only_after.pose.isclose(alone.pose, atol=0)


def test_repeated_poses_do_not_slow_the_prediction_down():
    track = steady(step_ns=5 * MS)
    keep = np.arange(100) // 2 * 2
    held = track.evolve(position_m=track.position_m[keep], orientation_xyzw=track.orientation_xyzw[keep])
    now = int(track.time_ns[61])  # repeats the pose of sample 60
    # The window runs from sample 60 back, at the true velocity; the pose is carried on from now, 5
    # ms late.
    assert predict(held, now, now + 50 * MS, "constant_velocity").pose.isclose(
        truth(int(track.time_ns[60]) + 50 * MS), atol=1e-14
    )


@pytest.mark.parametrize("method", predictors.names())
def test_a_head_at_rest_stays(method):
    track = head(100)
    still = np.minimum(np.arange(100), 50)
    rested = track.evolve(position_m=track.position_m[still], orientation_xyzw=track.orientation_xyzw[still])
    now = int(track.time_ns[80])
    assert predict(rested, now, now + 50 * MS, method).pose.isclose(track.pose(50), atol=0)


@pytest.mark.parametrize("method", [predictor.name for predictor in predictors])
def test_many_at_once_are_the_single_ones_where_samples_lie(method):
    """On a steady head; elsewhere `constant_velocity` measures from sample to sample instead."""
    track, one = steady(), predictors.get(method)
    now = track.time_ns[20:90:7]
    for ahead in (20 * MS, 100 * MS, 400 * MS):
        found = one.predict_many(track, now, ahead)
        for k, instant in enumerate(now.tolist()):
            single = predict(track, instant, instant + ahead, method)
            assert Pose(found.position_m[k], found.orientation_xyzw[k]).isclose(single.pose, atol=1e-14)


def test_bad_arguments():
    with pytest.raises(UnknownNameError, match="constant_velocity"):
        predict(head(), 0, 1, "constant-velocity")
    with pytest.raises(InputError, match="horizon -1 ms"):
        predict(head(), 0, 1, horizon_ns=-MS)
