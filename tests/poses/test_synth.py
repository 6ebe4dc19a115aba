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

from hmdwarp.base import InputError, resources
from hmdwarp.poses import (
    DECIMALS,
    GLIDES,
    KINDS,
    analyse,
    load_trace,
    synthesise,
    write_synthetic,
)
from hmdwarp.poses.options import MOTIONS

from .traces import same_motion

PEOPLE = tuple(name for name in KINDS if name not in GLIDES)


def test_every_kind_is_shipped_and_described():
    assert set(KINDS) < set(resources.recording_names())
    text = (resources.folder("recordings") / "README.md").read_text()
    for kind in KINDS.values():
        glide = GLIDES.get(kind.name)
        how = f"--speed {glide.speed:g} --amplitude {glide.amplitude:g}" if glide else f"--seed {kind.seed}"
        assert (
            f"hmdwarp trace synth {kind.name} {how} --seconds {kind.seconds:g} --rate 90 --out {kind.name}.csv" in text
        )
        figures = analyse(load_trace(kind.name).track, latencies_ms=())
        turning = " / ".join(f"{v:.1f}" for v in [*figures["angular_speed_deg_s"].values()][:3])
        assert f"| {turning} |" in text
    assert set(MOTIONS.replace(" or ", ", ").split(", ")) == set(KINDS)


@pytest.mark.parametrize("kind", KINDS)
def test_recordings_are_the_generators_bytes_and_begin_with_a_standing_head(kind):
    write_synthetic(synthesise(kind), stream := io.StringIO())
    assert stream.getvalue().encode() == (resources.folder("recordings") / f"{kind}.csv").read_bytes()
    loaded = load_trace(kind)
    assert loaded.format == "native" and loaded.notes == []
    assert loaded.track.duration_ns / 1e9 == pytest.approx(KINDS[kind].seconds)
    assert loaded.track.rate_hz == pytest.approx(90, rel=1e-6)
    start = loaded.track.pose(0)
    assert np.allclose(start.position_m, [0, 1.6, 0], rtol=0, atol=1e-6)
    assert np.allclose(start.transform([0, 0, -1.0]) - start.position_m, [0, 0, -1], rtol=0, atol=1e-3)
    # Half a last digit of each number: 0.5 um, and 1e-8 as the angle of four such errors.
    assert same_motion(loaded.track, synthesise(kind), atol=1.1 * 10 ** -min(DECIMALS))


@settings(max_examples=20)
@given(st.sampled_from(sorted(PEOPLE)), st.integers(0, 10**6), st.floats(0.1, 8), st.floats(1, 200))
def test_any_seed_length_and_rate_gives_a_smooth_head(kind, seed, seconds, rate):
    track = synthesise(kind, seed, seconds, rate)
    assert len(track) == int(seconds * rate + 1e-9) + 1
    other = synthesise(kind, seed + 1, seconds, rate)
    assert len(track) == 1 or not np.array_equal(track.orientation_xyzw, other.orientation_xyzw)
    assert not track.broken.any()


@pytest.mark.parametrize(("kind", "seed"), [("walk", 3), ("forward", None)])
def test_the_motion_does_not_depend_on_the_rate(kind, seed):
    slow, fast = synthesise(kind, seed, 10, 30), synthesise(kind, seed, 10, 90)
    assert np.allclose(slow.position_m, fast.position_m[::3], rtol=0, atol=1e-12)


def distance(kind: str, seconds: float = 8.0, rate_hz: float = 90.0, **about: float) -> np.ndarray:
    """How far the head is from its start, in the motion's unit; every other freedom is zero."""
    track = synthesise(kind, seconds=seconds, rate_hz=rate_hz, **about)
    turned = Rotation.from_quat(track.orientation_xyzw).as_rotvec(degrees=True)
    moved = track.position_m - [0, 1.6, 0]
    axis, sign = {"forward": (2, -1), "backward": (2, 1), "sideways": (0, 1), "rotate": (1, 1)}[kind]
    used, other = (turned, moved) if kind == "rotate" else (moved, turned)
    assert not other.any() and not np.delete(used, axis, axis=1).any()
    # A rotation vector ends at half a turn.
    return np.unwrap(sign * used[:, axis], period=360)


GLIDING = st.sampled_from(sorted(GLIDES))


@settings(max_examples=40)
@given(GLIDING, st.floats(0.05, 1), st.floats(0.05, 1))
def test_a_glide_keeps_its_speed_and_turns_at_its_amplitude(kind, speed, amplitude):
    if kind == "rotate":
        speed, amplitude = 200 * speed, 340 * amplitude
    glide = GLIDES[kind].with_(speed, amplitude)
    begin, end = glide.steady_s
    leg_s = begin + end
    # Two ways out and back in 4000 steps.
    gone = distance(kind, min(4 * leg_s, 3600), min(1000 / leg_s, 1000), speed=speed, amplitude=amplitude)
    step_s = 1 / min(1000 / leg_s, 1000)
    assert gone.min() > -1e-9 and gone.max() <= amplitude * (1 + 1e-12)
    # The last 1/1000 of a way out, at rest at its end, is shorter than 1/1000 of the amplitude.
    assert gone.max() > 0.998 * amplitude
    velocity = np.diff(gone) / step_s
    assert np.abs(velocity).max() <= speed * (1 + 1e-9)
    middle = (np.arange(len(velocity)) + 0.5) * step_s
    steady = (middle > begin + step_s) & (middle < end - step_s)
    assert velocity[steady] == pytest.approx(speed)
    # The speed never jumps: minimum jerk is steepest with 1.875 of its mean slope.
    assert np.abs(np.diff(velocity)).max() <= 1.875 * speed / glide.ease_s * step_s * (1 + 1e-6)
    # There and back, and the same again.
    period = round(2 * leg_s / step_s)
    assert gone[: period + 1] == pytest.approx(gone[: period + 1][::-1], abs=amplitude * 1e-2)


@pytest.mark.parametrize(
    ("kind", "about", "why"),
    [
        ("forward", {"speed": 0}, "speed 0 m per second: expected 0.001 to 5"),
        ("forward", {"amplitude": 1.6}, "amplitude 1.6 m: expected 0.001 to 1.5"),
        ("rotate", {"amplitude": 361}, "amplitude 361 degrees: expected 0.001 to 360"),
        ("rotate", {"speed": float("nan")}, "speed nan degrees per second"),
        ("rotate", {"seed": 1}, "seed 1: motion rotate has nothing random"),
        ("walk", {"speed": 1}, "motion walk has the speeds of people; expected one of backward, forward"),
        ("walk", {"amplitude": 1}, "motion walk"),
        ("walks", {}, "did you mean 'walk'"),
        *(("still", {"seconds": seconds}, "expected") for seconds in (0, float("nan"), 1e9)),
        *(("still", {"rate_hz": rate_hz}, "expected") for rate_hz in (0, float("inf"))),
        ("still", {"seed": -1}, "expected"),
    ],
)
def test_unknown_motions_bad_numbers_and_options_of_other_motions_are_refused(kind, about, why):
    with pytest.raises(InputError, match=why):
        synthesise(kind, **about)
