"""What a plan comes to: time, balance, what to think of; and what the settings of a condition are.

They are the options of hmdwarp live, no more, no less. How a plan is printed: golden/.
"""

from __future__ import annotations

import inspect
import sys
import tomllib
from itertools import product
from pathlib import Path

import attrs
import pytest

from hmdwarp.cli import runs as live_command
from hmdwarp.options.named_files import OUTSIDE
from hmdwarp.run import LiveOptions
from hmdwarp.study.design import (
    DISPLAY,
    KINDS,
    design_as_json,
    design_from_text,
    live_options,
    load_design,
    notes,
    rows_for,
)
from hmdwarp.study.design.definitions import _NOT_SETTINGS, PICTURE, check_settings, resolve_paths
from hmdwarp.study.design.orders import presented
from hmdwarp.study.design.plan_text import balance, least_participants, session_phases
from hmdwarp.study.statistics import smallest_p

from ..plans import PLANS, text_of


def design(*changes: tuple[str, str]):
    return design_from_text(text_of("whole", *changes), "study.toml")


def test_trials_until_done_take_at_most_their_longest_time():
    until = ("seconds = 20\n", 'seconds = "until done"\nlongest = 90\n')
    plan = design(until)
    phases = {phase.name: phase for phase in session_phases(plan, "run-1")}
    assert phases["trials"].content.startswith("6 until done, at most 90 s, each rated")
    assert phases["trials"].at_most and not phases["practice"].at_most
    assert phases["trials"].seconds >= 6 * 90
    assert design_as_json(plan)["trial_until_done"]
    long = design(("seconds = 20\n", 'seconds = "until done"\n'))
    assert long.seconds == 600
    assert any("at most about" in note and "a shorter longest" in note for note in notes(long))


def by_enumeration(n: int) -> float:
    """By going through all 2^n ways n differences can turn out. How many are as extreme as all in
    one direction.
    """
    sums = [sum(rank for rank, sign in enumerate(signs, 1) if sign) for signs in product((0, 1), repeat=n)]
    most = n * (n + 1) // 2
    return sum(abs(total - most / 2) >= most / 2 for total in sums) / len(sums)


def test_with_fewer_people_nothing_can_be_found():
    for n in range(1, 9):
        assert smallest_p(n) == by_enumeration(n)
    for comparisons in (1, 3, 6, 20):
        need = least_participants(comparisons)
        assert comparisons * smallest_p(need) <= 0.05 < comparisons * smallest_p(need - 1)


SAME_FRAMES = ("[trial]", 'guard = 1.2\npredict = "cautious"\n[trial]')  # [common] stands before it


def test_a_comparison_of_several_settings_names_them_and_the_lines_that_leave_one():
    def about(*changes: tuple[str, str]) -> list[str]:
        return [note for note in notes(design(*changes)) if "several settings differ" in note]

    (note,) = about()
    assert "part run-1: 'warped-200' over 'late-200'" in note
    assert 'warp ("mesh" and "none"), guard (1.2 and 1), predict ("cautious" and "none")' in note
    assert 'write guard = 1.2 and predict = "cautious" into [common]' in note
    assert not about(SAME_FRAMES)
    # What the plan sets differently has no line that mends it.
    (note,) = about(SAME_FRAMES, ('latency = 200\nwarp = "mesh"', 'latency = 300\nwarp = "mesh"'))
    assert 'latency (300 and 200), warp ("mesh" and "none"); which' in note and "[common]" not in note
    for name in ("quick", "thesis", "thesis-as-was"):
        assert not [note for note in notes(load_design(name)) if "several settings differ" in note]


def test_a_sound_plan_leaves_little_to_think_of():
    reference = ("reference = true", 'warp = "none"\nreference = true')
    sound = design(reference, ('["grade", "acr"]', '["grade"]'), SAME_FRAMES)
    assert len(notes(sound)) == 3  # run-1 has an odd number; run-2 has no reference, and nothing is compared there


def test_breaks_come_between_trials():
    told = {phase.name: phase for phase in session_phases(design(("every = 6", "every = 2")), "run-1")}
    assert (told["breaks"].steps, told["breaks"].seconds) == (2, 60)
    assert told["breaks"].content.endswith("after every 2 trials")
    each = {phase.name: phase for phase in session_phases(design(("every = 6", "every = 1")), "run-1")}
    assert each["breaks"].content.endswith("after every trial")


def test_balance_is_counted():
    plan, fixed = design(), design(('order = "williams"', 'order = "fixed"'))
    found = balance(rows_for(plan, "run-1"), presented(plan, "run-1"))
    assert (found.orders, found.repeated, found.seams) == (6, 0, (1, 1))  # 3 conditions, 2 repeats
    assert found.places == found.pairs == (4, 4)
    found = balance(rows_for(fixed, "run-1"), presented(fixed, "run-1"))
    assert (found.orders, found.places, found.pairs, found.seams) == (1, (0, 2), (0, 2), (0, 1))


def test_every_option_of_live_is_a_setting_or_says_why_not():
    options = set(inspect.signature(live_command.live).parameters)
    options -= {OUTSIDE.name}  # of every command: a file grants itself nothing
    assert options == set(KINDS) | set(_NOT_SETTINGS) and not set(KINDS) & set(_NOT_SETTINGS)
    assert set(DISPLAY) < set(PICTURE) < set(KINDS)


def by_command_line(monkeypatch, *arguments: str) -> LiveOptions:
    """What `hmdwarp live` would run."""
    from hmdwarp.cli import main

    caught: list[LiveOptions] = []

    def ran(options: LiveOptions, *_: object) -> None:
        caught.append(options)
        raise SystemExit(0)

    monkeypatch.setattr("hmdwarp.run.live", ran)
    monkeypatch.setattr("hmdwarp.cli.end_cleanly", lambda: None)
    monkeypatch.setattr(sys, "argv", ["hmdwarp", "live", *arguments])
    with pytest.raises(SystemExit) as left:
        main()
    assert left.value.code == 0
    return caught[0]


def test_a_setting_means_what_the_option_means(monkeypatch):
    for line in (PLANS / "settings.txt").read_text(encoding="utf-8").splitlines():
        settings, _, arguments = line.partition("=> ")
        wanted = by_command_line(monkeypatch, *arguments.split())
        found = live_options(tomllib.loads(f"s = {{ {settings} }}")["s"])
        assert found == attrs.evolve(wanted, panel=False, command=""), line


def test_options_of_the_run_are_added(tmp_path):
    options = live_options({"latency": 100}, source="offscreen", trace="walk", record=tmp_path / "x.csv", seconds=3)
    found = (options.source, options.trace, options.record, options.seconds)
    assert found == ("offscreen", "walk", tmp_path / "x.csv", 3)


def test_a_scene_is_loaded_once():
    scenes: dict = {}
    options = check_settings({"scene": "planes", "latency": 0}, scenes)
    first = scenes[options.scene_key]
    check_settings({"scene": "planes", "latency": 100}, scenes)
    assert scenes == {options.scene_key: first}


def test_files_are_found_from_the_study_file(tmp_path):
    settings = {"scene": "mine.glb", "headset": "mine.toml", "delay-trace": "d.csv", "bench": "b.json", "warp": "mesh"}
    folder = tmp_path / "studies"
    assert resolve_paths(folder, settings) == {
        "scene": str(folder / "mine.glb"), "headset": str(folder / "mine.toml"), "delay_trace": str(folder / "d.csv"),
        "bench": str(folder / "b.json"), "warp": "mesh",
    }  # fmt: skip
    here = str(Path.cwd() / "beside" / "mine.glb")  # wherever one works later
    assert resolve_paths(Path("beside"), {"scene": "mine.glb"}) == {"scene": here}
    for name, value in (("scene", "mine.xml"), ("scene", "MINE.OBJ"), ("headset", "mine.json")):
        assert resolve_paths(folder, {name: value}) == {name: str(folder / value)}
    assert resolve_paths(folder, {"scene": "room", "headset": "rift-dk1"}) == {"scene": "room", "headset": "rift-dk1"}
