"""A study over recorded frames: planned, run by simulated people, and measured."""

from __future__ import annotations

import pytest
from recorded_folders import taken, write_npz

from hmdwarp.errors import InputError
from hmdwarp.metrics import QUALITY
from hmdwarp.run import RunOptions, measured
from hmdwarp.study import MeasureOptions, measure_study
from hmdwarp.study.design import load_design
from hmdwarp.study.session.program import run_session
from hmdwarp.study.session.session_options import SessionOptions
from hmdwarp.study.store import Store

from .plans import text_of

PLAN = text_of("recorded")


@pytest.fixture
def plan(tmp_path):
    (tmp_path / "walk-past").mkdir()
    write_npz(tmp_path / "walk-past", taken(12, (60, 40)))
    path = tmp_path / "recorded.toml"
    path.write_text(PLAN, encoding="utf-8")
    return path


def test_a_session_shows_them_and_each_trial_is_measured(plan, tmp_path):
    """The trial is as a replay over the camera's own head, as old as its frames really were."""
    said = {"study": str(plan), "participant": "P1", "pilot": True, "source": "offscreen", "console": "none"}
    options = SessionOptions.of({**said, "simulate": "quick", "store": tmp_path / "data"})
    session = run_session(options)
    assert session.status == "complete"
    with Store(tmp_path / "data") as store:
        found = measure_study(store, MeasureOptions(every=2, workers=0, pilot=True))
        assert (found.measured, found.left_out) == (2, ())
        shown = {showing.condition: showing for showing in store.contents(pilot=True).showings if showing.complete}
    assert {showing.actual["headset"] for showing in shown.values()} == {"camera"}
    late, warped = (shown[name].measured for name in ("late", "warped"))
    assert warped["psnr_db"] > late["psnr_db"] + 3
    plain = RunOptions.of(
        {"frames": tmp_path / "walk-past", "guard": "1.5", "warp": "none", "fill": "none", "against": ""},
        latency_ms=late["latency_ms"], seconds=shown["late"].actual["seconds"], metrics_every=2, workers=0, images=0,
    )  # fmt: skip
    expected = measured(plain).summary["quality"]
    assert {name: late[name] for name in QUALITY} == {name: expected[name]["mean"] for name in QUALITY}


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"walk-past"', '"nowhere"', "no such file or folder"),
        ("latency = 100, warp", "guard = 2, latency = 100, warp", "is the same for all conditions"),
        ("[trial]", 'lens = "radial"\n[trial]', "lens radial with frames"),
    ],
)
def test_unshowable_frames_are_refused_in_the_plan(plan, old, new, told):
    plan.write_text(PLAN.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=told):
        load_design(str(plan))


def test_only_recorded_frames_bring_a_head_of_their_own(tmp_path):
    alone = SessionOptions(study="quick", participant="P1", source="offscreen", pilot=True, store=tmp_path / "store")
    with pytest.raises(InputError, match="name a recorded one by --trace"):
        run_session(alone)
    assert not (tmp_path / "store").exists()
