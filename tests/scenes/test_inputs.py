"""Scenes that react: what follows from inputs, whenever they come, from file, seed or hand."""

from __future__ import annotations

import attrs
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmdwarp.base import InputError
from hmdwarp.scenes import (
    ArrivedState,
    Bouncing,
    Hinged,
    InputBook,
    InputEvent,
    InputLog,
    Switched,
    as_arrived,
    load_scene,
    read_inputs,
    scenes,
    take_inputs,
)

MS = 1_000_000
ROOM = ((-2.0, 0.0, -3.0), (2.0, 2.5, 1.0))
RADIUS_M = 0.1
LEVEL = st.floats(-1, 1).filter(lambda value: abs(value) > 0.01)
WAYS = st.tuples(LEVEL, LEVEL, LEVEL)
HANDS = st.tuples(st.floats(-1, 1), st.floats(1, 2), st.floats(-1, 1))


@st.composite
def acted(draw, actions=("push", "grab", "release"), target="ball"):
    """Inputs to one thing, in order."""
    times = sorted(draw(st.lists(st.integers(0, 6_000 * MS), min_size=1, max_size=8)))
    return [InputEvent(at, draw(st.sampled_from(actions)), target, draw(HANDS), draw(WAYS)) for at in times]


def ball_after(events) -> Bouncing:
    log = InputLog()
    ball = Bouncing("ball", log, (0.2, -1.0), RADIUS_M, ROOM)
    for event in events:
        log.add(event)
    return ball


def door_after(events) -> Hinged:
    log = InputLog()
    door = Hinged("door", log, (-1.0, 1.0, -3.0), (0.8, 0.5, 0.0))
    for event in events:
        log.add(event)
    return door


def bits(motion, time_ns):
    state = motion.state(time_ns)
    return state.pose.matrix().tobytes() + state.velocity_m_s.tobytes() + state.angular_velocity_rad_s.tobytes()


@given(acted())
def test_a_ball_stays_in_its_room_and_moves_as_its_speed_says(events):
    """Over 1 ms, its way is its speed's, within what pull and one bounce of 8 m/s can change."""
    ball, low, high = ball_after(events), np.array(ROOM[0]) + RADIUS_M, np.array(ROOM[1]) - RADIUS_M
    for time_ns in range(0, 9_000 * MS, 411 * MS):
        now, then = ball.state(time_ns), ball.state(time_ns + MS)
        assert (now.pose.position_m >= low - 1e-9).all() and (now.pose.position_m <= high + 1e-9).all()
        # A hand may throw it at FOLLOWS times the room's diagonal, 5.1 m: 62 m/s; flight ends at 8.
        assert np.linalg.norm(then.pose.position_m - now.pose.position_m) <= 62e-3


def test_a_bounce_keeps_the_share_of_speed_and_the_ball_comes_to_rest():
    ball = ball_after([InputEvent(0, "push", "ball", direction=(0.0, 0.0, 1.0))])
    lift, pull = Bouncing.LIFT_M_S, 9.81
    lands_ns = round(2 * lift / pull * 1e9)
    assert ball.state(lands_ns - MS).velocity_m_s[1] == pytest.approx(-lift, abs=0.02)  # 1 ms of pull is 0.0098
    assert ball.state(lands_ns + MS).velocity_m_s[1] == pytest.approx(Bouncing.RESTITUTION * lift, abs=0.02)
    top_m = ball.state(lands_ns // 2).pose.position_m[1] - RADIUS_M
    assert top_m == pytest.approx(lift**2 / (2 * pull), abs=1e-6)
    rest = ball.state(30_000 * MS)
    assert not rest.velocity_m_s.any() and not rest.angular_velocity_rad_s.any()
    assert rest.pose.position_m[1] == RADIUS_M
    assert bits(ball, 30_000 * MS) == bits(ball, 40_000 * MS)


def test_a_held_ball_is_predicted_on_its_way_to_the_hand():
    """What acceleration leaves out in 10 ms is 3e-4 of the way: (FOLLOWS t)^3 / 6."""
    ball = ball_after([InputEvent(0, "grab", "ball", (0.0, 1.6, 0.5), (0.3, -0.2, -1.0))])
    now, then = (ball.state(time_ms * MS) for time_ms in (50, 60))
    assert np.linalg.norm(now.velocity_m_s) > 1
    assert np.linalg.norm(now.after(10 * MS).position_m - then.pose.position_m) < 1e-3


@pytest.mark.parametrize("after", [ball_after, door_after])
@given(data=st.data())
def test_what_comes_late_or_on_another_clock_gives_the_same_bits(after, data):
    """States are read in between, so that what was kept of them would show."""
    target = {ball_after: "ball", door_after: "door"}[after]
    events = data.draw(acted(target=target))
    at_ns = data.draw(st.integers(0, 9_000 * MS))
    expected = bits(after(events), at_ns)
    late = after([])
    # Equal instants keep the order in which they came.
    order = data.draw(st.permutations(sorted({event.time_ns for event in events})))
    for time_ns in order:
        for event in events:
            if event.time_ns == time_ns:
                late._log.add(event)
                late.state(at_ns)
    assert bits(late, at_ns) == expected
    ahead_ns = 10**15 + 7
    moved = [attrs.evolve(event, time_ns=event.time_ns + ahead_ns) for event in events]
    assert bits(after(moved), at_ns + ahead_ns) == expected


@given(acted(target="door"))
def test_a_door_keeps_within_its_stops(events):
    door = door_after(events)
    for time_ns in range(0, 8_000 * MS, 397 * MS):
        turn = door.state(time_ns).pose.rotation.as_rotvec()
        assert -Hinged.WIDEST_RAD - 1e-9 <= turn[1] <= 1e-9 and not turn[[0, 2]].any()


def test_a_door_comes_under_the_hand_and_stays_where_it_is_let_go():
    hand = (-1.0 + 0.8 * np.cos(1.0), 1.5, -3.0 + 0.8 * np.sin(1.0))  # where the grip is at 1 rad
    origin = (0.0, 1.5, 0.0)
    reach = np.linalg.norm(np.array((-0.2, 1.5, -3.0)) - origin)
    way = np.array(hand) - origin
    assert np.linalg.norm(way) != pytest.approx(reach, abs=0.1)  # the hand has to come nearer, along its ray
    grabs = [InputEvent(0, "grab", "door", origin, tuple(way)), InputEvent(2_000 * MS, "release", "door")]
    door, aimed = door_after(grabs), np.array(origin) + reach * way / np.linalg.norm(way) - (-1.0, 1.0, -3.0)
    expected = np.arctan2(aimed[2], aimed[0])
    # Of the way to the hand exp(-FOLLOWS * 2) is left after 2 s: 4e-11.
    assert -door.state(2_000 * MS).pose.rotation.as_rotvec()[1] == pytest.approx(expected, abs=1e-9)
    assert -door.state(5_000 * MS).pose.rotation.as_rotvec()[1] == pytest.approx(expected, abs=1e-8)


@given(st.lists(st.tuples(st.integers(0, 100), st.sampled_from(["switch", "push"])), max_size=20), st.integers(0, 100))
def test_a_lamp_is_as_often_switched_as_its_switch_is_switched_or_pushed(done, at_ns):
    log = InputLog()
    lamp = Switched("lamp", log, (0, 1, 0))
    for number, (time_ns, action) in enumerate(done):
        log.add(InputEvent(time_ns, action, "lamp", (float(number), 0.0, 0.0)))
    assert lamp.share(at_ns) == (1 + sum(time_ns <= at_ns for time_ns, _ in done)) % 2


def test_the_same_input_twice_counts_once():
    log = InputLog()
    lamp = Switched("lamp", log, (0, 1, 0))
    for _ in range(2):
        log.add(InputEvent(5, "switch", "lamp"))
    assert len(log) == 1 and lamp.share(5) == 0


def test_a_ray_means_what_it_points_at_and_takes_the_action():
    log, eye = load_scene("playroom").inputs, np.array((0.0, 1.6, 0.5))
    for name, thing in log.things.items():
        way = thing.handle(0) - eye
        for action in ("push", "switch", "grab"):
            found = log.add(InputEvent(0, action, "", tuple(eye), tuple(way)))
            assert (found is not None and found.target == name) == (action in thing.takes)
        away = log.add(InputEvent(0, thing.takes[0], "", tuple(eye), tuple(-way)))
        assert away is None
        # What a hand holds it grabs again, and releases, wherever it points; it holds one thing.
        for action in ("grab", "release"):
            found = log.add(InputEvent(0, action, "", tuple(eye), (0.0, 1.0, 0.0)))
            assert (found is not None and found.target == name) == ("grab" in thing.takes)


def test_a_push_means_the_thing_nearest_to_its_ray_the_lamp_too():
    log, eye = load_scene("playroom").inputs, np.array((0.0, 1.6, 0.5))
    ways = {name: thing.handle(0) - eye for name, thing in log.things.items()}
    # The lamp's switch is 15 degrees from the door: between them both are meant.
    between = {name: InputEvent(0, "push", "", tuple(eye), tuple(ways[name] + 0.2 * ways["lamp"])) for name in ways}
    assert {name: log.add(event).target for name, event in between.items()} == {name: name for name in ways}
    assert log.add(InputEvent(0, "push", "", tuple(eye), (0.0, 1.0, 0.0))) is None


def test_each_book_is_a_history_of_its_own():
    scene = load_scene("playroom")
    log, moment, seen = scene.inputs, 900 * MS, {}
    for book in (mine := InputBook(), other := InputBook(), mine, other):
        log.book = book
        if book is mine and not len(book):
            log.add(InputEvent(0, "push", "ball"))
            log.add(InputEvent(0, "switch", "lamp"))
        now = scene.bodies[0].motion.state(moment).pose.matrix().tobytes(), scene.lamps[0].light(moment)
        assert seen.setdefault(id(book), now) == now
    assert len(set(seen.values())) == 2 and (len(mine), len(other)) == (2, 0)


def test_each_loaded_scene_has_inputs_of_its_own():
    first, second = load_scene("playroom"), load_scene("playroom")
    first.inputs.add(InputEvent(0, "switch", "lamp"))
    assert first.lamps[0].light(1) == (0, 0, 0) and second.lamps[0].light(1) == second.lamps[0].colour
    assert [name for name in scenes.names() if load_scene(name).inputs is not None] == ["playroom"]


def test_what_has_arrived_knows_no_later_input():
    scene = load_scene("playroom")
    scene.inputs.add(InputEvent(100 * MS, "switch", "lamp"))
    scene.inputs.add(InputEvent(100 * MS, "push", "ball"))
    for extrapolates in (False, True):
        arrived = ArrivedState(extrapolates, 99 * MS)
        known = as_arrived(scene, arrived)
        assert known.lamps[0].light(500 * MS) == scene.lamps[0].colour
        assert np.array_equal(
            known.bodies[0].motion.state(500 * MS).pose.matrix(), scene.bodies[0].motion.state(0).pose.matrix()
        )
        arrived.take(100 * MS)
        assert known.lamps[0].light(500 * MS) == (0, 0, 0)


def of_seed(seed: int, end_ns: int) -> list[InputEvent]:
    log = load_scene("playroom").inputs
    assert take_inputs(log, f"seed:{seed}", (0, end_ns), 0) == 0
    return list(log)


def test_a_seed_gives_the_same_inputs_whatever_comes_after():
    short, long, other = of_seed(3, 5_000 * MS), of_seed(3, 60_000 * MS), of_seed(4, 60_000 * MS)
    assert short == long[: len(short)] and long != other
    # About 86 in a minute, as of a Poisson process: within four times the root of that.
    assert 86 - 37 < len(long) < 86 + 37
    assert {event.target for event in long} == {"ball", "door", "lamp"}


def test_a_file_gives_the_inputs_that_were_written(tmp_path):
    path, found = tmp_path / "a.csv", of_seed(5, 9_000 * MS)
    header = "time_ns,action,target,x,y,z,dx,dy,dz,response_ms\n"
    rows = [event.row.replace("\n", ",12.5\n") for event in found]
    path.write_text("# by hand\n" + header + "".join(reversed(rows)))
    assert read_inputs(path) == found[::-1]
    log = load_scene("playroom").inputs
    assert take_inputs(log, str(path), (0, 0), -7) == 0
    assert [attrs.evolve(event, time_ns=event.time_ns - 7) for event in log] == found


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "begins with nothing: expected time_ns,action"),
        ("a,b\n", "begins with 'a,b': expected time_ns"),
        ("HEADER1,push,ball,0,0,0,0,0\n", "line 2: '1,push,ball,0,0,0,0,0': 8 values: expected 9"),
        ("HEADER1,kick,ball,0,0,0,0,0,1\n", "line 2: .*unknown action 'kick'"),
        ("HEADER1.5,push,ball,0,0,0,0,0,1\n", "line 2: .*expected whole nanoseconds, an action"),
        ("HEADER1,push,ball,0,0,nan,0,0,1\n", "line 2: .*expected finite numbers"),
        ("HEADER\n1,push,ball,0,0,0,0,0,0\n", "line 3: .*direction of a length from 1e-09"),
        ("HEADER1,push,bell,0,0,0,0,0,1\n", "unknown thing that reacts 'bell': did you mean 'ball'"),
        ("HEADER1,switch,ball,0,0,0,0,0,1\n", "switch 'ball': expected push or grab or release"),
    ],
)
def test_a_bad_file_is_refused_with_its_name_and_place(tmp_path, text, why):
    path = tmp_path / "bad.csv"
    path.write_text(text.replace("HEADER", "time_ns,action,target,x,y,z,dx,dy,dz\n"))
    with pytest.raises(InputError, match=f"bad.csv.*{why}") as error:
        take_inputs(load_scene("playroom").inputs, str(path), (0, 0), 0)
    assert "\n" not in str(error.value)
