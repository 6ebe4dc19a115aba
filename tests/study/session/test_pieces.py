"""The pieces of a session that can be looked at alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from together import together

from hmdwarp.geometry import Pose
from hmdwarp.poses import Origin, PoseSample
from hmdwarp.study import actual_of
from hmdwarp.study.actual import NOTHING, NUMBERS
from hmdwarp.study.session import program, runner
from hmdwarp.study.session.session_options import SessionOptions
from hmdwarp.study.session.wording import HeadRange

from .conftest import SETTLED_S
from .sessions import closing, run


def test_frames_are_under_way_for_longer_than_any_latency():
    assert runner.first_picture_wait_s([]) == runner.first_picture_wait_s([0.0]) == SETTLED_S
    assert runner.first_picture_wait_s([0.0, 2500.0]) == pytest.approx(2.5 + SETTLED_S)


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


def test_the_options_of_a_session_say_whose_it_is_and_how_it_is_resumed():
    said = {"study": "my study.toml", "participant": "new"}
    assert SessionOptions(**said, pilot=True, simulate="quick").origin == "pilot"
    assert SessionOptions(**said, simulate="quick").origin == "simulated"
    assert SessionOptions(**said).origin == "person"
    options = SessionOptions(**said, store="data here", new_session=True, lsl=True)
    command = "hmdwarp study run 'my study.toml' --participant P7 --resume --lsl --store 'data here'"
    assert options.command("P7", "main", several=False) == command
    assert "--part main" in options.command("P7", "main", several=True)


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
