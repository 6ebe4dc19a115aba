"""Motions and deformations: positions agree with velocities, and broken ones are refused."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from hmdwarp.base import SceneError
from hmdwarp.geometry import Pose
from hmdwarp.scenes import Body, Deformation, Mesh, Pendulum, Scene, Spinning, Thrown, Track, Waving, load_scene

S = 1_000_000_000
SQUARE = np.array([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1), (0, 0, 0)], np.float64)
TURNS = Rotation.from_euler("y", np.array([[0.0], [1.5], [3.0], [4.5], [2 * np.pi]]))
MOTIONS = {
    "spinning": Spinning(Pose((1, 2, 3), (0.1, 0.2, 0.3, 0.9)), (1, 2, -2), 4.0),
    "thrown": Thrown(Pose((0, 1, 0)), (1.0, 4.0, -0.5), 1.3, spin_rad_s=(1, -2, 3)),
    "pendulum": Pendulum((0, 2, 0), 1.5, 0.6, 2.0, heading_rad=0.4),
    "track": Track([0, 1, 2.5, 3, 4], SQUARE, TURNS),
    "track, once": Track([0.5, 1, 2.5, 3, 4], SQUARE + np.arange(5)[:, None], TURNS, loops=False),
}


@pytest.mark.parametrize("name", MOTIONS)
@pytest.mark.parametrize("time_ns", [0, 123_456_789, 700 * S // 1000, 2_700_000_000, 3_700_000_000])
def test_a_motion_is_as_fast_as_it_says(name, time_ns):
    """Central differences over 2 x 10 us are off by h^2 / 6 times the third derivative.

    That is far below 1e-5 m/s.
    """
    motion, step = MOTIONS[name], 10_000
    before, now, after = (motion.state(time_ns + k * step) for k in (-1, 0, 1))
    seconds = 2 * step * 1e-9
    if time_ns == 0:  # a loop begins anew here
        before, seconds = now, seconds / 2
    speed = (after.pose.position_m - before.pose.position_m) / seconds
    spin = (after.pose.rotation * before.pose.rotation.inv()).as_rotvec() / seconds
    off = 2e-4 if time_ns == 0 else 1e-5  # one-sided: half a step times the acceleration
    assert np.abs(speed - now.velocity_m_s).max() < off
    assert np.abs(spin - now.angular_velocity_rad_s).max() < 1e-5
    pull = (after.velocity_m_s - before.velocity_m_s) / seconds
    assert np.abs(pull - now.acceleration_m_s2).max() < off


@pytest.mark.parametrize("name", ["spinning", "thrown"])
def test_spinning_and_flying_are_predicted_exactly(name):
    motion = MOTIONS[name]
    for time_ns, age_ns in ((0, S), (200_000_000, 800_000_000), (S, 250_000_000)):
        assert motion.state(time_ns).after(age_ns).isclose(motion.state(time_ns + age_ns).pose)


def test_a_throw_repeats():
    motion = MOTIONS["thrown"]
    assert motion.state(100).pose.isclose(motion.state(1_300_000_100).pose)
    assert motion.state(1_299_999_999).pose.position_m[0] == pytest.approx(1.3)


@pytest.mark.parametrize("begin", [0, 0.5])
def test_a_track_goes_through_its_keys_and_repeats(begin):
    motion = attrs.evolve(MOTIONS["track"], times_s=MOTIONS["track"].times_s + begin)
    for second, place, turn in zip((0, 1, 2.5, 3), SQUARE, TURNS, strict=False):
        for lap in (0, 4, -4):
            state = motion.state(round((begin + second + lap) * S))
            assert state.pose.isclose(Pose(place, turn.as_quat()), 1e-8)


def test_a_track_that_ends_stands_still_there():
    motion = MOTIONS["track, once"]
    for time_ns, key in ((0, 0), (9 * S, 4)):
        state = motion.state(time_ns)
        assert np.allclose(state.pose.position_m, SQUARE[key] + key)
        assert not state.velocity_m_s.any()
        assert not state.angular_velocity_rad_s.any()


def figure() -> Deformation:
    """A skin over joints, of which each turns those below it."""
    return next(mesh.deformation for mesh in load_scene("parade").meshes if mesh.name == "figure-fabric")


def cloth() -> Waving:
    away = np.linspace(0, 1.2, 15)
    rest = np.stack([away, 0 * away, 0 * away], axis=1)
    return Waving(rest, away, (0, 0.3, 1), height_m=0.2, length_m=0.9, period_s=1.4, lag=0.1 * away)


@pytest.mark.parametrize("made", [figure, cloth])
@pytest.mark.parametrize("time_ns", [0, 333_333_333, 5 * S])
def test_a_deformation_is_as_fast_as_it_says(made, time_ns):
    one, step = made(), 10_000
    speed = (one.positions(time_ns + step) - one.positions(time_ns - step)) / (2 * step * 1e-9)
    assert np.abs(speed - one.velocities(time_ns)).max() < 1e-6
    assert np.abs(speed).max() > 0.1


def test_cloth_is_held_at_its_edge():
    one = cloth()
    for time_ns in (0, 200_000_000, 900_000_000):
        assert np.array_equal(one.positions(time_ns)[0], one.rest[0])
    assert np.allclose(one.positions(0), one.positions(1_400_000_000))


def triangle(**settings) -> Mesh:
    ones = np.ones((3, 3))
    return Mesh("triangle", np.eye(3), ones, np.ones((3, 2)), ones, [(0, 1, 2)], **settings)


KEYS = [0, 1, 2, 3, 4]
FAN = [Body("one", MOTIONS["spinning"])]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Track([0, 1, 1, 2, 3], SQUARE), "key 2 is at 1 s, the one before at 1 s: key times must increase"),
        (lambda: Track([0, np.nan, 2, 3, 4], SQUARE), "key 1 is not made of finite numbers"),
        (lambda: Track(KEYS, SQUARE * np.array([1, np.inf, 1])), "key 0 is not made of finite numbers"),
        (lambda: Track([0], SQUARE[:1]), "2 keys at least"),
        (lambda: Track([0, 1, 2], SQUARE), r"\(3,\) key times and \(5, 3\) positions"),
        (lambda: Track(KEYS, SQUARE, TURNS[:4]), "5 key times and 4 turns"),
        (lambda: Track(KEYS, SQUARE + np.arange(5)[:, None]), "the last key of a loop must be the pose of the first"),
        (lambda: Track(KEYS, SQUARE, Rotation.from_rotvec(np.eye(5, 3))), "the last key of a loop"),
        (lambda: Spinning(Pose(), (0, 0, 0), 1.0), "an axis longer than 0"),
        (lambda: Spinning(Pose(), (0, 0, 1), np.nan), "a finite speed"),
        (lambda: Thrown(Pose(), (0, 1, 0), 0.0), "period_s 0.0: expected a time above 0"),
        (lambda: Thrown(Pose(), (0, np.nan, 0), 1.0), "three finite numbers"),
        (lambda: attrs.evolve(cloth(), away=np.ones(3)), "15 points and distances of shape"),
        (lambda: attrs.evolve(cloth(), period_s=0.0), "period 0 s: expected both above 0"),
        (lambda: attrs.evolve(cloth(), out=(0, 0, 0)), "longer than 0"),
        (lambda: Scene("bent", "", [triangle(body=2)], bodies=FAN), "'triangle' belongs to body 2, the scene has 1"),
        (lambda: triangle(body=1, deformation=cloth()), "belongs to body 1 and deforms by itself: expected only one"),
    ],
)
@pytest.mark.filterwarnings("ignore:invalid value")  # inf * 0 in making the broken key
def test_what_cannot_move_is_refused(make, message):
    with pytest.raises(SceneError, match=message):
        make()
