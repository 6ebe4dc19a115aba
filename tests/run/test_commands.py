"""Commands in a run that goes on.

What can be is done, what cannot is said over the picture, and a key never gets stuck at it.
"""

from __future__ import annotations

import pytest
from replays import suited

from hmdwarp.client import parse_warp
from hmdwarp.display import CONTROLS, Command
from hmdwarp.headsets import load_headset
from hmdwarp.run import CommandHandler, LiveOptions, PipelineHost
from hmdwarp.run import host as handling
from hmdwarp.run.host import choices

from .offscreen import OffscreenDisplay, run_on

ONE_EYE = "the flat view has one eye"


@pytest.fixture
def flat(gpu):
    """A host that cannot do every warp."""
    with OffscreenDisplay(gpu=gpu, view="flat") as display:
        host = PipelineHost(
            display,
            LiveOptions(scene="planes", headset="rift-dk1", latency_ms=0, warp="forward", fill="none", view="flat"),
        )
        yield host
        host.close()


@pytest.mark.parametrize("back", [False, True])
def test_steps_pass_over_what_cannot_be(flat, back):
    said: list[str] = []
    one, seen = CommandHandler(flat, said.append), []
    still = {spec for spec in choices()["warp"] if parse_warp(spec).entry.name not in suited("planes")}
    for _ in range(len(choices()["warp"]) - 1 - len(still)):
        assert one.handle([Command("warp", back=back)])
        seen.append(flat.options.warp)
    assert sorted(seen) == sorted(set(choices()["warp"]) - {"multi"} - still)
    assert flat.options.warp == "forward"
    assert sum(ONE_EYE in line for line in said) == 1
    assert all(ONE_EYE in line or "its light stands still" in line for line in said)


def test_a_value_that_cannot_be_is_not_replaced_by_another(flat):
    said: list[str] = []
    one = CommandHandler(flat, said.append)
    assert not one.handle([Command("warp", "multi"), Command("guard", 99)])
    assert flat.options.warp == "forward"
    assert len(said) == 2


def test_possible_commands_of_several_are_carried_out(flat):
    one = CommandHandler(flat, lambda text: None)
    assert one.handle([Command("warp", "multi"), Command("latency", 30.0), Command("warp", "backward")])
    assert (flat.options.warp, flat.options.latency_ms) == ("backward", 30)


def test_a_refusal_is_there_until_it_was_read(flat, monkeypatch):
    now = [100.0]
    monkeypatch.setattr(handling.time, "monotonic", lambda: now[0])
    one = CommandHandler(flat, lambda text: None)
    assert one.refusal == ""
    one.handle([Command("warp", "multi")])
    now[0] += handling.READING_S - 0.1
    assert ONE_EYE in one.refusal
    now[0] += 0.2
    assert one.refusal == ""


def test_in_a_run_the_refusal_stands_over_the_pictures_which_go_on(monkeypatch):
    asked = {3: [Command("warp", "multi")], 5: [Command("warp", "backward")]}
    display = OffscreenDisplay(view="flat", asked=asked, keeps=True)
    options = LiveOptions(
        scene="planes", headset="rift-dk1", latency_ms=0, warp="forward", fill="none", view="flat", pictures=8
    )
    run_on(monkeypatch, display, options)
    assert [ONE_EYE in label for label in display.labels] == [False] * 4 + [True] * 4
    assert len(display.said) == 1
    status = display.statuses[-1]
    assert status.values["warp"] == "backward"
    assert ONE_EYE in status.notice
    assert all(picture.any() for picture in display.pictures)


@pytest.mark.parametrize(
    "scene, headset, has",
    [
        ("planes", "rift-dk1", {"lens", "scenes"}),
        ("planes", "quest-3", {"scenes"}),
        ("playroom", "rift-dk1", {"lens", "scenes", "push", "switch", "grab", "release"}),
    ],
)
def test_controls_are_offered_that_scene_and_headset_can_follow(monkeypatch, gpu, scene, headset, has):
    """And another scene's after it was chosen."""
    first, then = ("planes", "playroom") if scene == "playroom" else (scene, scene)
    monkeypatch.setattr("hmdwarp.display.offscreen.load_headset", lambda _: load_headset(headset))
    display = OffscreenDisplay(gpu=gpu, asked={2: [Command("scene", then)]})
    options = LiveOptions(scene=first, headset=headset, latency_ms=0, warp="none", fill="none", samples=1, pictures=4)
    run_on(monkeypatch, display, options)
    assert display.statuses[-1].has == has
    assert [one.name for one in CONTROLS if one.needs and not display.statuses[-1].offers(one)] == [
        one.name for one in CONTROLS if one.needs and one.needs not in has
    ]
