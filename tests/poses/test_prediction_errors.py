"""Lead and lag of predictions: on motions where both are known, and against another route."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.poses import signed_lead, turn_errors

AXIS = np.array([0.6, 0.0, 0.8])
STILL_DEG = 0.2


def turned(*degrees: float) -> np.ndarray:
    """Orientations about one slanted axis, from a head that does not look ahead."""
    start = Rotation.from_euler("YXZ", [1.0, 0.3, 0.1])
    return (Rotation.from_rotvec(np.outer(np.radians(degrees), AXIS)) * start).as_quat()


@pytest.mark.parametrize(
    ("actual", "predicted", "lead"),
    [
        pytest.param(10, 0, -10, id="a turn, held: it lags by all of it"),
        pytest.param(10, 10, 0, id="a turn, foreseen"),
        pytest.param(10, 13, 3, id="a turn, foreseen too far"),
        pytest.param(-10, -13, 3, id="the same to the other side"),
        pytest.param(4, 12, 8, id="a stop: the head came to rest after 4 of 12 degrees"),
        pytest.param(0, 12, 12, id="a stop at once: all of it is lead"),
        pytest.param(0, 0, 0, id="rest, foreseen"),
        pytest.param(-5, 12, -17, id="a reversal: the head is where it was not expected, ahead of the picture"),
        pytest.param(-5, -1, -4, id="a reversal, foreseen in part"),
        pytest.param(90, 120, 30, id="far round"),
    ],
)
def test_lead_of_motions_that_are_known(actual, predicted, lead):
    found = turn_errors(turned(0), turned(actual), turned(predicted))
    # Angles of up to 2 rad, to 1e-15 each, in degrees.
    assert found.mean == pytest.approx(abs(predicted - actual), abs=1e-11)
    assert found.lead == pytest.approx(max(lead, 0), abs=1e-11)
    assert found.lag == pytest.approx(max(-lead, 0), abs=1e-11)
    assert found.lead_share == (lead > STILL_DEG)


def test_an_error_across_the_motion_neither_leads_nor_lags():
    missed, moved = np.array([[0.0, 3.0, 0.0]]), np.array([[2.0, 0.0, 0.0]])
    assert signed_lead(missed, moved, STILL_DEG) == 0


def test_a_tremor_is_no_direction():
    """A head that shakes by less than a tracker's step is at rest: what the picture moves leads."""
    missed, moved = np.array([[3.0, 0.0, 0.0]]), np.array([[-0.1, 0.0, 0.0]])
    assert signed_lead(missed, moved, STILL_DEG) == pytest.approx(2.9)
    # Held, it lags by nothing worth a name, and never leads.
    assert signed_lead(-moved, moved, STILL_DEG) == 0


def test_figures_of_many_by_another_route():
    rng = np.random.default_rng(3)
    known, actual, predicted = (Rotation.random(500, rng=rng) for _ in range(3))
    actual = Rotation.from_rotvec(0.3 * actual.as_rotvec()) * known
    predicted = Rotation.from_rotvec(0.2 * predicted.as_rotvec()) * actual
    found = turn_errors(known.as_quat(), actual.as_quat(), predicted.as_quat())
    leads = []
    for k, a, p in zip(known, actual, predicted, strict=True):
        turn = (a * k.inv()).as_rotvec(degrees=True)
        leads.append((p * a.inv()).as_rotvec(degrees=True) @ (turn / np.linalg.norm(turn)))
    angles = np.degrees((predicted * actual.inv()).magnitude())
    assert found.mean == pytest.approx(angles.mean(), abs=1e-10)
    assert found.percentiles == pytest.approx(np.percentile(angles, (50, 95, 99)), abs=1e-10)
    assert found.lead == pytest.approx(np.percentile(leads, 95), abs=1e-10)
    assert found.lag == pytest.approx(-np.percentile(leads, 5), abs=1e-10)
    assert found.lead_share == np.mean(np.array(leads) > STILL_DEG)


def test_no_prediction_is_nan():
    none = np.empty((0, 4))
    found = turn_errors(none, none, none)
    assert np.isnan([found.mean, *found.percentiles, found.lead_share, found.lead, found.lag]).all()
