"""Guard `auto`: as large as the head's motion over the latency calls for, and told."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.errors import InputError
from hmdwarp.headsets import load_headset
from hmdwarp.options import parse_guard
from hmdwarp.poses import PoseTrack
from hmdwarp.run import RunOptions, choose, needed_factors
from hmdwarp.run.choosing import MOST, NEAR_M

FLAT = load_headset("flat-90")  # 45 degrees to every side


def heads(*poses: tuple[tuple[float, float, float], Rotation]) -> tuple[np.ndarray, np.ndarray]:
    return np.array([place for place, _ in poses], float), np.array([turn.as_quat() for _, turn in poses])


def turned(axis: str, degrees: float, place=(0.0, 0.0, 0.0)):
    return place, Rotation.from_euler(axis, degrees, degrees=True)


STILL = turned("y", 0)


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("degrees", [-20, 5, 30])
def test_a_turn_needs_the_tangent_of_the_half_angle_and_the_turn(axis, degrees):
    """The middle of a side 45 degrees out lies 45 + the turn degrees out in the drawn picture."""
    elsewhere = (0.0, 0.0, 0.0)
    # The eyes sit beside the axis that the head turns about: at 1 m that is some centimetres more;
    # turning about x moves neither.
    found = needed_factors(FLAT, heads(STILL), heads(turned(axis, degrees, elsewhere)))[0]
    exact = math.tan(math.radians(45 + abs(degrees)))
    eyes_moved = 2 * FLAT.ipd_m * abs(math.sin(math.radians(degrees))) / NEAR_M if axis == "y" else 0
    assert exact - 1e-9 <= found <= exact + (1 + exact) * eyes_moved + 1e-9


def test_a_step_aside_counts_for_what_is_a_metre_away():
    found = needed_factors(FLAT, heads(STILL), heads(turned("y", 0, (0.25, 0.0, 0.0))))[0]
    assert found == pytest.approx(1 + 0.25 / NEAR_M)


def test_a_turn_out_of_every_plane_needs_an_infinite_guard():
    assert np.isinf(needed_factors(FLAT, heads(STILL), heads(turned("y", 60)))).all()


def steady(deg_s: float) -> PoseTrack:
    """Turning to the left."""
    t = np.arange(0, 2_000_000_001, 10_000_000)
    return PoseTrack(
        t, np.zeros((len(t), 3)), Rotation.from_rotvec(np.outer(np.radians(deg_s * t * 1e-9), (0, 1, 0))).as_quat()
    )


@pytest.fixture
def turning(tmp_path):
    from hmdwarp.poses.writing import write_native

    path = tmp_path / "turning.csv"
    with path.open("w") as stream:
        write_native(steady(40), stream, (6, 8))
    return str(path)


def test_a_steady_turn_gets_what_it_moves_by_in_the_latency_and_prediction_saves_it(turning):
    """40 deg/s for 200 ms are 8 degrees.

    A constant velocity is predicted to the last bit, as far as the horizon reaches.
    """
    usual = {"trace": turning, "guard": "auto", "headset": "flat-90", "lens": "none", "latency_ms": 200, "rate_hz": 50}
    plain = choose(RunOptions(**usual, predict="none")).options
    assert math.tan(math.radians(53)) <= plain.guard <= math.tan(math.radians(53)) + 0.03
    predicted = choose(RunOptions(**usual, predict="constant_velocity", horizon_ms=300))
    assert predicted.options.guard == pytest.approx(1, abs=0.011)
    assert f"{predicted.options.guard:g} is drawn" in predicted.notes[0]


def test_no_more_than_most_is_drawn_and_the_note_says_so():
    choice = choose(RunOptions(trace="fast-turns", guard="auto", latency_ms=400))
    assert choice.options.guard == MOST
    assert "--wide" in choice.notes[0]


def test_a_number_stays_as_it_is():
    options = RunOptions(trace="no such trace", guard=1.5)
    assert choose(options).options == options


def test_invalid_guards_are_refused():
    assert parse_guard(" auto ") == "auto"
    assert parse_guard("1.5") == 1.5
    assert parse_guard("1.25x1.125") == (1.25, 1.125)
    assert parse_guard(" 1.5 X 1.5 ") == 1.5
    for wrong in ("wide", "1.5x", "x1.5", "1x2x3", ""):
        with pytest.raises(InputError, match=r"one factor of at least 1 \(1\.5\) or one for each axis"):
            parse_guard(wrong)
    for wrong in (0.9, math.nan, "much", (1.5, 0.9), (math.inf, 1.5)):
        with pytest.raises((InputError, ValueError)):
            RunOptions(trace="still", guard=wrong)
