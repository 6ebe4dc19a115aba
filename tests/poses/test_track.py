"""PoseTrack: what it accepts, and the pose at any instant."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from hmdwarp.errors import TraceError
from hmdwarp.geometry import Pose
from hmdwarp.poses import SHORTEST_GAP_NS, Origin, PoseSource, PoseTrack, RecordedSource

from .traces import head

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


def test_a_gap_is_crossed_only_on_request():
    middle = GAPPED.at(260_000_000, across_gaps=True)
    assert middle.origin is Origin.INTERPOLATED
    assert middle.pose.isclose(Pose((0.75, 0.85, 0.95), Rotation.from_euler("Y", 0.55).as_quat()), atol=1e-14)


def test_a_jump_is_not_interpolated_either():
    track = GAPPED.evolve(jumps=(0,))
    assert track.at(5_000_000).origin is Origin.HELD
    assert track.at(15_000_000).origin is Origin.INTERPOLATED


@given(st.lists(st.integers(-50_000_000, 600_000_000), min_size=1, max_size=40), st.booleans())
def test_many_at_once_are_the_same_as_one_by_one(times, across):
    many = GAPPED.sample_many(np.array(times), across)
    for k, t in enumerate(times):
        one = GAPPED.at(t, across)
        assert many.origin[k] == one.origin
        assert Pose(many.position_m[k], many.orientation_xyzw[k]).isclose(one.pose, atol=1e-14)


def test_gap_limit_follows_slow_recordings():
    assert head(50, rate_hz=60).max_gap_ns == SHORTEST_GAP_NS
    assert head(50, rate_hz=4).max_gap_ns == 1_000_000_000


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
    held = track.evolve(position_m=track.position_m[again], orientation_xyzw=track.orientation_xyzw[again], jumps=(5,))
    bare = held.without_repeats()
    assert bare.time_ns.tolist() == held.time_ns[[0, 2, 3, 6, 7]].tolist()
    assert bare.jumps == (2,)


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


def test_a_recorded_source_is_a_pose_source():
    source = RecordedSource(TRACK)
    assert isinstance(source, PoseSource)
    source.start()
    assert source.head_at(7).pose.isclose(TRACK.at(7).pose, atol=0)
    source.close()
    source.close()
