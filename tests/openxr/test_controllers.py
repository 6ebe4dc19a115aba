"""Controllers of a real runtime: what is pressed becomes commands, once.

After a reconnection too.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from display.virtual_screen import until
from scipy.spatial.transform import Rotation

from hmdwarp.display import CONTROLS, Command, DisplayOptions, Lost
from hmdwarp.display.openxr import OpenXrDisplay
from hmdwarp.display.openxr.runtime import State
from hmdwarp.geometry import Pose
from hmdwarp.scenes import inputs_beside, load_scene, read_inputs
from hmdwarp.study.dialogs.dialog_panels import ACTING_CONTROLS
from hmdwarp.study.dialogs.dialog_panels import CONTROLS as STUDY_CONTROLS

from .live_runs import SMALL, Here, quick
from .remote_head import RemoteHead

pytestmark = pytest.mark.usefixtures("no_screen")


PERIOD_NS = 50_000_000  # of the runtime, 20 frames a second


places = itertools.count()


def hold(remote: RemoteHead, display: OpenXrDisplay, hand: str, **states: float) -> None:
    """Set buttons and axes of a hand, and wait until the runtime has them.

    A new place of the head goes after them on the same connection: once the runtime reports it, it
    has them too.
    """
    place = Pose((0.0, 1.6 + 0.001 * next(places), 0.0))
    remote.hold(hand, **states)
    remote.put(place)
    until(lambda: display.source.head_at(display.now_ns()).pose.isclose(place, 1e-4), "the states")


class Controllers:
    """The display and both controllers, which are connected from now on.

    What is held goes by frames as if each took PERIOD_NS, so that a busy machine changes nothing.
    real_ns: the times that the display took for them.
    """

    def __init__(self, display: OpenXrDisplay, remote: RemoteHead) -> None:
        self.display, self._remote = display, remote
        self.real_ns: list[int] = []
        sync = display._connection.actions.sync

        def counted(now_ns: int, shown: int) -> None:
            self.real_ns.append(now_ns)
            sync(len(self.real_ns) * PERIOD_NS, shown)

        display._connection.actions.sync = counted
        for hand in ("left", "right"):
            self.set(hand)
        self.frames(3)

    def set(self, hand: str, **states: float) -> None:
        hold(self._remote, self.display, hand, **states)

    def hold(self, hand: str, frames: int = 8, **states: float) -> list[str]:
        """Set these for some frames; return the names of the requests."""
        self.set(hand, **states)
        return [command.control for command in self.frames(frames)]

    def press(self, hand: str, **states: float) -> list[str]:
        """Hold these for some frames, and release them again."""
        pressed = self.hold(hand, **states)
        return pressed + self.hold(hand, **dict.fromkeys(states, 0))

    def frames(self, count: int) -> list[Command]:
        asked: list[Command] = []
        while count:
            if self.display.wait() is not None:
                self.display.show(None)
                count -= 1
            asked += self.display.commands()
        return asked


@pytest.fixture
def controls():
    return STUDY_CONTROLS


@pytest.fixture
def display(monado, controls):
    made = OpenXrDisplay(DisplayOptions(size=SMALL, controls=controls))
    yield made
    made.close()


@pytest.fixture
def hands(display, remote_head):
    return Controllers(display, remote_head)


def test_every_kind_of_controller_is_known_by_these_names(display):
    """A single wrong path in the table would have the whole kind refused."""
    assert display._connection.actions.refused == []


def test_each_button_is_one_command(hands):
    for pressed, asked in ((PRESSED, ["confirm"]), ({"b_click": 1}, ["menu"]), ({"system_click": 1}, [])):
        assert hands.press("left", **pressed) == asked == hands.press("right", **pressed)  # the last is the runtime's
    assert hands.press("right", a_click=1) == ["confirm"]


def test_the_stick_steps_and_goes_on(hands):
    assert hands.press("left", thumbstick_x=0.3) == []
    assert hands.hold("left", frames=9, thumbstick_x=-1) == ["left"]  # the last of them 400 ms after the first
    # The next at 450 ms, then at the first frame after 120 ms each: 600, 750, 900 ms.
    assert [hands.hold("left", frames=1) for _ in range(10)] == [["left"], [], []] * 3 + [["left"]]
    assert hands.hold("left", thumbstick_x=0) == []
    assert hands.hold("right", frames=4, thumbstick_y=1) == ["up"]
    assert hands.hold("right", frames=4, thumbstick_x=0.9, thumbstick_y=0) == ["right"]


def test_held_keys_go_by_the_clock_of_the_display(hands, display):
    hands.real_ns.clear()
    for _ in range(5):
        before_ns = display.now_ns()
        hands.frames(1)
        assert before_ns <= hands.real_ns[-1] <= display.now_ns()
    assert hands.real_ns == sorted(set(hands.real_ns))


def test_after_a_reconnection_they_are_heard_again(display, monado):
    for is_last in (False, True):
        with RemoteHead() as remote:
            hands = Controllers(display, remote)
            assert hands.press("right", a_click=1) == ["confirm"]
        if not is_last:
            monado.kill()
            with pytest.raises(Lost):
                hands.frames(50)
            assert display.commands() == []
            monado.start()
            assert display.reopen()


EYE = np.array((0.2, 1.4, -0.3))
PULLED = {"squeeze_value": 1, "squeeze_force": 1}
LOOSE = dict.fromkeys(PULLED, 0)
PRESSED = {"trigger_click": 1, "trigger_value": 1}
# Where the right hand aims from EYE, and how far it has gone to the right; and its buttons.
DONE: list[tuple[str, float, dict[str, float]]] = [
    ("lamp", 0.0, {}),
    ("lamp", 0.0, PRESSED),
    ("lamp", 0.0, dict.fromkeys(PRESSED, 0)),
    ("ball", 0.0, {}),
    ("ball", 0.0, PULLED),
    ("ball", 0.2, PULLED),
    ("ball", 0.2, LOOSE),
    ("lamp", 0.0, PULLED),  # what cannot be grabbed
    ("door", 0.0, PULLED),  # nor what the hand passes over then
    ("door", 0.0, LOOSE),
    ("door", 0.0, PRESSED),
]


def aimed(name: str, aside_m: float) -> Pose:
    """A hand that points at where a thing was at the start."""
    way = load_scene("playroom").inputs.things[name].handle(0) - EYE
    turn = Rotation.align_vectors([way / np.linalg.norm(way)], [[0, 0, -1]])[0]
    return Pose(EYE + (aside_m, 0, 0), turn.as_quat())


def test_a_live_session_is_acted_in_by_hand(monado, remote_head, monkeypatch, tmp_path):
    """The trigger does what the thing aimed at takes; what is squeezed follows the hand."""
    here, out, left = Here(monkeypatch), tmp_path / "head.csv", list(DONE)

    def after(number: int) -> None:
        if number % 4 or not left:
            return
        name, aside_m, buttons = left.pop(0)
        remote_head.aim("right", aimed(name, aside_m))
        hold(remote_head, here.display, "right", **buttons)

    here.run(quick(scene="playroom", warp="none", record=out, pictures=4 * (len(DONE) + 2)), after)
    done = read_inputs(inputs_beside(out))
    said = [f"{event.action} {event.target}" for event in done]
    assert [what for k, what in enumerate(said) if what not in said[:k]] == [
        "push lamp", "grab ball", "release ball", "push door",
    ]  # fmt: skip
    assert [said.count(what) for what in ("push lamp", "grab ball", "push door")] == [1, 2, 1]
    expected = [aimed(*step) for step in (("lamp", 0.0), ("ball", 0.0), ("ball", 0.2), ("ball", 0.2), ("door", 0.0))]
    for event, pose in zip(done, expected, strict=True):
        # The runtime's numbers are float32, and turned into matrices by quaternions of length 1.
        assert np.allclose(event.origin_m, pose.position_m, atol=1e-5)
        assert np.allclose(event.direction, -pose.rotation_matrix[:, 2], atol=1e-5)


@pytest.mark.parametrize("controls", [ACTING_CONTROLS], ids=["acting"])
def test_in_a_study_whose_scene_reacts_a_trigger_acts_and_confirms_at_once(hands, remote_head):
    """By which a trial knows that it confirms nothing there; A confirms alone."""
    remote_head.aim("right", aimed("lamp", 0.0))
    found = []
    for pressed in (PRESSED, dict.fromkeys(PRESSED, 0), {"a_click": 1}):
        hands.set("right", **pressed)
        found += [asked for asked in (hands.frames(1) for _ in range(8)) if asked]
    assert [[command.control for command in asked] for asked in found] == [["confirm", "push"], ["confirm"]]
    assert [command.hand is not None for command in found[0]] == [False, True]


def test_without_anybodys_attention_nothing_is_asked_for(hands, display):
    """Monado takes the focus away from nobody who is alone: what it answers then is made up."""
    not_focused, actions = 8, display._connection.actions
    assert display._connection.session.state == State.FOCUSED
    actions._calls = lambda name, *more: not_focused if name == "xrSyncActions" else display._calls(name, *more)
    assert hands.hold("right", a_click=1) == []
    actions._calls = display._calls
    assert hands.hold("right", frames=4) == []  # held since then, for somebody else
    assert hands.hold("right", frames=4, a_click=0) == []
    assert hands.hold("right", frames=4, a_click=1) == ["confirm"]


@pytest.mark.parametrize("controls", [tuple(control for control in CONTROLS if not control.buttons)], ids=["none"])
def test_where_no_control_has_a_button_nothing_is_asked(display):
    assert display._connection.actions is None


def test_a_runtime_that_knows_no_such_controllers_is_no_trouble(request, monkeypatch):
    """It refuses their names; the display goes on without them."""
    profiles = {"/interaction_profiles/nobody/nothing": (("confirm", "/user/hand/left/input/x/click"),)}
    monkeypatch.setattr("hmdwarp.display.openxr.actions.PROFILES", profiles)
    display = request.getfixturevalue("display")
    for _ in range(3):
        if display.wait() is not None:
            display.show(None)
    assert display.commands() == []
    assert display._connection.actions.refused == [*profiles]
