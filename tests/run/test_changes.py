"""What each control does to the options.

A step on and one back, to its bounds and no farther, and nothing that cannot be meant.
"""

from __future__ import annotations

import math

import attrs
import pytest

from hmdwarp.display import CONTROLS, Command, control
from hmdwarp.errors import InputError
from hmdwarp.run import LiveOptions
from hmdwarp.run.host import changed, choices, values
from hmdwarp.scenes import ACTIONS

# What people do in the scene changes no option: tests/run/test_inputs.py.
OURS = [control.name for control in CONTROLS if not control.of_display and control.name not in ACTIONS]
OPTIONS = LiveOptions(scene="room", latency_ms=200, warp="forward", fill="interpolate", guard=1.5)


def test_every_control_of_the_run_has_a_value_and_every_choice_its_words():
    assert set(values(OPTIONS)) == set(OURS)
    assert set(choices()) == {control.name for control in CONTROLS if control.kind == "choice"}
    for name, known in choices().items():
        assert values(OPTIONS)[name] in known
        assert len(set(known)) == len(known) > 1


@pytest.mark.parametrize("name", OURS)
@pytest.mark.parametrize("back", [False, True])
def test_a_step_and_one_back_return(name, back):
    there = changed(OPTIONS, Command(name, back=back))
    assert there != OPTIONS
    assert {other for other in OURS if values(there)[other] != values(OPTIONS)[other]} == {name}
    assert changed(there, Command(name, back=not back)) == OPTIONS


@pytest.mark.parametrize("name", list(choices()))
@pytest.mark.parametrize("back", [False, True])
def test_steps_go_round_through_every_choice(name, back):
    seen, options = [], OPTIONS
    for _ in choices()[name]:
        options = changed(options, Command(name, back=back))
        seen.append(values(options)[name])
    assert sorted(seen) == sorted(choices()[name])
    assert options == OPTIONS


@pytest.mark.parametrize("name", ["latency", "guard"])
@pytest.mark.parametrize("back", [False, True])
def test_numbers_stop_at_their_bounds(name, back):
    options = OPTIONS
    for _ in range(100):
        options = changed(options, Command(name, back=back))
    assert values(options)[name] == control(name).span[0 if back else 1]


def test_a_value_outside_the_list_steps_into_it():
    """Settings of a warp's own, a scene from a file."""
    special = attrs.evolve(OPTIONS, warp="mesh:cut=slope", scene="model.glb")
    for name in ("warp", "scene"):
        assert values(changed(special, Command(name)))[name] in choices()[name]


def test_a_latency_beyond_the_span_comes_back_into_it():
    """The command line allows more than the keys reach."""
    assert changed(attrs.evolve(OPTIONS, latency_ms=9000), Command("latency", back=True)).latency_ms == 2500
    assert changed(attrs.evolve(OPTIONS, guard=5), Command("guard")).guard == 3


TAKEN = [("latency", 333), ("guard", 1.1), ("warp", "mesh:cut=slope"), ("view", "flat"), ("lens", "none")]


@pytest.mark.parametrize(("name", "value"), TAKEN)
def test_a_value_is_taken_as_it_is(name, value):
    assert values(changed(OPTIONS, Command(name, value)))[name] == value


REFUSED = [
    ("latency", -1), ("latency", 1e9), ("latency", math.nan), ("latency", "fast"), ("guard", 0.5), ("guard", 3.5),
    ("guard", "auto"), ("view", "sideways"), ("view", True), ("warp", 3), ("quit", None), ("speed", 1),
]  # fmt: skip


@pytest.mark.parametrize(("name", "value"), REFUSED)
def test_impossible_values_are_refused_by_name(name, value):
    with pytest.raises(InputError, match=name):
        changed(OPTIONS, Command(name, value))
