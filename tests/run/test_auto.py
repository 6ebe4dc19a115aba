"""A warp, a fill and a guard band that are chosen for a budget, a device and a head's motion."""

from __future__ import annotations

import itertools
import math
import re
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path

import attrs
import numpy as np
import pytest
from bench_files import AMPLE_MS, PAIRS, a_bench, a_row
from pages import rows_of
from replays import small, suited
from scipy.spatial.transform import Rotation

from hmdwarp.base import InputError, PlanError, parse_guard
from hmdwarp.client import Compensator, build_plan, every_warp, parse_warp
from hmdwarp.client.classes import client_names, load_client
from hmdwarp.display import Command
from hmdwarp.headsets import load_headset
from hmdwarp.pipeline import QualityLevel, build_plan_for, source_of
from hmdwarp.pipeline.governor import read_rows
from hmdwarp.poses import PoseTrack
from hmdwarp.run import (
    LiveOptions,
    RunOptions,
    choose,
    choosing,
    levels_by_short_bench,
    levels_from_file,
    needed_factors,
    replay,
    set_up_replay,
)
from hmdwarp.run.choosing import FILLS, MOST, NEAR_M, candidates, device_ms

from .offscreen import OffscreenDisplay, run_on

MEASURED = "b.json was measured on somebody's with 1 cores: scene planes; latency_ms 200.0; "


def auto(path: Path, **options):
    """Options of a small run that chooses."""
    return {"warp": "auto", "budget_ms": AMPLE_MS, "bench": path, **options}


@pytest.mark.parametrize(
    "text, told",
    [
        (None, "no such file"),
        ("rows", "not JSON"),
        pytest.param("[" * 100_000, "not JSON", id="nested"),
        ("[1]", "no list of 'rows'"),
        ('{"schema": 1}', "no list of 'rows'"),
        ('{"schema": 2, "rows": []}', "its schema is 2, this program reads 1"),
        ('{"schema": 1, "rows": [{"schema": 1}]}', "row 0: 'hmdwarp' is missing"),
    ],
)
def test_files_that_are_no_benchmark(tmp_path, text, told):
    path = tmp_path / "b.json"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=re.escape(f"{path}") + "(, line 1)?: ") as caught:
        read_rows(path)
    assert told in str(caught.value)


ODD = [None, True, 0, -1, 10**400, 1e308, "", "x", [], [[1]], {}, {"a": []}]


@pytest.mark.parametrize("value", ODD, ids=repr)
def test_a_benchmark_with_any_value_damaged_is_refused_in_a_line_or_read(tmp_path, value):
    def damaged(table: dict, depth: int) -> Iterator[dict]:
        for key, inner in table.items():
            yield {**table, key: value}
            if isinstance(inner, dict) and depth:
                yield from ({**table, key: each} for each in damaged(inner, depth - 1))

    good, path = a_row("none", "none", 1.0, 0.3, rate_hz=60.0, predict="none"), tmp_path / "b.json"
    for row in damaged(good, 2):
        a_bench(path, [row, good])
        for lens in ("none", "radial"):
            try:
                found = levels_from_file(path, small(**auto(path), headset="rift-dk1", lens=lens))
            except InputError as error:
                assert "b.json" in str(error) and "\n" not in str(error)
            else:
                assert found.levels and found.notes[0].startswith("b.json was measured on")


def test_a_budget_in_which_nothing_fits(tmp_path):
    with pytest.raises(InputError, match=r"the cheapest, none, takes 1000\.00 ms per eye"):
        choose(small(**auto(a_bench(tmp_path / "b.json"), budget_ms=1.0)))


@pytest.mark.parametrize("options", [{"warp": "auto", "budget_ms": 5.0}, {"guard": "auto"}], ids=str)
def test_a_replay_wants_a_choice_that_was_made(options, tmp_path):
    with pytest.raises(InputError, match=r"choose\(options\)\.options names what it stands for"):
        replay(small(**options, out=tmp_path / "out"))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("rows", "ms", "told"),
    [
        ([(1.0, {}), (99.0, {"size": [1920, 1080]})], 1.0, ()),  # those of the run's size come first
        (
            [(8.0, {"size": [192, 160]}), (1.0, {"size": [48, 40]})],
            2.0,
            ("at 192x160, this run is 96x80: its times are taken in proportion to the pixels, 0.25 times.",),
        ),
    ],
)
def test_terms_of_a_bench_that_are_not_the_run_s_are_told(tmp_path, rows, ms, told):
    found = levels_from_file(
        a_bench(tmp_path / "b.json", [a_row("none", "none", each, 0.3, **more) for each, more in rows]),
        small(**auto(tmp_path)),
    )
    assert [level.total_ms for level in found.levels] == [ms]
    assert found.notes[0].startswith(MEASURED)
    assert found.notes[1:] == tuple(f"b.json was measured {each}" for each in told)


def test_unknown_warps_of_a_bench_are_left_out(tmp_path):
    rows = [
        a_row("none", "none", 1.0, 0.3),
        a_row("teleport", "none", 2.0, 0.1),
        a_row("forward:x=1", "none", 2.0, 0.1),
    ]
    found = levels_from_file(a_bench(tmp_path / "b.json", rows), small(**auto(tmp_path)))
    assert [level.warp for level in found.levels] == ["none"]
    assert [note.partition(" is left out")[0] for note in found.notes[1:]] == [
        "b.json: warp 'forward:x=1' with fill 'none'",
        "b.json: warp 'teleport' with fill 'none'",
    ]
    with pytest.raises(InputError, match="nothing of its 1 rows can be run here"):
        levels_from_file(a_bench(tmp_path / "b.json", rows[1:2]), small(**auto(tmp_path)))


def test_a_run_without_a_lens_takes_the_times_without_theirs(tmp_path):
    with_lens = a_row("none", "none", 5.0, 0.3, lens="radial")
    with_lens["time_ms"]["lens"] = {"median": 2.0, "p95": 2.0}
    path, plain = a_bench(tmp_path / "b.json", [with_lens]), small(**auto(tmp_path))
    lensed = attrs.evolve(plain, lens="radial", headset="rift-dk1")
    assert [levels_from_file(path, one).levels[0].total_ms for one in (plain, lensed)] == [3.0, 5.0]
    found = levels_from_file(a_bench(tmp_path / "b.json", [a_row("none", "none", 5.0, 0.3)]), lensed)
    assert found.levels[0].total_ms == 5.0 and found.notes[0].endswith("lens none.")


def test_the_best_within_the_budget_is_named_with_its_command_line_and_why(tmp_path):
    rows = [a_row("none", "none", 1.0, 0.3), a_row("forward", "pyramid", 2.0, 0.2), a_row("mesh", "pyramid", 4.0, 0.1)]
    path = a_bench(tmp_path / "b.json", rows)
    choice = choose(small(**auto(path, budget_ms=3.0), trace="walk", guard="auto"))
    assert (choice.options.warp, choice.options.fill, choice.options.budget_ms) == ("forward", "pyramid", None)
    assert choice.options.guard > 1
    assert choice.notes[0] == "forward + pyramid: 2.00 of 3 ms for one eye, mean FLIP 0.2000."
    assert choice.notes[1] == "The next better is mesh + pyramid: 4.00 ms, mean FLIP 0.1000."
    assert choice.notes[2].startswith("Guard auto: ")
    typed = ["walk", "--warp=auto", "--budget", "3", "--latency", "200", "--bench", f"{path}", "--json"]
    wanted = f"hmdwarp replay walk --latency 200 --warp forward --fill pyramid --guard {choice.options.guard}"
    assert choice.command(typed) == wanted


def test_a_live_run_goes_down_when_time_runs_out_and_up_again(gpu, tmp_path, monkeypatch):
    """The best level really takes 150 ms for a while, where there are 100.

    Otherwise both take a few at 96x80.
    """
    if gpu.timer.clock != "wall":
        pytest.skip("how long it works is told by the wall clock, of which GPU timers see a part")
    refresh = itertools.count()

    class Busy(Compensator):
        """Does all its work over and over while the machine is meant to be busy with something
        else.
        """

        now = 0

        def run(self, inputs):
            Busy.now = next(refresh) if inputs.eye == 0 else Busy.now
            began, working = time.perf_counter(), True
            while working:
                result = super().run(inputs)
                busy = 20 <= Busy.now < 40 and self.plan.warp.name == "forward"
                working = busy and time.perf_counter() - began < 0.15
            return result

    monkeypatch.setattr("hmdwarp.run.run.Compensator", Busy)
    rows = [a_row("none", "none", 1.0, 0.3), a_row("forward", "interpolate", 2.0, 0.1)]
    options = {"warp": "auto", "budget_ms": 100.0, "bench": a_bench(tmp_path / "b.json", rows)}
    live = LiveOptions(scene="planes", headset="rift-dk1", latency_ms=50.0, pictures=180, **options)
    changes = run_on(monkeypatch, OffscreenDisplay(gpu=gpu), live).summary["live"]["changes"]
    assert [list(change["what"]) for change in changes] == [["warp", "fill"]] * 2
    assert "over the budget" in changes[0]["reason"] and "expected within 95%" in changes[1]["reason"]


def test_each_switch_of_a_live_run_is_logged_once(gpu, tmp_path, monkeypatch):
    """Also where only the latency is changed, so that the same governor goes on; and one that
    begins anew, by another guard band, has its switches logged too.
    """
    rows = [a_row("none", "none", 1e-4, 0.3), a_row("forward", "interpolate", 2e-4, 0.1)]
    asked = {20: [Command("latency", 60.0)], 30: [Command("guard", 1.25)]}
    options = {"warp": "auto", "budget_ms": 1e-3, "bench": a_bench(tmp_path / "b.json", rows)}
    live = LiveOptions(scene="planes", headset="rift-dk1", latency_ms=50.0, pictures=50, **options)
    summary = run_on(monkeypatch, OffscreenDisplay(gpu=gpu, asked=asked), live).summary
    told = [(*change["what"], "over the budget" in change["reason"]) for change in summary["live"]["changes"]]
    down = ("warp", "fill", True)
    assert told == [down, ("latency", False), ("guard", False), down]


def test_it_would_try_all_that_the_run_can_have(monkeypatch):
    usual = small(warp="auto", budget_ms=AMPLE_MS)

    def tried(options: RunOptions) -> set[tuple[str, str]]:
        return {(c.warp, c.fill) for c in candidates(options, source_of(options))}

    beyond_a_picture = {"backward", "environment", "layered"}
    assert not {parse_warp(warp).entry.name for warp, _ in tried(usual)} & beyond_a_picture
    options = attrs.evolve(usual, client="class-3")
    suits = [spec for spec in every_warp() if parse_warp(spec).entry.name in suited(usual.scene)]
    every = set(itertools.product(suits, FILLS))
    assert tried(options) == every

    def picky(one, *inputs, **more):
        if one.warp == "rotation":
            raise PlanError("not in this run")
        return build_plan_for(one, *inputs, **more)

    monkeypatch.setattr("hmdwarp.run.choosing.build_plan_for", picky)
    assert tried(options) == {pair for pair in every if pair[0] != "rotation"}


@pytest.fixture
def few(monkeypatch):
    """A trial of three warps: pictures of all would take FLIP half a minute on a busy machine."""
    monkeypatch.setattr(
        "hmdwarp.run.choosing.candidates",
        lambda options, source: [c for c in candidates(options, source) if c.warp in {w for w, _ in PAIRS}],
    )


def test_a_trial_of_its_own_leaves_out_what_is_out_of_reach(few):
    said: list[str] = []
    options = small(warp="auto", budget_ms=AMPLE_MS, seconds=0.3)
    found = levels_by_short_bench(options, source_of(options), said.append)
    assert len(said) == 1 and said[0].startswith("trying 9 combinations")
    times, errors = [level.total_ms for level in found.levels], [level.error for level in found.levels]
    assert times == sorted(times) and errors == sorted(errors, reverse=True) and len(times) > 1
    hasty = attrs.evolve(options, budget_ms=1e-6)
    found = levels_by_short_bench(hasty, source_of(hasty), said.append)
    # The cheapest stays, to be told in the refusal.
    assert len({level.warp for level in found.levels}) == 1
    assert "took more than 2 times the budget" in found.notes[0]


@pytest.mark.parametrize(("budget_ms", "gets_them"), [(1.5, False), (2.5, True)])
def test_each_level_gets_what_it_would_get_alone(budget_ms, gets_them):
    """Frames carry the layers of every level; a level that needs none of them gets none."""
    levels = (QualityLevel("forward", "none", 1.0, 0.2), QualityLevel("layered", "none", 2.0, 0.1))
    options = small(warp="auto", budget_ms=budget_ms, client="class-3", against="", levels=levels)
    with set_up_replay(options) as setup:
        setup.loop.draw(setup.schedule.first_ns)
        refresh = setup.loop.show(setup.schedule.first_ns + setup.schedule.age_ns)
        assert all("peeled" in eye for eye in refresh.frame.eyes)
        assert ["peeled" in inputs.rendered for inputs in refresh.inputs] == [gets_them, gets_them]


SIZE = (2064, 2208)
DEVICES = [device for device in map(load_client, client_names()) if device.memory_gb_s < 1e9]


def plan(warp: str, fill: str = "none"):
    return build_plan((), warp, fill, "none", client_geometry=True)


def test_measured_passes_are_those_of_the_gpu_s_table():
    """A fill adds at most so much to any warp; the memory's is what it adds to its pyramid's."""
    path = Path(choosing.__file__).with_name("measured_passes.toml")
    measured = tomllib.loads(path.read_text(encoding="utf-8"))
    rows = rows_of("gpu NVIDIA H100 80GB HBM3")
    none, *others = (
        [float(row[f"{fill}, 2064x2208"].split()[0]) for row in rows]
        for fill in ("none", "interpolate", "pyramid", "memory+pyramid")
    )
    assert measured["warps"] == dict(zip((row["warp"].strip("`") for row in rows), none, strict=True))
    pairs = zip(("interpolate", "pyramid", "memory"), others, (none, none, others[1]), strict=True)
    added = {fill: max(ms - of for ms, of in zip(own, base, strict=True)) for fill, own, base in pairs}
    assert measured["fills"] == pytest.approx(added, abs=1e-9) and measured["gpu"]["size"] == [*SIZE]


def test_the_thesis_s_own_times_lie_between_the_ends():
    """GTX 765M, by its maker 64 GB/s and 1.3 TFLOPS; both eyes: warp 2 ms, interpolation 3 ms."""
    thesis = attrs.evolve(load_client("class-2"), memory_gb_s=64.0, compute_tflops=1.3)
    warp, filled = (device_ms(plan("forward", fill), (1280, 800), thesis) for fill in ("none", "interpolate"))
    assert warp[0] < 1.0 < warp[2] and filled[0] - warp[0] < 1.5 < filled[2] - warp[2]


@pytest.mark.parametrize("device", DEVICES, ids=lambda device: device.name)
def test_the_least_is_what_crosses_the_memory_once_and_all_grows_with_pixels(device):
    """`rotation` reads a colour and writes one, 8 bytes each; `iterative` reads 4 of depth too."""
    for warp, moved in (("rotation", 16), ("iterative:frames=1", 20)):
        least, middle, most = device_ms(plan(warp), SIZE, device)
        assert least == pytest.approx(moved * SIZE[0] * SIZE[1] / device.memory_gb_s * 1e-6)
        assert middle == pytest.approx((least * most) ** 0.5) and least <= most
        half = device_ms(plan(warp), (SIZE[0], SIZE[1] // 2), device)
        assert half == pytest.approx((least / 2, middle / 2, most / 2))
    unknown, known = (device_ms(plan(warp), SIZE, device)[2] for warp in ("similarity", "splat"))
    assert unknown == known, "what was not measured counts as the slowest that was"


def test_a_choice_for_a_device_goes_by_its_model_whatever_this_machine_took(tmp_path):
    levels = (("rotation", 1e6, 0.3), ("iterative:frames=1", 1.0, 0.2), ("splat", 1e-3, 0.1))
    path = a_bench(tmp_path / "b.json", [a_row(warp, "none", ms, flip) for warp, ms, flip in levels])
    least, middle, most = device_ms(plan("iterative:frames=1"), (96, 80), load_client("quest-3"))
    choice = choose(small(warp="auto", client="quest-3", budget_ms=1.01 * middle, bench=path))
    made = (choice.options.warp, choice.level.total_ms, choice.range_ms)
    assert made == ("iterative:frames=1", middle, (least, most))
    assert choice.notes[2].startswith("The next better is splat: ")
    assert f"{least:.1f} to {most:.1f} ms on 'quest-3'" in choice.notes[1] and "&bench" in choice.notes[1]


QUEST = load_client("quest-3")


def test_each_older_frame_takes_time_and_is_a_level_of_its_own():
    chains = ("iterative:frames=1", "iterative:frames=2", "iterative")
    times = [device_ms(plan(warp), (96, 80), QUEST)[1] for warp in chains]
    assert times == sorted(set(times)) and set(chains) <= set(every_warp())


def test_pictures_for_a_device_are_drawn_at_a_third_and_its_times_are_of_all_its_pixels(monkeypatch):
    monkeypatch.setattr(choosing, "MOST_PIXELS", 96 * 80 - 1)
    choice = choose(small(warp="auto", client="quest-3", budget_ms=0.1))
    assert "for errors at 32x27, a third of its size each way" in choice.notes[-1]
    assert choice.options.size == (96, 80)
    assert choice.level.total_ms == device_ms(plan(choice.options.warp, choice.options.fill), (96, 80), QUEST)[1]


FLAT = load_headset("flat-90")  # 45 degrees to every side


def heads(*poses: tuple[tuple[float, float, float], Rotation]) -> tuple[np.ndarray, np.ndarray]:
    return np.array([place for place, _ in poses], float), np.array([turn.as_quat() for _, turn in poses])


def turned(axis: str, degrees: float, place=(0.0, 0.0, 0.0)):
    return place, Rotation.from_euler(axis, degrees, degrees=True)


STILL = turned("y", 0)


@pytest.mark.parametrize("axis", ["x", "y"])
@pytest.mark.parametrize("degrees", [-20, 5, 30])
def test_a_turn_needs_the_tangent_of_the_half_angle_and_the_turn(axis, degrees):
    """The middle of a side 45 degrees out lies 45 + the turn degrees out in the drawn picture."""
    # The eyes sit beside the axis that the head turns about: at 1 m that is some centimetres more;
    # turning about x moves neither.
    found = needed_factors(FLAT, heads(STILL), heads(turned(axis, degrees)))[0]
    exact = math.tan(math.radians(45 + abs(degrees)))
    eyes_moved = 2 * FLAT.ipd_m * abs(math.sin(math.radians(degrees))) / NEAR_M if axis == "y" else 0
    assert exact - 1e-9 <= found <= exact + (1 + exact) * eyes_moved + 1e-9


def test_a_step_aside_counts_for_what_is_a_metre_away_and_no_picture_holds_a_turn_beside_it():
    aside, beside = turned("y", 0, (0.25, 0.0, 0.0)), turned("y", 60)
    assert needed_factors(FLAT, heads(STILL), heads(aside))[0] == pytest.approx(1 + 0.25 / NEAR_M)
    assert np.isinf(needed_factors(FLAT, heads(STILL), heads(beside))).all()


def steady(deg_s: float) -> PoseTrack:
    """Turning to the left."""
    t = np.arange(0, 2_000_000_001, 10_000_000)
    return PoseTrack(
        t, np.zeros((len(t), 3)), Rotation.from_rotvec(np.outer(np.radians(deg_s * t * 1e-9), (0, 1, 0))).as_quat()
    )


@pytest.fixture
def turning(tmp_path):
    from hmdwarp.poses.formats import write_native

    path = tmp_path / "turning.csv"
    with path.open("w") as stream:
        write_native(steady(40), stream, (6, 8))
    return str(path)


def test_a_steady_turn_gets_what_it_moves_by_in_the_latency_and_prediction_saves_it(turning):
    """40 deg/s for 200 ms are 8 degrees.

    A constant velocity is predicted to the last bit, as far as the horizon reaches.
    """
    usual = {"trace": turning, "guard": "auto", "headset": "flat-90", "lens": "none", "latency_ms": 200, "rate_hz": 50}
    plain = choose(RunOptions(**usual, predict="none")).options
    assert math.tan(math.radians(53)) <= plain.guard <= math.tan(math.radians(53)) + 0.03
    predicted = choose(RunOptions(**usual, predict="constant_velocity", horizon_ms=300))
    assert predicted.options.guard == pytest.approx(1, abs=0.011)
    assert f"{predicted.options.guard:g} is drawn" in predicted.notes[0]


def test_no_more_than_most_is_drawn_and_the_note_says_so():
    choice = choose(RunOptions(trace="fast-turns", guard="auto", latency_ms=400))
    assert choice.options.guard == MOST
    assert "--fill wide" in choice.notes[0]


def test_a_guard_is_one_factor_or_one_for_each_axis():
    told = {" auto ": "auto", "1.5": 1.5, "1.25x1.125": (1.25, 1.125), " 1.5 X 1.5 ": 1.5}
    assert {text: parse_guard(text) for text in told} == told
    for wrong in ("wide", "1.5x", "x1.5", "1x2x3", ""):
        with pytest.raises(InputError, match=r"one factor of at least 1 \(1\.5\) or one for each axis"):
            parse_guard(wrong)
