"""Where the eyes look: read, written, held and predicted."""

from __future__ import annotations

import io
import math

import numpy as np
import pytest
from eyes import with_eyes
from scipy.spatial.transform import Rotation

from hmdwarp.base import TraceError
from hmdwarp.geometry import Pose
from hmdwarp.poses import PoseTrack, known_gaze, load_trace, predict, synthesise
from hmdwarp.poses.formats import formats
from hmdwarp.poses.predictors import predictors

MS = 1_000_000
NONE = (math.nan,) * 3


def towards(yaw_deg: float, pitch_deg: float = 0.0) -> np.ndarray:
    """A direction so far to the left and up."""
    yaw, pitch = math.radians(yaw_deg), math.radians(pitch_deg)
    return np.array([-math.sin(yaw) * math.cos(pitch), math.sin(pitch), -math.cos(yaw) * math.cos(pitch)])


def track(gazes, step_ms: float = 10, **more) -> PoseTrack:
    n = len(gazes)
    times = np.rint(np.arange(n) * step_ms * MS).astype(np.int64)
    turns = np.tile([0.0, 0, 0, 1], (n, 1))
    return PoseTrack(times, np.zeros((n, 3)), turns, gaze=np.array(gazes, float), **more)


def angle(gaze) -> float:
    """Degrees to the left."""
    return math.degrees(math.atan2(-gaze[0], -gaze[2]))


def test_a_slow_eye_is_interpolated_and_a_leap_is_not():
    looked = track([towards(0), towards(0.8), towards(9), towards(9.2)])  # 80 and 820 degrees a second
    assert angle(looked.at(5 * MS).gaze) == pytest.approx(0.4, abs=1e-4)  # a chord's middle is the arc's
    assert angle(looked.at(19 * MS).gaze) == pytest.approx(0.8)
    assert angle(looked.at(20 * MS).gaze) == pytest.approx(9)
    assert angle(looked.at(10_000 * MS).gaze) == pytest.approx(9.2)


def test_a_blink_and_a_gap_hold_what_was_seen_before():
    looked = track([NONE, towards(1), NONE, NONE, towards(1.5)])
    assert looked.at(0).gaze is None and looked.at(-5).gaze is None
    for ms in (10, 15, 25, 39):
        assert angle(looked.at(ms * MS).gaze) == pytest.approx(1)
    assert angle(track([towards(1), towards(1.1)], max_gap_ns=MS).at(5 * MS).gaze) == pytest.approx(1)


def test_a_track_without_gaze_has_none_and_other_samples_lose_it():
    plain = PoseTrack([0, 1], np.zeros((2, 3)), [[0, 0, 0, 1]] * 2)
    assert plain.at(0).gaze is None and plain.gaze_at(1) is None
    looked = track([towards(0)] * 3)
    assert looked.evolve(name="b").gaze is not None
    assert looked.evolve(time_ns=[0], position_m=np.zeros((1, 3)), orientation_xyzw=[[0, 0, 0, 1]]).gaze is None


@pytest.mark.parametrize("wrong", [[[0, 0, 0]], [[0, math.nan, 1]], [[1, 0]], [[0, 0, 1]] * 2])
def test_what_is_no_direction_is_refused(wrong):
    with pytest.raises(TraceError, match="gaze"):
        PoseTrack([0], np.zeros((1, 3)), [[0, 0, 0, 1]], gaze=np.array(wrong, float))


def test_eyes_that_rest_on_something_are_known_there_however_the_head_turns():
    """The head turns to the left by 150 degrees a second, and the eyes against it."""
    turns = Rotation.from_euler("y", 1.5 * np.arange(20)[:, None], degrees=True)
    eyes = turns.inv().apply(towards(3))
    resting = track(eyes).evolve(orientation_xyzw=turns.as_quat())
    for number in (10, 15):
        head = Pose((0, 0, 0), turns[number].as_quat())
        assert known_gaze(resting, 100 * MS, head) == pytest.approx(eyes[number], abs=1e-9)


@pytest.mark.parametrize("method", predictors.names())
@pytest.mark.parametrize("now", [-5 * MS, 3 * MS, 500 * MS, 707 * MS])
def test_a_predicted_head_looks_where_the_eyes_last_did(method, now):
    """In the world, at the last sample that is known; nowhere before the first."""
    seen = with_eyes(synthesise("look-around", seconds=1))
    predicted, last = predict(seen, now, now + 80 * MS, method), max(seen.index_at(now), 0)
    if now < 0:
        assert predicted.gaze is None
        return
    known = seen.pose(last).rotation_matrix @ seen.gaze[last]
    assert predicted.pose.rotation_matrix @ predicted.gaze == pytest.approx(known, abs=1e-9)


def test_a_native_file_has_it_bit_for_bit_and_0_where_it_is_not_known(tmp_path):
    made = with_eyes(synthesise("look-around", seconds=2))
    gaze = made.gaze.copy()
    gaze[40:60] = np.nan
    made, text = made.evolve(gaze=gaze), io.StringIO()
    formats.get("native").write(made, text)
    (tmp_path / "a.csv").write_text(text.getvalue(), encoding="utf-8")
    loaded = load_trace(tmp_path / "a.csv")
    assert np.array_equal(loaded.track.gaze, gaze, equal_nan=True)
    assert [d.count for d in loaded.defects if d.kind == "gaze-lost"] == [20]
    assert "gaze: gaze_x, gaze_y, gaze_z" in loaded.columns
    formats.get("native").write(made.evolve(gaze=None), text := io.StringIO())
    assert "gaze_x" not in text.getvalue()


def test_eyenavgs_has_the_turn_of_the_gaze_in_the_world(tmp_path):
    """In the head's axes it is what the head's own turn leaves; no turn at all is a lost eye."""
    names = (
        "ViewIndex,FOV1,FOV2,FOV3,FOV4,PositionX,PositionY,PositionZ,QuaternionX,QuaternionY,QuaternionZ,QuaternionW"
    )
    rows, heads, eyes = [], [], []
    rng = np.random.default_rng(1)
    for n in range(20):
        head = Rotation.from_euler("yxz", [40 + 2 * n, 10, 5], degrees=True)
        eye = Rotation.from_euler("yx", rng.uniform(-20, 20, 2), degrees=True)
        turn = (head * eye).as_quat() if n != 7 else np.array([0.0, 0, 0, 1])
        heads.append(head), eyes.append(eye.apply([0, 0, -1]))
        numbers = [0, -1, 1, -1, 1, 0, 1.6, 0, *head.as_quat(), 0, 0, 0, *turn, 20 * n]
        rows.append(",".join(map(repr, map(float, numbers))))
    header = f"{names},GazePosX,GazePosY,GazePosZ,GazeQX,GazeQY,GazeQZ,GazeQW,Timestamp"
    (tmp_path / "user1.csv").write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    found = load_trace(tmp_path / "user1.csv").track.gaze
    known = np.arange(20) != 7
    assert np.allclose(found[known], np.array(eyes)[known], atol=1e-12) and np.isnan(found[7]).all()
