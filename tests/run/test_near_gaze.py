"""The picture around where the eye looks, and how late the gaze was that its frame had."""

from __future__ import annotations

import math

import attrs
import numpy as np
import pytest
from eyes import with_eyes
from replays import run
from scipy.spatial.transform import Rotation

from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.metrics import Compared
from hmdwarp.poses import synthesise, write_synthetic
from hmdwarp.run.measuring import NEAR_DEG, NearGaze, near_gaze

SIZE = (60, 48)
AHEAD = View(Pose(), Fov.symmetric(math.radians(60), math.radians(50)))


def looking_left(degrees: float) -> View:
    yaw = math.radians(degrees)
    return attrs.evolve(AHEAD, gaze=(-math.sin(yaw), 0.0, -math.cos(yaw)))


def test_pixels_near_the_gaze_are_those_within_five_degrees():
    """Against angles by another route; for an eye that is canted the gaze turns back."""
    canted = Pose((0.03, 0, 0), Rotation.from_euler("y", 10, degrees=True).as_quat())
    for view in (looking_left(12), attrs.evolve(looking_left(12), head_from_eye=canted)):
        found = near_gaze(view, SIZE)
        rays = view.head_from_eye.rotation.apply(view.rays(SIZE).reshape(-1, 3)).reshape(*SIZE[::-1], 3)
        angles = np.degrees(np.arctan2(np.linalg.norm(np.cross(rays, view.gaze), axis=-1), rays @ view.gaze))
        assert np.array_equal(found, angles <= NEAR_DEG) and 20 < found.sum() < 200


def test_an_error_counts_where_the_eye_looks_alone():
    truth = np.full((*SIZE[::-1], 3), 100, np.uint8)
    shown = truth.copy()
    shown[near_gaze(looking_left(12), SIZE)[::-1]] = 90
    there, elsewhere = NearGaze(), NearGaze()
    there.add(Compared(shown, truth, AHEAD), looking_left(12), looking_left(12))
    elsewhere.add(Compared(shown, truth, AHEAD), looking_left(-12), looking_left(12))
    assert there.entry()["gaze"]["psnr_db"] == pytest.approx(20 * math.log10(255 / 10))
    assert elsewhere.entry()["gaze"]["psnr_db"] == 100


def test_the_gaze_is_off_by_what_eyes_and_head_have_moved():
    """The head turned by 7 degrees to the left and the eyes by 5 to the right: 2 in the world."""
    rendered = looking_left(3)
    turned = Pose((0, 0, 0), Rotation.from_euler("y", 7, degrees=True).as_quat())
    shown = attrs.evolve(looking_left(-2), pose=turned)
    near, blank = NearGaze(), np.zeros((*SIZE[::-1], 3), np.uint8)
    near.add(Compared(blank, blank, AHEAD), shown, rendered)
    assert near.entry()["gaze"]["off_deg"] == pytest.approx({"p50": 2.0, "p95": 2.0})
    assert NearGaze().entry() == {}


def test_a_gaze_that_a_frame_lacks_is_not_taken_for_straight_ahead():
    blank, here = np.zeros((*SIZE[::-1], 3), np.uint8), looking_left(3)
    for looks_ahead, off in ((False, None), (True, {"p50": 3.0, "p95": 3.0})):
        near = NearGaze(looks_ahead)
        near.add(Compared(blank, blank, AHEAD), here, AHEAD)
        found = near.entry()["gaze"]["off_deg"]
        assert (found and pytest.approx(found)) == off


def test_a_predicted_head_has_the_gaze_of_the_head_that_is_held(tmp_path, gpu):
    """Prediction turns the head; the eyes rest in the world, as they do for a fovea."""
    with (tmp_path / "eyes.csv").open("w", encoding="utf-8") as file:
        write_synthetic(with_eyes(synthesise("look-around", seconds=2)), file)
    found = [
        run(
            tmp_path / "out",
            gpu=gpu,
            trace=str(tmp_path / "eyes.csv"),
            latency_ms=100.0,
            rate_hz=50.0,
            force=True,
            **how,
        )
        for how in ({"predict": "none"}, {"predict": "cautious"}, {"predict": "cautious", "fovea_deg": 40.0})
    ]
    off = [result.summary["gaze"]["off_deg"] for result in found]
    # Each refresh lies on a sample, so that all know the same.
    assert off[0]["p95"] > 0.5 and off[1] == pytest.approx(off[0], abs=1e-4)
    assert off[2] == pytest.approx(off[0], abs=1e-4)
