"""Measuring afterwards: really replayed, stored, gone on with; what cannot be measured is told."""

from __future__ import annotations

from contextlib import contextmanager

import attrs
import numpy as np
import pytest
from ratings import quiet, with_cvvdp, without_cvvdp
from recorded_folders import taken, write_npz
from replays import CHEAPER, scene_for
from together import together

from hmdwarp.base import InputError
from hmdwarp.experiments.sweep import ClusterOptions
from hmdwarp.metrics import QUALITY
from hmdwarp.poses import load_trace
from hmdwarp.poses.formats import write_native
from hmdwarp.run import RunOptions, measured, replay, set_up_replay
from hmdwarp.study import MeasureOptions, measure_study
from hmdwarp.study.design import Show, design_from_text, load_design, steps_of
from hmdwarp.study.measure import run_options
from hmdwarp.study.session.program import run_session
from hmdwarp.study.session.session_options import SessionOptions
from hmdwarp.study.store import PERSON, Store

from .plans import text_of

TEXT, RECORDED = text_of("measured"), text_of("recorded")
EPOCH_NS = 7_000_000_000_123
OPTIONS = MeasureOptions(every=3, workers=0)


def turned(path, shift_m=(0.0, 0.0, 0.0)):
    """0.6 s of `look-around`, where the head turns, as a display with a clock of its own recorded
    them.
    """
    track = load_trace("look-around").track
    part = slice(*np.searchsorted(track.time_ns, (2_000_000_000, 2_600_000_000)))
    times, positions = track.time_ns[part] + EPOCH_NS, track.position_m[part] + shift_m
    cut = track.evolve(time_ns=times, position_m=positions, orientation_xyzw=track.orientation_xyzw[part], epoch_ns=0)
    with path.open("w", encoding="utf-8") as stream:
        write_native(cut, stream)
    return cut


@contextmanager
def shown(folder, text: str):
    """One session, without its answers; the second trial was broken off first."""
    design = design_from_text(text, "measured.toml")
    with Store(folder / "data", create=True) as made:
        session = made.begin(design, None, "P1", PERSON, facts={"rate_hz": 30.0})
        for step in steps_of(design, session.order, session.part):
            if isinstance(step, Show):
                for complete in (False, True) if step.trial == 2 else (True,):
                    showing = made.begin_showing(session, step, dict(step.condition.settings))
                    turned(made.traces / showing.trace)
                    made.end_showing(session, showing, {"pictures": 18, "size": "96x120"}, complete)
        made.end(session, "complete")
        yield made


@pytest.fixture
def store(tmp_path):
    with shown(tmp_path, TEXT) as made:
        yield made


@pytest.mark.slow(20)
def test_a_condition_shows_each_strategy(tmp_path):
    """What was shown is what is measured: the strategy's warp, fill, light and link."""
    names = ("imposter", "depth_image", "model", "proxy", "views", "irradiance")
    head = TEXT[: TEXT.index("[[condition]]")].replace('scene = "planes"\n', "").replace("= 0.5", "= 0.2")
    conditions = [
        f'[[condition]]\nname = "{name}"\nstrategy = "{CHEAPER.get(name, name)}"\n'
        f'scene = "{scene_for(name)}"\nlatency = 100\n'
        for name in names
    ]
    with shown(tmp_path, head + "".join(conditions)) as store:
        found = measure_study(store, attrs.evolve(OPTIONS, every=9))
        assert (found.measured, found.left_out, found.failed) == (len(names), (), ())
        measured = measured_of(store)
    assert set(measured) == set(names)
    assert all(showing["psnr_db"] > 5 for showing in measured.values())
    assert measured["model"]["flip"] < measured["depth_image"]["flip"] < measured["imposter"]["flip"]


def measured_of(store: Store) -> dict[str, dict]:
    """The figures of each condition, of whole showings; others have none."""
    found = store.contents().showings
    assert [bool(showing.measured) for showing in found] == [showing.complete for showing in found]
    return {showing.condition: showing.measured for showing in found if showing.complete}


def test_every_whole_trial_is_measured_once_and_what_it_finds_is_what_a_replay_finds(store, tmp_path):
    seen, said = [], []
    found = measure_study(store, OPTIONS, lambda done, total: seen.append((done, total)), said.append)
    assert (found.measured, found.known, found.left_out, len(said)) == (3, 0, (), 3)
    assert seen == sorted(seen) and seen[-1] == (54, 54)
    of = measured_of(store)
    # 0.6 s of trace at 30 Hz less the latency of 3 refreshes, every third of them.
    assert [of[name]["refreshes"] for name in ("late", "warped", "reference")] == [5, 5, 6]
    assert of["reference"]["flip"] == 0 and of["reference"]["hole_share"] == 0
    # At 100 ms and this turn the warp of the rotation halves the error (0.33 to 0.16 at another
    # start).
    assert of["late"]["flip"] > 1.5 * of["warped"]["flip"] > 0 and of["late"]["psnr_db"] < of["warped"]["psnr_db"]

    late = next(showing for showing in store.contents().showings if showing.complete and showing.condition == "late")
    plain = RunOptions(
        trace=str(store.traces / late.trace), scene="planes", headset="rift-dk1", latency_ms=100, warp="none",
        fill="none", size=(96, 120), rate_hz=30, metrics_every=3, workers=0, images=0, out=tmp_path / "replay",
    )  # fmt: skip
    quality = replay(plain).summary["quality"]
    assert {name: of["late"][name] for name in QUALITY} == {name: quality[name]["mean"] for name in QUALITY}
    # Known trials are measured again only on request.
    again = measure_study(store, OPTIONS)
    assert (again.measured, again.known) == (0, 3) and "3 were measured before" in again.describe()[0]
    assert measured_of(store) == of
    smaller = attrs.evolve(OPTIONS, size=(48, 60))
    assert measure_study(store, smaller).measured == 3
    assert {one["size"] for one in measured_of(store).values()} == {"48x60"}
    assert measure_study(store, attrs.evolve(smaller, again=True)).measured == 3


def test_both_showings_of_a_trial_are_measured_and_each_has_its_own_figures(tmp_path):
    text = TEXT.replace('scales = ["grade"]', 'scales = ["dcr"]\nshows = "reference first"')
    text = text[: text.index('[[condition]]\nname = "warped"')] + text[text.rindex("[[condition]]") :]
    with shown(tmp_path, text) as store:
        said: list[str] = []
        assert measure_study(store, OPTIONS, say=said.append).measured == 4
        assert len({line.partition(":")[0] for line in said}) == 4
        whole = [showing for showing in store.contents().showings if showing.complete]
        found = [(showing.condition, showing.measured.get("flip") == 0) for showing in whole]
        assert sorted(found) == [("late", False), *[("reference", True)] * 3]


class Stop(BaseException):
    """Somebody ends the measurement."""


def test_an_aborted_measurement_resumes_and_a_missing_or_wrong_trace_is_reported(store):
    def stop(text):
        raise Stop

    with pytest.raises(Stop):
        measure_study(store, OPTIONS, say=stop)
    missing = [showing for showing in store.contents().showings if showing.complete and not showing.measured]
    assert len(missing) == 2
    (store.traces / missing[0].trace).unlink()
    trace = (store.traces / missing[1].trace).read_text(encoding="utf-8")
    (store.traces / missing[1].trace).write_text("nothing\n", encoding="utf-8")
    found = measure_study(store, OPTIONS)
    assert (found.measured, found.known, len(found.left_out)) == (0, 1, 2)
    assert "recording is gone" in found.left_out[0] and missing[1].trace in found.left_out[1]
    (store.traces / missing[1].trace).write_text(trace, encoding="utf-8")
    found = measure_study(store, OPTIONS)
    assert (found.measured, found.known) == (1, 1)


def test_a_cluster_measures_the_same(store):
    """The traces cross to workers, which know nothing of the store."""
    pytest.importorskip("distributed")
    assert measure_study(store, attrs.evolve(OPTIONS, where=ClusterOptions(cluster="local:1"))).measured == 3
    there = measured_of(store)
    assert measure_study(store, attrs.evolve(OPTIONS, again=True)).measured == 3
    assert measured_of(store) == there


def test_a_warp_chosen_by_the_machine_is_not_made_up(store, tmp_path):
    (tmp_path / "bench.json").write_text("{}", encoding="utf-8")
    settings = {"warp": "auto", "budget": 5.0, "bench": str(tmp_path / "bench.json")}
    showing = attrs.evolve(store.contents().showings[0], settings=settings)
    with pytest.raises(InputError, match="cannot be repeated"):
        run_options(showing, store.contents().sessions[0], store.traces, OPTIONS)
    with pytest.raises(InputError, match="neither warp .auto. nor a video"):
        measured(RunOptions(trace="walk", warp="auto", budget_ms=5.0))


def test_frames_are_as_old_as_they_were_unless_the_link_says_otherwise(store):
    """A headset shows a picture two refreshes after the request: no latency is 67 ms at 30 Hz."""
    session, showing = store.contents().sessions[0], store.contents().showings[0]
    showing = attrs.evolve(showing, settings={"latency": 0}, actual={"latency_ms_median": 66.666667, "size": "96x120"})
    assert run_options(showing, session, store.traces, OPTIONS).latency_ms == 66.667
    jittery = attrs.evolve(showing, settings={"latency": 50, "jitter": "normal:5"})
    assert run_options(jittery, session, store.traces, OPTIONS).latency_ms == 50
    actual = {"headset": "rift-cv1", "size": "96x120"}  # by a default that has changed since, unless it is named
    old, named = (attrs.evolve(showing, settings=said, actual=actual) for said in ({}, {"headset": "index"}))
    assert run_options(old, session, store.traces, OPTIONS).headset == "rift-cv1"
    assert run_options(named, session, store.traces, OPTIONS).headset == "index"
    unknown = attrs.evolve(showing, settings={"latency": 50}, actual={"latency_ms_median": None, "size": "96x120"})
    assert run_options(unknown, session, store.traces, OPTIONS).latency_ms == 50


def test_the_head_is_where_and_when_it_was_recorded(tmp_path):
    """Far outside of what one can walk in, where a replay moves the trace into the scene and begins
    at 0.
    """
    cut = turned(tmp_path / "far.csv", shift_m=(30.0, 0.0, 0.0))
    far = str(tmp_path / "far.csv")
    shown = {"scene": "planes", "size": (32, 40), "rate_hz": 30, "latency_ms": 0, "against": ""}
    options = RunOptions(trace=far, as_recorded=True, **shown)
    with set_up_replay(options) as setup:
        assert (setup.track.position_m == cut.position_m).all() and (setup.track.time_ns == cut.time_ns).all()
        assert setup.schedule.first_ns == cut.time_ns[0] >= EPOCH_NS
    with set_up_replay(attrs.evolve(options, as_recorded=False)) as setup:
        assert setup.schedule.first_ns == 0 and np.abs(setup.track.position_m[:, 0]).max() < 10


RATED = attrs.evolve(OPTIONS, jod_s=0.1)


@without_cvvdp
def test_without_the_package_rating_says_how_to_get_it(store):
    found = measure_study(store, RATED)
    assert found.measured == 0 and len(found.failed) == 3
    assert all("pip install '.[jod]'" in failure.why for failure in found.failed)


@with_cvvdp
@quiet
def test_a_jod_rating_is_a_column_and_is_not_repeated(store):
    measure_study(store, OPTIONS)
    plain = measured_of(store)
    said: list[str] = []
    assert measure_study(store, RATED, say=said.append).measured == 3
    of = measured_of(store)
    assert of["late"]["jod"] < of["warped"]["jod"] < of["reference"]["jod"] == 10.0
    assert all(text.endswith("JOD") for text in said)
    assert all(figures.items() <= of[name].items() for name, figures in plain.items())
    for options in (RATED, OPTIONS):
        assert measure_study(store, options).known == 3


# --- recorded frames: planned, run by simulated people, and measured


@pytest.fixture
def recorded(tmp_path):
    (tmp_path / "walk-past").mkdir()
    write_npz(tmp_path / "walk-past", taken(12, (60, 40)))
    path = tmp_path / "recorded.toml"
    path.write_text(RECORDED, encoding="utf-8")
    return path


def test_a_session_shows_them_and_each_trial_is_measured(recorded, tmp_path):
    """The trial is as a replay over the camera's own head, as old as its frames really were."""
    said = {"study": str(recorded), "participant": "P1", "pilot": True, "source": "offscreen", "console": "none"}
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


UNSHOWABLE = [
    ('"walk-past"', '"nowhere"', "no such file or folder"),
    ("latency = 100, warp", "guard = 2, latency = 100, warp", "is the same for all conditions"),
    ("[trial]", 'lens = "radial"\n[trial]', "lens radial with frames"),
]


@together("old, new, told", UNSHOWABLE)
def test_unshowable_frames_are_refused_in_the_plan(recorded, old, new, told):
    recorded.write_text(RECORDED.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(InputError, match=told):
        load_design(str(recorded))
