"""PoseTrack: what it accepts, the pose at any instant, its figures; a recording that goes on."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from hmdwarp.base import TraceError
from hmdwarp.geometry import Pose
from hmdwarp.poses import (
    LoopedSource,
    Origin,
    PoseTrack,
    analyse,
    error_row,
    folded,
    load_trace,
    quaternions,
    synthesise,
)

from .traces import head, unit_quaternions

TRACK = head(100)
GAPPED = PoseTrack(
    [0, 10_000_000, 20_000_000, 500_000_000, 510_000_000],
    np.arange(15).reshape(5, 3) * 0.1,
    Rotation.from_euler("Y", [[a] for a in (0, 0.1, 0.2, 0.9, 1.0)]).as_quat(),
)


@given(st.integers(TRACK.start_ns, TRACK.end_ns))
def test_between_samples_it_is_scipys_slerp_and_linear(t):
    sample = TRACK.at(t)
    turned = Slerp(TRACK.time_ns / 1e9, Rotation.from_quat(TRACK.orientation_xyzw))(t / 1e9)
    place = [np.interp(t, TRACK.time_ns, TRACK.position_m[:, k]) for k in range(3)]
    # t/1e9 rounds to 1e-16 relative of 1.6 s, at 1 rad/s and 1 m/s.
    assert sample.pose.isclose(Pose(place, turned.as_quat()), atol=1e-13)
    assert sample.origin is (Origin.MEASURED if t in TRACK.time_ns else Origin.INTERPOLATED)
    assert sample.time_ns == t


def test_a_sample_comes_back():
    for i in range(len(TRACK)):
        sample = TRACK.at(int(TRACK.time_ns[i]))
        assert sample.origin is Origin.MEASURED
        assert np.array_equal(sample.pose.position_m, TRACK.position_m[i])
        # Pose normalises once more: the last bit may differ.
        assert np.allclose(sample.pose.orientation_xyzw, TRACK.orientation_xyzw[i], rtol=0, atol=3e-16)


@pytest.mark.parametrize(
    ("t", "index"), [(-1, 0), (-(10**30), 0), (510_000_001, 4), (10**30, 4), (20_000_001, 2), (499_999_999, 2)]
)
def test_outside_and_within_gaps_the_pose_is_held(t, index):
    sample = GAPPED.at(t)
    assert sample.origin is Origin.HELD
    assert sample.pose.isclose(GAPPED.pose(index), atol=0)


def test_a_jump_is_not_interpolated_either():
    track = GAPPED.evolve(jumps=(0,))
    assert track.at(5_000_000).origin is Origin.HELD
    assert track.at(15_000_000).origin is Origin.INTERPOLATED


@given(st.lists(st.integers(-50_000_000, 600_000_000), min_size=1, max_size=40))
def test_many_at_once_are_the_same_as_one_by_one(times):
    many = GAPPED.sample_many(np.array(times))
    for k, t in enumerate(times):
        one = GAPPED.at(t)
        assert many.origin[k] == one.origin
        assert Pose(many.position_m[k], many.orientation_xyzw[k]).isclose(one.pose, atol=1e-14)


def test_gap_limit_follows_slow_recordings():
    assert [head(50, rate_hz=rate).max_gap_ns for rate in (60, 4)] == [100_000_000, 1_000_000_000]


def test_one_sample_is_held_everywhere_but_at_its_instant():
    track = PoseTrack([5], [[1.0, 2, 3]], [[0.0, 0, 0, 1]])
    assert [track.at(t).origin for t in (4, 5, 6)] == [Origin.HELD, Origin.MEASURED, Origin.HELD]
    assert track.sample_many(np.array([4, 5, 6])).origin.tolist() == [Origin.HELD, Origin.MEASURED, Origin.HELD]
    assert track.rate_hz == 0


def test_signs_and_lengths_are_mended_and_input_arrays_left_alone():
    q = np.array([[0, 0, 0, 1.001], [0, -0.1, 0, -1.0], [0, 0.2, 0, 0.98]])
    before = q.copy()
    track = PoseTrack([0, 1, 2], np.zeros((3, 3)), q)
    assert np.array_equal(q, before)
    assert np.allclose(np.linalg.norm(track.orientation_xyzw, axis=1), 1, rtol=0, atol=3e-16)
    assert (np.einsum("ij,ij->i", track.orientation_xyzw[1:], track.orientation_xyzw[:-1]) > 0).all()


def test_repeats_are_left_out_for_differentiating_with_jumps_kept_in_place():
    track = head(8)
    again = np.array([0, 0, 1, 2, 2, 2, 3, 4])
    held = track.evolve(
        position_m=track.position_m[again], orientation_xyzw=track.orientation_xyzw[again], jumps=(2, 5)
    )
    bare = held.without_repeats()
    assert bare.time_ns.tolist() == held.time_ns[[0, 2, 3, 6, 7]].tolist()
    assert bare.jumps == (1, 2)


@pytest.mark.parametrize(
    ("time_ns", "position", "orientation", "word"),
    [
        ([], np.zeros((0, 3)), np.zeros((0, 4)), "at least one"),
        ([0, 0], np.zeros((2, 3)), [[0, 0, 0, 1]] * 2, "does not increase at sample 1"),
        ([0, 1], np.zeros((2, 3)), [[0, 0, 0, 1], [0, 0, 0, 0.9]], "sample 1: a quaternion of length 0.9"),
        ([0, 1], [[0, 0, 0], [0, np.nan, 0]], [[0, 0, 0, 1]] * 2, "sample 1 .* not finite"),
        ([0, 1], [[0, 0, 0], [0, -1e20, 0]], [[0, 0, 0, 1]] * 2, r"sample 1 .* 1e\+20 m away: expected at most 1e\+09"),
        ([0, 1], np.zeros((2, 2)), [[0, 0, 0, 1]] * 2, r"expected \(2, 3\)"),
        ([0.0, 1.0], np.zeros((2, 3)), [[0, 0, 0, 1]] * 2, "integers"),
    ],
)
def test_an_invalid_track_is_refused(time_ns, position, orientation, word):
    with pytest.raises(TraceError, match=word):
        PoseTrack(np.array(time_ns, dtype=None if time_ns else np.int64), position, orientation)


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
    assert np.allclose([*figures["angular_speed_deg_s"].values()], 60, rtol=2e-7)
    assert np.allclose([*figures["linear_speed_m_s"].values()], 0.5, rtol=2e-7)
    for row in figures["errors_deg"]:
        held, ahead, late_ms = row["none"], row["constant_velocity"], row["latency_ms"]
        assert np.allclose([*held.values()], 0.06 * late_ms, rtol=1e-6)
        assert np.allclose([*ahead.values()], 0.06 * max(late_ms - 100, 0), rtol=1e-6, atol=1e-4)


def test_rate_duration_gaps_and_jumps():
    track = head(100)
    late = track.time_ns + np.where(np.arange(100) > 49, 2_000_000_000, 0)
    figures = analyse(track.evolve(time_ns=late, jumps=(10,)))
    assert figures["samples"] == 100 and figures["jumps"] == 1
    assert figures["duration_s"] == pytest.approx(99 / 60 + 2)
    assert figures["rate_hz"] == pytest.approx(60, rel=1e-6)
    assert figures["mean_rate_hz"] == pytest.approx(99 / (99 / 60 + 2))
    (gap,) = figures["gaps"]
    assert (gap["start_s"], round(gap["length_s"] * 1e3)) == (int(track.time_ns[49]) / 1e9, 2017)


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
    assert np.allclose([*figures["angular_speed_deg_s"].values()], 30, rtol=1e-6)
    for row in figures["errors_deg"]:
        assert np.allclose([*row["none"].values()], 0.03 * row["latency_ms"], rtol=1e-6)


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
    assert row["count"] == len(grid)
    for guess, found in zip(guesses, (row["none"], row["constant_velocity"]), strict=True):
        errors = np.degrees((guess.inv() * now).magnitude())
        # float seconds are good to 4e-15 s and the turn is at most 400 deg/s; predictions magnify
        # by up to 9.
        wanted = [errors.mean(), *np.percentile(errors, (50, 95, 99))]
        assert list(found) == ["mean", "p50", "p95", "p99"]
        assert np.allclose([*found.values()], wanted, rtol=0, atol=1e-9)


def test_too_short_for_a_latency_is_nan_not_a_guess():
    rows = analyse(head(10))["errors_deg"]
    assert all((row["count"] > 0) == (row["latency_ms"] + 50 <= 150) for row in rows)
    assert all(np.isnan(error["p95"]) for error in rows[-1].values() if isinstance(error, dict))
    alone = analyse(PoseTrack([0], np.zeros((1, 3)), [[0, 0, 0, 1.0]]))
    assert np.isnan([*alone["angular_speed_deg_s"].values()]).all()


def test_a_very_long_track_is_thinned_evenly():
    hours = spinning(1, seconds=0.5)
    stretched = hours.evolve(time_ns=np.arange(len(hours)) * 10**11, max_gap_ns=10**12)
    row = error_row(stretched, 20)
    assert 150_000 < row["count"] <= 200_001


TRACK_LOOPED = synthesise("walk", seed=1, seconds=1)


class Clock:
    now_ns = 0

    def __call__(self) -> int:
        return self.now_ns


@given(st.integers(-(10**12), 10**13), st.integers(1, 10**11))
def test_time_stays_inside_and_never_jumps(since_ns, length_ns):
    here, next_ = (folded(at, length_ns).since_ns for at in (since_ns, since_ns + 1))
    assert 0 <= here <= length_ns
    assert abs(next_ - here) <= 1
    assert folded(since_ns + 2 * length_ns, length_ns).since_ns == here or since_ns < 0


def test_the_first_time_through_it_is_the_track_and_then_its_mirror_image():
    source, track = LoopedSource(TRACK_LOOPED, Clock()), TRACK_LOOPED
    for after_ns in (0, 1, 123_456_789, track.duration_ns):
        expected = track.at(track.start_ns + after_ns).pose
        for asked_ns in (after_ns, 2 * track.duration_ns - after_ns, 2 * track.duration_ns + after_ns):
            sample = source.head_at(asked_ns)
            assert sample.time_ns == asked_ns
            assert np.array_equal(sample.pose.position_m, expected.position_m)
            assert np.array_equal(sample.pose.orientation_xyzw, expected.orientation_xyzw)


def test_restart_begins_anew():
    clock = Clock()
    source = LoopedSource(TRACK_LOOPED, clock)
    clock.now_ns = 700_000_000
    source.restart()
    sample = source.head_at(clock.now_ns)
    assert np.array_equal(sample.pose.position_m, TRACK_LOOPED.pose(0).position_m)
    assert sample.read_ns == clock.now_ns


# A product of unit quaternions sums four products of numbers below 1: a few units of 1.1e-16 each,
# doubled by going to an angle.
ATOL = 5e-15


def angle(a, b) -> float:
    return float((Rotation.from_quat(a).inv() * Rotation.from_quat(b)).magnitude())


@given(unit_quaternions, unit_quaternions)
def test_product_inverse_and_rotation_are_scipys(a, b):
    assert angle(quaternions.multiply(a, b), (Rotation.from_quat(a) * Rotation.from_quat(b)).as_quat()) < ATOL
    assert angle(quaternions.conjugate(a), Rotation.from_quat(a).inv().as_quat()) < ATOL
    v = np.array([0.3, -2.0, 5.0])
    assert np.allclose(quaternions.rotate(a, v), Rotation.from_quat(a).apply(v), rtol=0, atol=5e-14)


@given(unit_quaternions)
def test_log_and_exp_are_inverse_and_scipys(q):
    log = quaternions.to_rotation_vector(q)
    assert np.linalg.norm(log) <= np.pi + 1e-12
    assert angle(quaternions.from_rotation_vector(log), q) < ATOL


@given(unit_quaternions, unit_quaternions, st.sampled_from([0.0, 1e-12, 1.0]))
def test_turns_of_one_in_plain_floats_are_scipys(a, b, share):
    """From one towards the other, by all, next to nothing or nothing: there and back."""
    wanted = (
        Rotation.from_quat(a),
        Rotation.from_rotvec(share * (Rotation.from_quat(b) * Rotation.from_quat(a).inv()).as_rotvec()),
    )
    q = quaternions.turned(a.tolist(), wanted[1].as_rotvec().tolist())
    assert angle(q, (wanted[1] * wanted[0]).as_quat()) < 2 * ATOL
    v = np.array(quaternions.turn(a.tolist(), q))
    assert np.linalg.norm(v) <= np.pi + 1e-12
    assert angle(Rotation.from_rotvec(v).as_quat(), wanted[1].as_quat()) < 3 * ATOL  # three products


@given(unit_quaternions, st.floats(0, 1))
def test_slerp_is_scipys(a, share):
    b = quaternions.multiply(quaternions.from_rotation_vector(np.array([0.2, -0.7, 0.4])), a)
    wanted = Slerp([0, 1], Rotation.from_quat([a, b]))(share).as_quat()
    assert angle(quaternions.slerp(a.tolist(), b.tolist(), share), wanted) < 2e-14
    many = quaternions.slerp_many(a[None], b[None], np.array([share]))[0]
    assert np.allclose(many, quaternions.slerp(a.tolist(), b.tolist(), share), rtol=0, atol=1e-15)


@pytest.mark.parametrize("angle", [1e-8, np.pi, np.nextafter(np.pi, 0)])
def test_slerp_at_the_ends_of_its_formula(angle):
    """The sine of the angle is divided by itself; that of pi is not 0 in floating point."""
    a, b = ([0.0, np.sin(half), 0.0, np.cos(half)] for half in (0.5, 0.5 + angle / 2))
    for share in (0.0, 0.25, 0.5, 0.75, 1.0):
        got = np.array(quaternions.slerp(a, b, share))
        assert abs(np.linalg.norm(got) - 1) <= (4e-16 if angle < 1 else 1e-15)  # one rounding of each part, or two
        assert abs(2 * np.arcsin(min(np.linalg.norm(got - a) / 2, 1)) * 2 - share * angle) <= 1e-7 * min(angle, 1)
