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


class Acting(Person):
    """In the first trials: pushes at the 3rd picture, grabs at the 9th, lets go at the 20th."""

    ACTS = {3: "push", 9: "grab", 20: "grab"}

    def __init__(self, trials: int) -> None:
        super().__init__()
        self._trials, self._pictures = trials, 0

    def looks(self, panel):
        if panel == "":
            self._pictures += 1
            at = self.ACTS.get(self._pictures, "") if self._trials > 0 else ""
            return (Command(at),) if at else ()
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


UNTIL_DONE = 'seconds = "until done"\nlongest = 3'
CHANGES = {
    '"96x120"': '"48x40"', "latency = 130": "latency = 20", "latency = 170": "latency = 30", '"rotation"': '"none"',
}  # fmt: skip


def in_the_playroom(folder, scene="playroom", seconds="seconds = 0.3"):
    """Two trials, 20 and 30 ms late, whose client knows no more than has arrived."""
    path, more = study(folder), 'lens = "none"\npredict = "none"\nguard = 1.0\nclient_motion = "held"'
    text = path.read_text(encoding="utf-8")
    for found, put in {**CHANGES, 'scene = "planes"': f'scene = "{scene}"\n{more}', "seconds = 0.1": seconds}.items():
        text = text.replace(found, put)
    path.write_text(text, encoding="utf-8")
    return path


def test_what_participants_do_in_a_trial_is_kept_and_repeats_it_bit_for_bit(monkeypatch, gpu, tmp_path):
    """In the second trial they do nothing, and nobody had been there before."""
    monkeypatch.setattr(sessions, "SeatedDisplay", Watched)
    path = in_the_playroom(tmp_path)
    ran = run(monkeypatch, gpu, path, person=Acting(1))
    assert ran.session.status == "complete", ran.error
    found = contents(path)
    first, second = found.showings
    traces = found.folder / "traces"
    done = [event.action for event in read_inputs(inputs_beside(traces / first.trace))]
    assert [what for number, what in enumerate(done) if what not in done[:number]] == ["push", "grab", "release"]
    assert first.actual["inputs"] == 3 and second.actual["inputs"] == 0
    # Drawn within a refresh of 10 ms, and shown the latency later.
    late_ms = first.settings["latency"]
    assert late_ms <= first.actual["input_response_ms_mean"] <= first.actual["input_response_ms_p95"] <= late_ms + 10
    assert second.actual["input_response_ms_mean"] is None and not inputs_beside(traces / second.trace).exists()
    for showing in (first, second):
        again = {}
        each_refresh(
            run_options(showing, ran.session, traces, MeasureOptions(workers=0)),
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


class ByHand(Person):
    """A controller whose trigger acts and confirms at once: pushes, moves a ball, presses A."""

    def __init__(self, thing: str) -> None:
        super().__init__()
        eye = np.array((0.2, 1.4, -0.3))
        way = load_scene("playroom").inputs.things[thing].handle(0) - eye
        turn = Rotation.align_vectors([way / np.linalg.norm(way)], [[0, 0, -1]])[0].as_quat()
        self._hand, self._aside = (Pose(eye + (aside, 0, 0), turn) for aside in (0, 0.1))
        self._pictures = 0

    def looks(self, panel):
        if panel != "":
            self._pictures = 0
            return super().looks(panel)
        self._pictures += 1
        return {
            3: (Command("confirm"), Command("push", hand=self._hand)),
            6: (Command("confirm"), Command("grab", True, hand=self._hand)),
            8: (Command("grab", MOVED, hand=self._aside),),
            9: (Command("grab", False, hand=self._aside),),
            14: (Command("grab", MOVED, hand=self._aside), Command("confirm")),
        }.get(self._pictures, ())


@pytest.mark.parametrize(("thing", "does"), [("ball", ["push", "grab", "grab", "release"]), ("lamp", ["push"])])
def test_by_controllers_people_act_in_a_trial_and_end_it_by_another_button(monkeypatch, gpu, tmp_path, thing, does):
    """A lamp takes a push too; nothing that acts confirms."""
    monkeypatch.setattr(sessions, "SeatedDisplay", Watched)
    path = in_the_playroom(tmp_path, seconds=UNTIL_DONE)
    ran = run(monkeypatch, gpu, path, person=ByHand(thing))
    assert ran.session.status == "complete", ran.error
    stored = contents(path)
    for showing in stored.showings:
        done = read_inputs(inputs_beside(stored.folder / "traces" / showing.trace))
        assert [event.action for event in done] == does
        assert {event.target for event in done} == {thing}
        assert showing.actual["ended_by"] == "participant" and showing.actual["pictures"] >= 14


def test_where_nothing_reacts_a_trigger_confirms_and_nothing_is_said(monkeypatch, gpu, tmp_path):
    path = in_the_playroom(tmp_path, "planes", UNTIL_DONE)
    ran = run(monkeypatch, gpu, path, person=ByHand("ball"))
    assert [showing.actual["ended_by"] for showing in contents(path).showings] == ["participant"] * 2
    assert not any("does not react" in line for line in ran.console.said)
    assert all(showing.actual["pictures"] < 6 for showing in contents(path).showings)


def test_the_console_says_once_that_a_scene_does_not_react(monkeypatch, gpu, tmp_path):
    monkeypatch.setattr(sessions, "SeatedDisplay", Watched)
    ran = run(monkeypatch, gpu, in_the_playroom(tmp_path, "planes"), person=Acting(2))
    assert sum("does not react to what people do" in line for line in ran.console.said) == 2
    assert [showing.actual["inputs"] for showing in contents(tmp_path / "small.toml").showings] == [0, 0]
    assert not any("push" in getattr(panel, "hint", "") for panel in ran.display.panels)
