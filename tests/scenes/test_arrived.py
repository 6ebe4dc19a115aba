"""A scene by the states that have arrived: held, or continued; never what is still on its way."""

from __future__ import annotations

from contextlib import closing

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from replays import each_refresh, small

from hmdwarp.geometry import Pose
from hmdwarp.gpu import download
from hmdwarp.scenes import (
    REACH_M,
    ArrivedState,
    Body,
    Lamp,
    Scene,
    Spinning,
    Still,
    Thrown,
    Waving,
    as_arrived,
    load_scene,
    swing_seconds,
)
from hmdwarp.sources.server import Server

MS = 1_000_000
BALL = Thrown(Pose((0, 1, 0)), (1.0, 4.0, -0.5), 100.0, spin_rad_s=(1, -2, 3))
WHEEL = Spinning(Pose((1, 2, 3), (0.1, 0.2, 0.3, 0.9)), (1, 2, -2), 4.0)
TIMES = st.integers(0, 10_000 * MS)


def known(extrapolates: bool, *arrivals: int) -> tuple[Scene, ArrivedState]:
    arrived = ArrivedState(extrapolates)
    for arrival in arrivals:
        arrived.take(arrival)
    scene = Scene("two", "", (), bodies=(Body("ball", BALL), Body("wheel", WHEEL)), lamps=(Lamp(BALL, (1, 1, 1)),))
    return as_arrived(scene, arrived), arrived


@given(st.lists(TIMES, min_size=1, max_size=5), TIMES)
def test_held_is_the_newest_state_however_states_come(arrivals, time_ns):
    scene, _ = known(False, *arrivals)
    shown = min(time_ns, max(arrivals))
    for body, motion in zip(scene.bodies, (BALL, WHEEL), strict=True):
        state = body.motion.state(time_ns)
        assert np.array_equal(state.pose.matrix(), motion.state(shown).pose.matrix())
        assert state.velocity_m_s.any() == (motion is BALL and time_ns <= max(arrivals))
    assert np.array_equal(scene.lamps[0].place(time_ns), np.append(BALL.state(shown).pose.position_m, 1))


@given(TIMES, TIMES)
def test_flight_and_spin_are_continued_exactly(arrival, time_ns):
    """Both go on as RigidState.after says, here by the closed form of the motion itself."""
    scene, _ = known(True, arrival)
    for body, motion in zip(scene.bodies, (BALL, WHEEL), strict=True):
        assert body.motion.state(time_ns).pose.isclose(motion.state(time_ns).pose, 1e-6)
        found, expected = body.motion.state(time_ns), motion.state(time_ns)
        assert found.velocity_m_s == pytest.approx(expected.velocity_m_s, abs=1e-6)


@given(st.integers(0, 3_000 * MS), st.integers(0, 2_000 * MS))
def test_vertices_go_on_for_a_short_way(arrival, age_ns):
    parade = load_scene("parade")
    flag = next(mesh for mesh in parade.meshes if isinstance(mesh.deformation, Waving))
    for extrapolates in (False, True):
        arrived = ArrivedState(extrapolates, arrival)
        (mesh,) = (mesh for mesh in as_arrived(parade, arrived).meshes if mesh.name == flag.name)
        start, speed = flag.deformation.positions(arrival), flag.deformation.velocities(arrival)
        way = mesh.deformation.positions(arrival + age_ns) - start
        far = np.linalg.norm(way, axis=1)
        assert far.max() <= REACH_M + 1e-9
        near = far < REACH_M - 1e-9
        expected = speed * swing_seconds(age_ns) if extrapolates else np.zeros_like(speed)
        assert way[near] == pytest.approx(expected[near], abs=1e-9)


def stopped(scene: Scene, known_ns: int, time_ns: int) -> Scene:
    """The scene with each body where its state of one instant takes it by another, at rest."""
    bodies = [Body(body.name, Still(body.motion.state(known_ns).after(time_ns - known_ns))) for body in scene.bodies]
    return attrs.evolve(scene, bodies=bodies)


@pytest.mark.parametrize("name", ["extrapolated", "held"])
def test_a_client_that_draws_shows_what_has_arrived(gpu, name):
    """Bit for bit: drawn by a server of a scene in which all stands still, where it should be."""
    workshop, seen = load_scene("workshop"), []

    def look(setup, number, refresh):
        if number % 7 == 3:
            known_ns = refresh.frame.drawn_ns
            still = stopped(workshop, known_ns, refresh.shown_ns if name == "extrapolated" else known_ns)
            with closing(Server(setup.target.gpu, still, samples=setup.options.samples)) as server:
                image = server.draw(refresh.inputs[0].middle, setup.sizes.shown)
                seen.append(np.array_equal(download(image.colour), download(refresh.eyes[0].shown.texture)))

    each_refresh(small(scene="workshop", warp="model", client_motion=name, seconds=0.5), look)
    assert seen == [True] * len(seen)
    assert len(seen) == 4
