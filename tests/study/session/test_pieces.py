"""The pieces of a session that can be looked at alone; the stop rule; pages and words."""

from __future__ import annotations

import math
from types import SimpleNamespace

import attrs
import numpy as np
import pytest
from together import together

from hmdwarp.display import Presenter
from hmdwarp.geometry import Pose
from hmdwarp.poses import Origin, PoseSample
from hmdwarp.study import actual_of
from hmdwarp.study.actual import NOTHING, NUMBERS
from hmdwarp.study.design import Condition, Show, Sickness
from hmdwarp.study.dialogs.dialog_panels import PageDialog
from hmdwarp.study.scales import load_scale
from hmdwarp.study.session import program, runner
from hmdwarp.study.session.runner import counting, why_sick
from hmdwarp.study.session.step_handlers import HeadRange
from hmdwarp.study.store import Answer

from .conftest import SETTLED_S
from .sessions import BLUE, RED, closing, picture, run


def test_frames_are_under_way_for_longer_than_any_latency():
    assert runner.first_picture_wait_s([]) == runner.first_picture_wait_s([0.0]) == SETTLED_S
    assert runner.first_picture_wait_s([0.0, 2500.0]) == pytest.approx(2.5 + SETTLED_S)


def test_pictures_begin_with_a_frame_from_after_the_head_started_anew():
    """One that arrived before is of another place of the head, however long ago that was."""
    now_ns, restarts = [0], []
    display = SimpleNamespace(now_ns=lambda: now_ns[0], restart=lambda: restarts.append(now_ns[0]))
    nothing = {"received": lambda *_: [], "tell": lambda *_, **__: None, "begin_step": lambda *_: None}
    context, refresh = SimpleNamespace(display=display, **nothing), SimpleNamespace(head=None)
    trial = runner.TrialHandler(context, Show("trial/1", 1, Condition("late"), 5.0), 0, None, 0.5, None)
    trial.arrived(refresh)  # while the head is where it was
    now_ns[0] = round(runner.LEAD_S * 1e9)
    trial.handle(())
    assert restarts == now_ns
    now_ns[0] += 2_000_000_000
    trial.handle(())
    assert not trial.pictures, "they begin with the frame that arrived before"
    trial.arrived(refresh)
    trial.handle(())
    assert trial.pictures


def columns(**known: list[float]):
    """Columns of a log of three pictures, NaN where nothing is said."""
    return lambda name: np.array(known.get(name.replace("/", "_"), [math.nan] * 3))


def summary(**live) -> dict:
    beside = {"seconds": 0.2, "missed": 1, "over": 1, "timed": 2, "lost": [], "notices": {}, "source": "desktop"}
    texts = dict.fromkeys(("warp", "fill", "scene", "lens", "headset", "hmdwarp"), "x")
    machine = {"gl_renderer": "r", "gl_version": "4.3"}
    texts |= {"machine": machine, "made_with": dict.fromkeys(("commit", "options", "numpy", "moderngl"), "x")}
    return {"frames": 3, "live": {**beside, **live}, "effects": ["a", "b"], "size": [4, 5], **texts}


def test_figures_of_a_trial_by_hand():
    nan = math.nan
    column = columns(
        age_ms=[100, 110, 150], period_ms=[nan, 10, 30], hole_share_0=[0.1, 0.2, nan], hole_share_1=[0.3, 0.4, nan],
        total_ms_0=[1, 2, nan], total_ms_1=[3, 4, nan],
    )  # fmt: skip
    actual = actual_of(summary(lost=[{"away_s": 0.5}, {"away_s": None}], notices={"tracking lost": 1}), column)
    assert set(actual) == set(NOTHING)
    wanted = {
        "pictures": 3, "rate_hz": 10.0, "latency_ms_median": 110.0,
        "latency_ms_sd": pytest.approx(math.sqrt((400 + 100 + 900) / 2)), "period_ms_median": 20.0,
        "missed_share": 0.25, "over_budget_share": 0.5, "hole_share_mean": pytest.approx(0.25),
        "passes_ms_median": 5.0, "pose_age_ms_median": None, "lost_s": 0.5,
        "tracking_lost_share": pytest.approx(1 / 3), "effects": "a+b", "size": "4x5",
    }  # fmt: skip
    assert {name: actual[name] for name in wanted} == wanted


def test_missing_figures_are_none_and_never_nan():
    one = actual_of(summary(seconds=0.0, timed=0), columns(hole_share_0=[0.5, math.nan, math.nan], age_ms=[7.0]))
    assert one["hole_share_mean"] == 0.5
    assert {one[name] for name in ("rate_hz", "latency_ms_sd", "over_budget_share")} == {None}
    actual = actual_of({}, columns())
    assert actual == NOTHING
    assert all(actual[name] is None for name in NUMBERS)
    assert not any(isinstance(value, float) and math.isnan(value) for value in actual_of(summary(), columns()).values())


def test_the_watchdog_s_last_words_tell_the_recording_and_how_to_go_on(monkeypatch, gpu, path):
    """Where a runtime hangs, the program is ended from another thread, and this is all that is
    said.
    """
    words: list[str] = []
    kept: list[program.Watchdog] = []

    class Kept(program.Watchdog):
        def __init__(self, limit_s, last_words) -> None:
            self.last_words = last_words
            super().__init__(limit_s, last_words)
            kept.append(self)

    def hangs() -> None:
        words.extend(say() for say in kept[0].last_words)
        raise closing()

    monkeypatch.setattr(program, "Watchdog", Kept)
    assert run(monkeypatch, gpu, path, at={6: hangs}).session.status == "interrupted"
    (said,) = words
    assert "the recording until then is in" in said
    assert said.endswith(f"resume with: hmdwarp study run {path} --participant P1 --resume --source desktop")


def head(yaw_deg: float, x_m: float = 0.0, origin: Origin = Origin.MEASURED) -> PoseSample:
    half = math.radians(yaw_deg) / 2
    return PoseSample(0, Pose((x_m, 1.6, 0.0), (0.0, -math.sin(half), 0.0, -math.cos(half))), origin)


HEADS = [
    ([head(30), head(32, 0.02), head(28)], 2, 0.02, True),  # sways
    ([head(0), head(-20), head(15)], 20, 0, False),
    ([head(10), head(10, 0.3)], 0, 0.3, False),  # leans or walks
    ([head(0), head(40, 1.0, Origin.HELD)], 0, 0, True),  # lost tracking is no motion
    ([], None, None, None),
]


@together("heads, turn_deg, shift_m, still", HEADS)
def test_a_head_that_hardly_moves_is_flagged(heads, turn_deg, shift_m, still):
    seen = HeadRange()
    for one in heads:
        seen.add(one)
    assert list(seen.figures().values()) == [pytest.approx(turn_deg, abs=1e-5), pytest.approx(shift_m), still]
    assert list(seen.figures()) == ["head_turn_deg", "head_shift_m", "head_still"]


FMS = load_scale("fms")
WORSE_BELOW = attrs.evolve(FMS, low_is_good=False)  # the same with 0 as the worst


def answers(*values: float | None) -> list[Answer]:
    return [
        Answer(trial, 1, f"trial/{trial}/fms/fms", 1, "trial", trial, "fms", "fms", value, 1.0, "participant", "")
        for trial, value in enumerate(values, 1)
    ]


RULES = [  # scale, answers, stop_at, rise, whether the session ends
    (FMS, (), 15, None, False),
    (FMS, (14,), 15, None, False),
    (FMS, (15,), 15, None, True),
    (FMS, (15, 14), 15, None, False),  # one that was corrected at the next question
    (FMS, (None,), 15, None, False),
    (FMS, (15, None), 15, None, True),  # "cannot say" decides nothing
    (FMS, (20,), None, None, False),
    (FMS, (2, 7), None, 5, True),
    (FMS, (2, 6), None, 5, False),
    (FMS, (7, 2), None, 5, False),
    (FMS, (None, 2, 7), None, 5, True),
    (WORSE_BELOW, (5,), 5, 4, True),
    (WORSE_BELOW, (6,), 5, 4, False),
    (WORSE_BELOW, (18, 14), 5, 4, True),
    (WORSE_BELOW, (14, 18), 5, 4, False),
]


@together("scale, values, stop_at, rise, is_sick", RULES)
def test_the_rule_ends_a_session(scale, values, stop_at, rise, is_sick):
    assert bool(why_sick(Sickness(scale, stop_at=stop_at, rise=rise), answers(*values))) is is_sick


def test_answers_after_all_trials_and_other_scales_end_nothing():
    afterwards = attrs.evolve(answers(18)[0], key="after/fms/fms", phase="after", trial=0)
    assert not why_sick(Sickness(FMS, stop_at=15), [*answers(3), afterwards])
    assert why_sick(Sickness(FMS, stop_at=15), [*answers(16), afterwards])
    assert why_sick(None, answers(20)) == ""
    assert why_sick(Sickness(FMS, stop_at=1), [attrs.evolve(answers(20)[0], scale="grade")]) == ""


def test_the_newest_revision_counts_in_the_place_of_the_first():
    first, second = answers(16, 3)
    corrected = attrs.evolve(first, id=3, revision=2, value=1.0)
    assert list(counting([first, second, corrected]).values()) == [corrected, second]
    assert why_sick(Sickness(FMS, rise=2), [first, second, corrected])


def test_a_picture_keeps_its_colours_on_the_display(gpu, tmp_path):
    picture(tmp_path / "p.png")
    panel = PageDialog("Look", picture=str(tmp_path / "p.png")).panel()
    ink = panel.ink()
    assert ink.shape == (panel.height(), 680, 3)
    with gpu.current():
        presenter = Presenter(gpu)
        texture = gpu.gl.texture((1000, 1000), 4)
        framebuffer = gpu.gl.framebuffer([texture])
        presenter.show(None, framebuffer, (0, 0, 1000, 1000), hardware_srgb=False, notice=presenter.notice(panel))
        shown = np.frombuffer(framebuffer.read(components=3), np.uint8).reshape(1000, 1000, 3)
        presenter.close()
        for resource in (framebuffer, texture):
            resource.release()
    for across, wanted in ((0.3, RED), (0.7, BLUE)):
        x, y = round(500 + (across - 0.5) * ink.shape[1]), 500
        # The ground's own light adds 0.008 where a picture is dark: 6 steps at 40.
        assert np.abs(shown[y, x].astype(int) - wanted).max() <= 8, (shown[y, x], wanted)
