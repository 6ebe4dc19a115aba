"""Made-up heads.

The shipped recordings are what the generator makes, and they move as people do.
"""

from __future__ import annotations

import io

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from hmdwarp import resources
from hmdwarp.errors import InputError, UnknownNameError
from hmdwarp.poses import (
    DECIMALS,
    KINDS,
    analyse,
    load_trace,
    minimum_jerk,
    shift_seconds,
    synthesise,
    write_synthetic,
)
from hmdwarp.poses.options import MOTIONS

from .traces import same_motion


@pytest.mark.parametrize("kind", KINDS)
def test_recordings_are_the_generators_bytes(kind):
    stream = io.StringIO()
    write_synthetic(synthesise(kind), stream)
    assert stream.getvalue().encode() == (resources.folder("recordings") / f"{kind}.csv").read_bytes()


def test_every_kind_is_shipped_and_described():
    assert resources.recording_names() == sorted(KINDS)
    text = (resources.folder("recordings") / "README.md").read_text()
    for kind in KINDS.values():
        assert (
            f"hmdwarp trace synth {kind.name} --seed {kind.seed} --seconds {kind.seconds:g} --rate 90 --out "
            f"{kind.name}.csv" in text
        )
        figures = analyse(load_trace(kind.name).track, latencies_ms=())
        turning = " / ".join(f"{v:.1f}" for v in figures.angular_speed_deg_s[:3])
        assert f"| {turning} |" in text
    assert set(MOTIONS.replace(" or ", ", ").split(", ")) == set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_recordings_load_clean_at_90_hz_from_a_standing_head(kind):
    loaded = load_trace(kind)
    assert loaded.format == "native"
    assert [d.kind for d in loaded.defects] == []
    assert 20 <= loaded.track.duration_ns / 1e9 <= 30
    assert loaded.rate_hz == pytest.approx(90, rel=1e-6)
    assert f"hmdwarp trace synth {kind}" in loaded.track.origin
    start = loaded.track.pose(0)
    assert np.allclose(start.position_m, [0, 1.6, 0], rtol=0, atol=1e-6)
    assert np.allclose(start.transform([0, 0, -1.0]) - start.position_m, [0, 0, -1], rtol=0, atol=1e-3)
    # Half a last digit of each number: 0.5 um, and 1e-8 as the angle of four such errors.
    assert same_motion(loaded.track, synthesise(kind), atol=1.1 * 10 ** -min(DECIMALS))


def test_look_around_turns_as_fast_as_264_recorded_heads():
    speed = analyse(load_trace("look-around").track, latencies_ms=()).angular_speed_deg_s
    assert np.all(np.abs(np.array(speed[:3]) / (30, 113, 191) - 1) < 0.15)
    angles = Rotation.from_quat(load_trace("look-around").track.orientation_xyzw).as_euler("YXZ", degrees=True)
    assert angles[:, 0].max() > 60
    assert angles[:, 0].min() < -60
    assert np.abs(angles[:, 1]).max() < 30


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("kind", KINDS)
def test_heads_stay_where_the_scenes_have_room(kind, seed):
    track = synthesise(kind, seed)
    x, y, z = track.position_m.T
    if kind == "walk":
        assert max(np.abs(x).max(), np.abs(z).max()) <= 1.6
        assert 1.45 < y.min() < y.max() < 1.75
        assert np.linalg.norm(np.diff(track.position_m, axis=0), axis=1).sum() > 10
    else:
        assert np.linalg.norm(track.position_m - [0, 1.6, 0], axis=1).max() < 0.3


def test_walking_heads_bob_at_the_step_and_face_where_they_go():
    track = load_trace("walk").track
    walking = slice(4 * 90, 20 * 90)
    height = track.position_m[walking, 1] - track.position_m[walking, 1].mean()
    spectrum = np.abs(np.fft.rfft(height * np.hanning(len(height))))
    assert abs(np.fft.rfftfreq(len(height), 1 / 90)[spectrum.argmax()] - 1.8) < 0.1
    ahead = Rotation.from_quat(track.orientation_xyzw[walking]).apply([0, 0, -1.0])[:-1, ::2]
    going = np.diff(track.position_m[walking], axis=0)[:, ::2]
    cosine = (ahead * going).sum(axis=1) / np.linalg.norm(ahead, axis=1) / np.linalg.norm(going, axis=1)
    assert np.median(cosine) > 0.85


def peak_speed(amplitude_deg: float) -> float:
    """In deg/s: 1.875 of the mean speed, as minimum jerk has it."""
    return 1.875 * amplitude_deg / shift_seconds(amplitude_deg)


@given(st.floats(1, 150), st.floats(0.1, 20))
def test_peak_speed_grows_with_amplitude_and_levels_off(amplitude, more):
    """The main sequence: larger shifts are faster, but less than in proportion."""
    assert peak_speed(amplitude) < peak_speed(amplitude + more) < peak_speed(amplitude) * (amplitude + more) / amplitude


@given(st.floats(5, 150))
def test_the_stated_peak_is_the_peak_of_the_profile(amplitude):
    share = np.linspace(0, 1, 2002)  # an odd number of steps: one of them has the steepest point in its middle
    steepest = np.diff(minimum_jerk(share)).max() * 2001 * amplitude / shift_seconds(amplitude)
    # A central difference over h = 1/2001 misses h^2 / 24 times the third derivative of the slope:
    # 60 / 24 / 2001^2 / 1.875.
    assert steepest == pytest.approx(peak_speed(amplitude), rel=3.5e-7)


@settings(max_examples=20)
@given(st.sampled_from(sorted(KINDS)), st.integers(0, 10**6), st.floats(0.1, 8), st.floats(1, 200))
def test_any_seed_length_and_rate_gives_a_smooth_head(kind, seed, seconds, rate):
    track = synthesise(kind, seed, seconds, rate)
    assert len(track) == int(seconds * rate + 1e-9) + 1
    other = synthesise(kind, seed + 1, seconds, rate)
    assert len(track) == 1 or not np.array_equal(track.orientation_xyzw, other.orientation_xyzw)
    assert not track.broken.any()


def test_the_motion_does_not_depend_on_the_rate():
    slow, fast = synthesise("walk", 3, 10, 30), synthesise("walk", 3, 10, 90)
    assert np.allclose(slow.position_m, fast.position_m[::3], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    "wrong",
    [
        {"seconds": 0},
        {"seconds": float("nan")},
        {"seconds": 1e9},
        {"rate_hz": 0},
        {"rate_hz": float("inf")},
        {"seed": -1},
    ],
)
def test_what_cannot_be_made_is_refused(wrong):
    with pytest.raises(InputError, match="expected"):
        synthesise("still", **wrong)


def test_an_unknown_kind_is_offered_the_nearest():
    with pytest.raises(UnknownNameError, match="did you mean 'walk'"):
        synthesise("walks")
