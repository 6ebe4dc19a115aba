"""Plans: what is right comes out as it was written; what it comes to; what its settings are.

What is wrong: test_refused.py. How a plan is printed: golden/.
"""

from __future__ import annotations

import csv
import inspect
import json
import re
import sys
import tomllib
from pathlib import Path

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.base import InputError
from hmdwarp.base.named_files import OUTSIDE
from hmdwarp.cli import runs as live_command
from hmdwarp.run import LiveOptions
from hmdwarp.study.design import (
    DISPLAY,
    KINDS,
    Comparison,
    Design,
    design_as_json,
    design_from_text,
    live_options,
    load_design,
    notes,
    rows_for,
    steps_of,
    study_names,
)
from hmdwarp.study.design.definitions import _NOT_SETTINGS, PICTURE, resolve_paths
from hmdwarp.study.design.plan_text import least_participants
from hmdwarp.study.statistics import smallest_p

from ..analysis.tables import PUBLISHED
from ..plans import PLANS, text_of
from ..test_golden import compare, leaves

WHOLE = text_of("whole")


def read(text: str, path: str = "study.toml") -> Design:
    return design_from_text(text, path)


def came_of(design: Design) -> list[str]:
    """All that a plan comes to but scales and orders; of a session the steps of two trials."""
    data = {key: value for key, value in design_as_json(design).items() if key not in ("scales", "notes")}
    lines = [f"{where}: {value}" for where, value in leaves(json.loads(json.dumps(data))) if ".orders." not in where]
    for part in design.parts:
        for step in steps_of(design, rows_for(design, part.name)[0], part.name):
            if getattr(step, "trial", 9) < 3 and not step.key.startswith(("before", "after")):
                about = {name: getattr(step, name, "") for name in ("condition", "seconds", "turn", "after", "about")}
                about["condition"] = getattr(about["condition"], "name", "")
                told = [f"{name} {value}" for name, value in about.items() if value]
                lines.append(f"step of {part.name}: {', '.join([step.key, *told])}")
    return lines + [f"note: {note}" for note in notes(design)]


def test_plans_come_out_as_they_did():
    """plans/changes.txt; of a changed plan what is another line. HMDWARP_GOLDEN=write renews it."""
    before: dict[str, list[str]] = {}
    said = []
    for entry in (PLANS / "changes.txt").read_text(encoding="utf-8").splitlines():
        name, *changes = entry.split(" | ")
        put = [tuple(side.replace("⏎", "\n") for side in re.split(" -> ?", change)) for change in changes]
        lines = came_of(design_from_text(text_of(name, *put), f"{name}.toml", checked=False))
        known = before.setdefault(name, lines) if changes else []
        said += [f"== {entry}", *(line for line in lines if line not in known)]
        said += [f"no {line}" for line in known if line not in lines and line.startswith("note")]
        before.setdefault(name, lines)
    compare("\n".join(said), PLANS / "expected.txt")


@pytest.mark.parametrize("name", study_names())
def test_the_shipped_ones_are_sound(name):
    design = load_design(name)
    assert design.name == name and not [note for note in notes(design) if "several settings differ" in note]
    for part in design.parts:
        for order in rows_for(design, part.name):
            steps = steps_of(design, order, part.name)
            assert len({step.key for step in steps}) == len(steps)


def test_the_thesis_is_the_thesis():
    """Two runs of other people; 200, 400 and 800 ms, each without a warp and with; grades. A family
    of three comparisons for each run.
    """
    design = load_design("thesis")
    assert [scale.name for scale in design.scales] == ["grade"]
    assert [part.name for part in design.parts] == ["run-1", "run-2"]
    planned = {
        (part.name.removeprefix("run-"), *(str(condition.settings[key]) for key in ("latency", "warp", "fill")))
        for part in design.parts
        for condition in part.conditions
    }
    warped = {"1": ("forward", "interpolate"), "2": ("forward", "interpolate+composite")}
    shown = [
        (run, ms, *how) for run, by in warped.items() for ms in ("200", "400", "800") for how in (("none",) * 2, by)
    ]
    with PUBLISHED.open(encoding="utf-8") as file:
        rated = {(row["run"], row["latency_ms"], row["warp"], row["fill"] or "none") for row in csv.DictReader(file)}
    assert planned == set(shown) == rated
    for family, part in zip(design.families, design.parts, strict=True):
        over = [Comparison(part.name, f"late-{ms}", f"warped-{ms}") for ms in (200, 400, 800)]
        assert family.comparisons == tuple(over)


def test_files_are_found_next_to_the_study_file(tmp_path, monkeypatch):
    folder = tmp_path / "studies"
    folder.mkdir()
    (folder / "consent.txt").write_text("Read me.\n", encoding="utf-8")
    (folder / "mine.toml").write_text(text_of("own"), encoding="utf-8")
    (folder / "delays.csv").write_text("delay_ms\n20\n30\n", encoding="utf-8")
    text = text_of(
        "whole", ('text = "You may stop at any moment."', 'file = "consent.txt"'), ('"acr"]', '"mine.toml"]'),
        ("jitter = 'uniform:20'", 'delay_trace = "delays.csv"'),
    )  # fmt: skip
    (folder / "study.toml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    design = load_design("studies/study.toml")
    assert design.consent.text == "Read me.\n"
    assert design.scales[1].name == "mine"
    assert design.part("run-2").condition("b").settings["delay_trace"] == str(folder / "delays.csv")


def test_windows_line_ends_and_bom_are_read(tmp_path):
    path = tmp_path / "study.toml"
    path.write_bytes(b"\xef\xbb\xbf" + WHOLE.replace("\n", "\r\n").encode())
    assert load_design(str(path)).text == WHOLE


def test_one_condition_has_no_order():
    text = text_of("whole", ("[[part.condition]]\nname = \"b\"\njitter = 'uniform:20'\n", ""))
    assert read(text.replace('"williams"', '"fixed"')).order == "fixed"
    for wrong, says in (
        (text, r"study\.toml:14: trial\.order is williams .* one condition has no order"),
        (text.replace("part.condition]", "part.conditions]"), r"condition is missing: is conditions meant to be"),
        (text[: text.index("[[part.condition]]")], r"the key part\.condition is missing"),
    ):
        with pytest.raises(InputError, match=says):
            read(wrong)


NO_FILES = [
    ("thsis", "unknown study 'thsis': did you mean 'thesis'"),
    ("./absent.toml", r"absent\.toml: no such file: expected a \.toml file, or one of quick, th"),
    ("./folder.toml", "is a directory"),
    ("./study.txt", r"expected one whose name ends in \.toml"),
    ("./latin.toml", r"latin\.toml:2: byte 0xe4: not a text file: expected .* in UTF-8"),
    ("./huge.toml", r"huge\.toml: 1000001 bytes: expected"),
    ("a\0b.toml", "."),
]


def test_files_that_are_none(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("folder.toml").mkdir()
    for name, data in {"study.txt": b"x", "latin.toml": b"# a\n# \xe4\n", "huge.toml": b"#" * 1_000_001}.items():
        Path(name).write_bytes(data)
    for name, says in NO_FILES:
        with pytest.raises(InputError, match=says):
            load_design(name)


LINES = WHOLE.splitlines()
NUMBERS = ["-1", "0", "1.5", "nan", "1e400", "0x" + "f" * 5000, "9" * 30, "'x'", "true", "[]", "[[]]", '["x"]', "{}"]
VALUES = st.sampled_from([*NUMBERS, '""', '"a\\nb"', '"auto"', "2001-01-01", "[" * 5000, "[" * 300 + "]" * 300])
PLACES = st.integers(0, len(LINES) - 1)


def overwritten(at: int, put: str) -> str:
    return WHOLE[:at] + put + WHOLE[at + len(put) :]


def another_value(number: int, value: str) -> str:
    key, equals, _ = LINES[number].partition(" = ")
    return "\n".join([*LINES[:number], f"{key} = {value}" if equals else value, *LINES[number + 1 :]])


def left_out(gone: set[int]) -> str:
    """But for the scene: the usual one takes a second to load."""
    return "\n".join(line for k, line in enumerate(LINES) if k not in gone or line.startswith("scene"))


CHANGED = st.one_of(
    st.builds(overwritten, st.integers(0, len(WHOLE) - 1), st.text(max_size=6)),
    st.builds(another_value, PLACES, VALUES),
    st.builds(another_value, PLACES, VALUES),
    st.builds("\n".join, st.lists(st.sampled_from(LINES), max_size=60)),
    st.builds(left_out, st.sets(PLACES, max_size=4)),
)


@settings(max_examples=400)
@given(CHANGED)
def test_whatever_is_changed_is_read_or_refused_in_one_line(text):
    """Characters overwritten, any value for any key, lines in any order or left out."""
    try:
        assert isinstance(read(text), Design)
    except InputError as error:
        assert str(error).startswith("study.toml:") and "\n" not in str(error)


def test_with_fewer_people_nothing_can_be_found():
    for comparisons in (1, 3, 6, 20):
        need = least_participants(comparisons)
        assert comparisons * smallest_p(need) <= 0.05 < comparisons * smallest_p(need - 1)


def test_every_option_of_live_is_a_setting_or_says_why_not():
    options = set(inspect.signature(live_command.live).parameters)
    options -= {OUTSIDE.name, "ctx"}  # of every command: a file grants itself nothing
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
