"""What participants do in trials: targets to find and to select, and things that react."""

from __future__ import annotations

import math

import numpy as np
import pytest
from replays import each_refresh
from run.test_inputs import looking_at
from scipy.spatial.transform import Rotation

from hmdwarp.display import MOVED, Command
from hmdwarp.errors import InputError
from hmdwarp.geometry import Pose
from hmdwarp.gpu import download
from hmdwarp.poses import Origin, PoseSample
from hmdwarp.scenes import inputs_beside, load_scene, read_inputs, with_targets
from hmdwarp.study import MeasureOptions
from hmdwarp.study.analysis.full_analysis import analyse
from hmdwarp.study.analysis.long_table import from_contents
from hmdwarp.study.design import design_as_json, load_design
from hmdwarp.study.dialogs.dialog_panels import MessagePanel
from hmdwarp.study.export.export_rows import answer_rows, long_rows
from hmdwarp.study.measure import run_options
from hmdwarp.study.session.wording import TaskScore
from hmdwarp.study.store.signature import plan_signature

from . import sessions
from .sessions import Person, SeatedDisplay, contents, run, study

TASK = '[task]\nkind = "targets"\ncount = {count}\nsize = {size}\nseed = 3\n'


def with_task(folder, count=2, size=20.0, seconds="0.3", more=""):
    path = study(folder, TASK.format(count=count, size=size) + more)
    path.write_text(path.read_text(encoding="utf-8").replace("seconds = 0.1", f"seconds = {seconds}"), encoding="utf-8")
    return path


def looking(yaw_deg: float, origin: Origin = Origin.MEASURED) -> PoseSample:
    half = math.radians(yaw_deg) / 2
    return PoseSample(0, Pose((0.0, 1.6, 0.0), (0.0, math.sin(half), 0.0, math.cos(half))), origin)


def at(yaw_deg: float) -> tuple[float, float, float]:
    return (-2 * math.sin(math.radians(yaw_deg)), 1.6, -2 * math.cos(math.radians(yaw_deg)))


def test_the_score_of_a_trial_by_hand():
    score = TaskScore(np.array([at(0), at(30), at(33)]), 4.0)
    score.select(0.1)  # no head was seen yet: nothing
    score.add(looking(10))
    score.select(1.0)  # nothing there
    score.add(looking(1))
    score.select(2.0)
    score.select(2.1)  # it is selected already
    score.add(looking(80, Origin.HELD))
    score.add(looking(32))
    score.select(3.0)  # the nearer of two
    assert not score.is_over
    assert score.figures(5.0)["task_target_s"] == pytest.approx(2.5)  # two in five seconds
    score.select(4.0)
    assert score.is_over
    score.add(looking(-90))
    assert score.figures(9.0) == {
        "task_targets": 3,
        "task_found": 3,
        "task_misses": 2,
        "task_target_s": pytest.approx(4 / 3),
        "task_turned_deg": pytest.approx(9 + 31, abs=1e-4),
        "task_times_s": "2.000 3.000 4.000",
    }


@pytest.mark.parametrize("name", ["planes", "room"])
def test_targets_stand_apart_in_sight_and_where_the_seed_says(name):
    scene = load_scene(name)
    found, places = with_targets(scene, 5, 4.0, (3, 1))
    eye = np.array(scene.viewpoint.position_m)
    ways = (places - eye) / np.linalg.norm(places - eye, axis=1, keepdims=True)
    apart = np.degrees(np.arccos(np.clip(ways @ ways.T, -1, 1)))[~np.eye(5, dtype=bool)]
    assert apart.min() > 12
    assert len(found.meshes) == len(scene.meshes) + 5
    for mesh, place, way in zip(found.meshes[-5:], places, ways, strict=True):
        corners = mesh.positions + scene.origin_m - eye
        seen = corners / np.linalg.norm(corners, axis=1, keepdims=True) @ way
        assert np.degrees(np.arccos(seen.min())) == pytest.approx(2.0, abs=0.1)
        assert np.allclose((mesh.positions + scene.origin_m).mean(axis=0), place, atol=0.1)
        assert np.ptp(mesh.light, axis=0).max() == 0  # it shines evenly
    assert (with_targets(scene, 5, 4.0, (3, 1))[1] == places).all()
    assert not np.isclose(with_targets(scene, 5, 4.0, (3, 2))[1], places).any()


class Selecting(Person):
    """Confirms at each new picture, whatever is there."""

    def looks(self, panel):
        return (Command("confirm"),) if panel == "" else super().looks(panel)


def test_a_session_with_a_task_stores_its_score_and_says_it_on_the_next_panel(monkeypatch, gpu, tmp_path):
    path = with_task(tmp_path)
    ran = run(monkeypatch, gpu, path, person=Selecting())
    assert ran.session.status == "complete"
    first, second = (showing.actual for showing in contents(path).showings)
    for showing in (first, second):
        assert showing["ended_by"] == "time"  # a trial with a time keeps to it
        assert showing["task_targets"] == 2 and showing["task_misses"] > 0
        assert showing["task_found"] == len(showing["task_times_s"].split())
    panels = [panel for panel in ran.display.panels if isinstance(panel, MessagePanel) and "Trial" in panel.title]
    assert panels[0].hint == "Find 2 pink balls: bring one to the middle of your view. Enter: select"
    assert panels[-1].hint.startswith(f"{first['task_found']} of 2 found.\nFind 2 pink balls")


def test_the_last_target_ends_a_trial_until_done_and_the_console_can(monkeypatch, gpu, tmp_path):
    from hmdwarp.study.session import trial_runner

    class Easy(trial_runner.TaskScore):
        def __attrs_post_init__(self) -> None:
            super().__attrs_post_init__()
            self.size_deg = 180.0

    monkeypatch.setattr(trial_runner, "TaskScore", Easy)
    path = with_task(tmp_path, seconds='"until done"\nlongest = 5')
    run(monkeypatch, gpu, path, person=Selecting())
    for showing in contents(path).showings:
        assert (showing.actual["ended_by"], showing.actual["task_found"], showing.actual["task_misses"]) == (
            "targets",
            2,
            0,
        )


def test_targets_are_part_of_the_picture(monkeypatch, gpu, tmp_path):
    """The server draws them: the pipeline's own scene has them, and only in trials of the task."""
    from hmdwarp.study.session import trial_runner

    shown = []

    class Kept(trial_runner.PipelineHost):
        def __init__(self, display, options, source) -> None:
            shown.append((options.warp, [mesh.name for mesh in source.scene.meshes if mesh.name.startswith("target-")]))
            super().__init__(display, options, source)

    monkeypatch.setattr(trial_runner, "PipelineHost", Kept)
    path = study(tmp_path, TASK.format(count=2, size=5) + 'conditions = ["spun-about"]\n')
    run(monkeypatch, gpu, path)
    assert sorted(shown) == [("none", []), ("rotation", ["target-0", "target-1"])]
    actual = {showing.condition: showing.actual["task_targets"] for showing in contents(path).showings}
    assert actual == {"plainly-late": None, "spun-about": 2}


def test_the_score_is_exported_and_analysed_with_the_rating(monkeypatch, gpu, tmp_path):
    path = with_task(tmp_path, more='[[family]]\nname = "f"\npairs = [["plainly-late", "spun-about"]]\n')
    for code in ("P1", "P2"):
        run(monkeypatch, gpu, path, person=Selecting(), participant=code)
    stored, design = contents(path), load_design(str(path))
    assert all(row["actual_task_targets"] == 2 for row in long_rows(answer_rows(stored, design)))
    ratings = from_contents(stored, design)
    assert ratings.rated_scales() == ["grade", "task_target_s", "task_misses"]
    misses = {(row.place, row.value) for row in ratings.rows.itertuples() if row.scale == "task_misses"}
    assert misses == {(showing.trial, showing.actual["task_misses"]) for showing in stored.showings}
    found = analyse(ratings)
    assert [scale["measure"]["name"] for scale in found["scales"]] == ratings.rated_scales()
    assert found["ratings"] == 4
    assert found["scales"][2]["comparisons"][0]["n"] == 2


def test_a_plan_s_task_is_checked_kept_and_part_of_its_signature(tmp_path):
    path = with_task(tmp_path, count=4, size=5)
    design = load_design(str(path))
    assert design_as_json(design)["task"] == {"count": 4, "size_deg": 5.0, "seed": 3, "conditions": ()}
    assert plan_signature(design, "main")["task"] == [4, 5.0, 3]
    text = path.read_text(encoding="utf-8")
    for found, put, says in (
        ("count = 4", "count = 90", "task.count is 90, and with a quarter to spare scene 'planes' has room for"),
        ("seed = 3", 'conditions = ["late"]', "task.conditions has 'late': expected some of plainly-late, spun-about"),
        ('"targets"', '"steering"', "task.kind is 'steering': expected targets"),
        ("size = 5", "size = 0", "task.size is 0: expected a number"),
    ):
        path.write_text(text.replace(found, put), encoding="utf-8")
        with pytest.raises(InputError, match=says):
            load_design(str(path))


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


def in_the_playroom(folder, scene="playroom"):
    """Two trials, 20 and 30 ms late, whose client knows no more than has arrived."""
    path, more = study(folder), 'lens = "none"\npredict = "none"\nguard = 1.0\nclient_motion = "held"\n'
    text = path.read_text(encoding="utf-8").replace('scene = "planes"\n', f'scene = "{scene}"\n{more}')
    text = text.replace('"96x120"', '"48x40"').replace("seconds = 0.1", "seconds = 0.3")
    text = text.replace("latency = 130", "latency = 20").replace("latency = 170", "latency = 30")
    path.write_text(text.replace('"rotation"', '"none"'), encoding="utf-8")
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
    path = in_the_playroom(tmp_path)
    text = path.read_text(encoding="utf-8").replace("seconds = 0.3", 'seconds = "until done"\nlongest = 3')
    path.write_text(text, encoding="utf-8")
    ran = run(monkeypatch, gpu, path, person=ByHand(thing))
    assert ran.session.status == "complete", ran.error
    for showing in contents(path).showings:
        done = read_inputs(inputs_beside(contents(path).folder / "traces" / showing.trace))
        assert [event.action for event in done] == does
        assert {event.target for event in done} == {thing}
        assert showing.actual["ended_by"] == "participant" and showing.actual["pictures"] >= 14


def test_where_nothing_reacts_a_trigger_confirms_and_nothing_is_said(monkeypatch, gpu, tmp_path):
    path = in_the_playroom(tmp_path, "planes")
    text = path.read_text(encoding="utf-8").replace("seconds = 0.3", 'seconds = "until done"\nlongest = 3')
    path.write_text(text, encoding="utf-8")
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
