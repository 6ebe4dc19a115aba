"""What participants do in trials whose scene reacts, or does not."""

from __future__ import annotations

import numpy as np
import pytest
from replays import each_refresh
from run.test_inputs import looking_at
from scipy.spatial.transform import Rotation

from hmdwarp.display import MOVED, Command
from hmdwarp.geometry import Pose
from hmdwarp.gpu import download
from hmdwarp.scenes import inputs_beside, load_scene, read_inputs
from hmdwarp.study import MeasureOptions
from hmdwarp.study.dialogs.dialog_panels import MessagePanel
from hmdwarp.study.measure import run_options

from . import sessions
from .sessions import Person, SeatedDisplay, contents, run, study

UNTIL_DONE = 'seconds = "until done"\nlongest = 3'
CHANGES = [('"48x60"', '"48x40"'), ("= 130", "= 20"), ("= 170", "= 30"), ('"rotation"', '"none"')]
MORE = 'lens = "none"\npredict = "none"\nguard = 1.0\nclient_motion = "held"'
# By the number of the picture: with keys or a mouse, and with a controller whose trigger acts and
# confirms at once, in a hand that points at a thing, or aside.
BY_KEYS = {3: ["push"], 9: ["grab"], 20: ["grab"]}
BY_HAND = {
    3: ["confirm", ("push", True, "at")],
    6: ["confirm", ("grab", True, "at")],
    8: [("grab", MOVED, "aside")],
    9: [("grab", False, "aside")],
    14: [("grab", MOVED, "aside"), "confirm"],
}


class Acting(Person):
    """Acts in so many trials. thing: what a hand points at."""

    def __init__(self, acts: dict[int, list], trials: int = 2, thing: str = "ball") -> None:
        super().__init__()
        self._acts, self._trials, self._pictures = acts, trials, 0
        eye = np.array((0.2, 1.4, -0.3))
        way = load_scene("playroom").inputs.things[thing].handle(0) - eye
        turn = Rotation.align_vectors([way / np.linalg.norm(way)], [[0, 0, -1]])[0].as_quat()
        self._hands = {name: Pose(eye + (aside, 0, 0), turn) for name, aside in (("at", 0), ("aside", 0.1))}

    def looks(self, panel):
        if panel == "":
            self._pictures += 1
            acts = self._acts.get(self._pictures, ()) if self._trials > 0 else ()
            return [
                Command(act) if isinstance(act, str) else Command(act[0], act[1], hand=self._hands[act[2]])
                for act in acts
            ]
        self._trials -= self._pictures > 0
        self._pictures = 0
        return super().looks(panel)


class Watched(SeatedDisplay):
    """What each refresh shows, by its instant; the head looks at a ball, then away."""

    def __init__(self, *args, **more) -> None:
        track = looking_at((0.0, "ball"), (0.2, "ball"), (0.5, "door"), (2.0, "door"))
        super().__init__(*args, **more, track=track, size=(48, 40))
        self.seen: dict[int, np.ndarray] = {}

    def show(self, refresh, label="") -> int:
        if refresh is not None:
            self.seen[refresh.shown_ns] = download(refresh.eyes[0].shown.texture)
        return super().show(refresh, label)


@pytest.fixture
def acted(monkeypatch, gpu, tmp_path):
    """Runs two trials, 20 and 30 ms late, whose client knows no more than has arrived."""

    def act(person: Person, scene: str = "playroom", seconds: str = "seconds = 0.3"):
        monkeypatch.setattr(sessions, "SeatedDisplay", Watched)
        path = study(tmp_path)
        text = path.read_text(encoding="utf-8")
        for found, put in [*CHANGES, ('"planes"', f'"{scene}"\n{MORE}'), ("seconds = 0.1", seconds)]:
            text = text.replace(found, put)
        path.write_text(text, encoding="utf-8")
        ran = run(monkeypatch, gpu, path, person=person)
        assert ran.error is None and ran.session.status == "complete", ran.error
        return ran, contents(path)

    return act


def done_in(stored, showing) -> list:
    return read_inputs(inputs_beside(stored.folder / "traces" / showing.trace))


def test_what_participants_do_in_a_trial_is_kept_and_repeats_it_bit_for_bit(acted):
    """In the second trial they do nothing, and nobody had been there before."""
    ran, stored = acted(Acting(BY_KEYS, trials=1))
    first, second = stored.showings
    done = [event.action for event in done_in(stored, first)]
    assert [what for number, what in enumerate(done) if what not in done[:number]] == ["push", "grab", "release"]
    assert first.actual["inputs"] == 3 and second.actual["inputs"] == 0
    # Drawn within a refresh of 10 ms, and shown the latency later.
    late_ms = first.settings["latency"]
    assert late_ms <= first.actual["input_response_ms_mean"] <= first.actual["input_response_ms_p95"] <= late_ms + 10
    assert second.actual["input_response_ms_mean"] is None
    assert not inputs_beside(stored.folder / "traces" / second.trace).exists()
    for showing in (first, second):
        again = {}
        each_refresh(
            run_options(showing, ran.session, stored.folder / "traces", MeasureOptions(workers=0)),
            lambda setup, number, refresh, again=again: again.update(
                {refresh.shown_ns + setup.trace.track.epoch_ns: download(refresh.eyes[0].shown.texture)}
            ),
        )
        both = [at_ns for at_ns in again if at_ns in ran.display.seen]
        assert len(both) > 20
        for at_ns in both:
            np.testing.assert_array_equal(again[at_ns], ran.display.seen[at_ns], err_msg=f"{showing.trial}: {at_ns}")
        # While the head is still, nothing moves but by them.
        still = [again[at_ns].tobytes() for at_ns in sorted(both)[:7]]
        assert (len({*still}) > 1) == (showing is first)
    panels = [panel.hint for panel in ran.display.panels if isinstance(panel, MessagePanel) and "Trial" in panel.title]
    assert panels and all("Z or left mouse button: push" in hint for hint in panels)


@pytest.mark.parametrize(("thing", "does"), [("ball", ["push", "grab", "grab", "release"]), ("lamp", ["push"])])
def test_by_controllers_people_act_in_a_trial_and_end_it_by_another_button(acted, thing, does):
    """A lamp takes a push too; nothing that acts confirms."""
    _, stored = acted(Acting(BY_HAND, thing=thing), seconds=UNTIL_DONE)
    for showing in stored.showings:
        done = done_in(stored, showing)
        assert [event.action for event in done] == does
        assert {event.target for event in done} == {thing}
        assert showing.actual["ended_by"] == "participant" and showing.actual["pictures"] >= 14


def test_where_nothing_reacts_a_trigger_confirms_and_nothing_is_said(acted):
    ran, stored = acted(Acting(BY_HAND), "planes", UNTIL_DONE)
    assert [showing.actual["ended_by"] for showing in stored.showings] == ["participant"] * 2
    assert not any("does not react" in line for line in ran.console.said)
    assert all(showing.actual["pictures"] < 6 for showing in stored.showings)


def test_the_console_says_once_a_trial_that_a_scene_does_not_react(acted):
    ran, stored = acted(Acting(BY_KEYS), "planes")
    assert sum("does not react to what people do" in line for line in ran.console.said) == 2
    assert [showing.actual["inputs"] for showing in stored.showings] == [0, 0]
    assert not any("push" in getattr(panel, "hint", "") for panel in ran.display.panels)
