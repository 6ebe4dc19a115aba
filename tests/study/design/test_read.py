"""Study files: what is right comes out as it was written, what is wrong is told with its line."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import attrs
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hmdwarp.errors import InputError
from hmdwarp.study.design import (
    UNBLINDED,
    Comparison,
    Design,
    design_from_text,
    load_design,
    rows_for,
    steps_of,
    study_names,
)
from hmdwarp.study.design.definitions import BOTH, FIXED, WILLIAMS, Breaks

from ..analysis.tables import PUBLISHED
from ..refusals import check_refused, table
from .plans import WHOLE


def read(text: str, path: str = "study.toml") -> Design:
    return design_from_text(text, path)


def test_everything_comes_out_as_it_was_written():
    design = read(WHOLE)
    assert (design.name, design.title, design.seed, design.blind, design.order) == (
        "whole", "Everything at once", 7, BOTH, WILLIAMS,
    )  # fmt: skip
    assert (design.seconds, design.repeats, design.practice_seconds) == (20, 2, 60)
    assert [scale.name for scale in design.scales] == ["grade", "acr"]
    assert [scale.name for scale in design.before] == ["ssq"] and [scale.name for scale in design.after] == [
        "ssq",
        "vrsq",
    ]
    assert design.breaks == Breaks(6, 30)
    sickness = design.sickness
    assert sickness is not None
    assert (sickness.scale.name, sickness.every, sickness.stop_at, sickness.rise) == ("fms", 1, 15, 8)
    assert design.consent is not None and design.consent.text == "You may stop at any moment."
    assert [part.name for part in design.parts] == ["run-1", "run-2"]
    late, warped, reference = design.part("run-1").conditions
    assert (
        late.settings == {"scene": "planes", "size": "96x120", "latency": 200, "warp": "none", "fill": "none"}
        and not late.reference
    )
    assert warped.settings == {"scene": "planes", "size": "96x120", "latency": 200, "warp": "mesh", "guard": 1.2}
    assert reference.reference
    assert design.practice is not None
    assert design.practice.settings == {
        "scene": "planes", "size": "96x120", "latency": 10, "warp": "none", "fill": "none",
    }  # fmt: skip
    assert [family.comparisons for family in design.families] == [
        (Comparison("run-1", "late-200", "warped-200"), Comparison("run-1", "late-200", "reference"))
    ]
    assert design.text == WHOLE and design.path == "study.toml"


def test_a_small_plan_has_the_usual_for_all_it_leaves_out():
    conditions = '[[condition]]\nname = "a"\n[[condition]]\nname = "b"\nlatency = 0\n'
    design = read(f'schema = 1\nname = "s"\ntitle = "S"\n[trial]\nscales = ["acr"]\n{conditions}')
    (part,) = design.parts
    assert part.name == "main" and [condition.settings for condition in part.conditions] == [{}, {"latency": 0}]
    assert design.practice is None and design.sickness is None and design.consent is None and design.families == ()
    assert (design.seconds, design.repeats, design.order, design.blind, design.seed) == (20, 1, WILLIAMS, BOTH, 0)


def test_the_practice_takes_over_how_it_looks_and_not_how_late_it_is():
    text = WHOLE.replace(
        "[common]\n", '[common]\nlatency = 300\njitter = "uniform:50"\nwarp = "mesh"\nguard = 1.5\nlens = "none"\n'
    )
    practice = read(text.replace("\nlatency = 10\n", "\n").replace("latency = 0\n", "latency = 60\n")).practice
    assert practice is not None
    assert practice.settings == {
        "lens": "none", "scene": "planes", "size": "96x120", "latency": 0, "warp": "none", "fill": "none",
    }  # fmt: skip


@pytest.mark.parametrize("name", study_names())
def test_the_shipped_ones_are_sound(name):
    design = load_design(name)
    assert design.name == name
    for part in design.parts:
        for order in rows_for(design, part.name):
            steps = steps_of(design, order, part.name)
            assert len({step.key for step in steps}) == len(steps)


def test_the_thesis_is_the_thesis():
    """Two runs of other people; 200, 400 and 800 ms, each without a warp and with; grades.

    A family of three comparisons for each run.
    """
    design = load_design("thesis")
    assert [scale.name for scale in design.scales] == ["grade"]
    assert [part.name for part in design.parts] == ["run-1", "run-2"]
    for part, fill in zip(design.parts, ("interpolate", "interpolate+composite"), strict=True):
        told = [
            (condition.settings["latency"], condition.settings["warp"], condition.settings["fill"])
            for condition in part.conditions
        ]
        assert told == [(ms, "none", "none") for ms in (200, 400, 800)] + [
            (ms, "forward", fill) for ms in (200, 400, 800)
        ]
    with PUBLISHED.open(encoding="utf-8") as file:
        rated = {(row["run"], row["latency_ms"], row["warp"], row["fill"] or "none") for row in csv.DictReader(file)}
    assert rated == {
        (part.name.removeprefix("run-"), *(str(condition.settings[key]) for key in ("latency", "warp", "fill")))
        for part in design.parts
        for condition in part.conditions
    }
    for family, part in zip(design.families, design.parts, strict=True):
        assert family.comparisons == tuple(
            Comparison(part.name, f"late-{ms}", f"warped-{ms}") for ms in (200, 400, 800)
        )


def test_the_thesis_differs_from_how_it_was_only_in_what_its_head_lists():
    """A point of the head for each field of the plan that differs, and no point without one.

    The point "Picture" is of both.
    """
    now, was = load_design("thesis"), load_design("thesis-as-was")
    point_of = {
        "order": "Order", "seconds": "Time", "until_done": "Time", "blind": "Blinding", "breaks": "Well-being",
        "sickness": "Well-being", "before": "Well-being", "after": "Well-being",
        "consent": "Well-being",  # its text says what is asked
    }  # fmt: skip
    names = {field.name for field in attrs.fields(Design)} - {"name", "title", "text", "path"}
    assert {name for name in names if getattr(now, name) != getattr(was, name)} == set(point_of)
    head = now.text.partition("schema")[0]
    assert set(re.findall(r"^# - ([\w-]+):", head, re.MULTILINE)) == {*point_of.values(), "Picture"}
    assert (was.order, was.until_done, was.blind, was.breaks, was.sickness) == (FIXED, True, UNBLINDED, Breaks(), None)
    assert rows_for(was, "run-1") == ((tuple(f"{how}-{ms}" for how in ("late", "warped") for ms in (200, 400, 800)),),)


def test_files_are_found_next_to_the_study_file(tmp_path, monkeypatch):
    folder = tmp_path / "studies"
    folder.mkdir()
    (folder / "consent.txt").write_text("Read me.\n", encoding="utf-8")
    scale = 'title = "Mine"\nkind = "rating"\nsource = "mine"\n'
    scale += "[answer]\nleast = 0\nmost = 1\nstep = 1\nlow_is_good = true\n"
    scale += '[answer.anchors]\n0 = "a"\n1 = "b"\n[[item]]\nkey = "mine"\ntext = "Well?"\n'
    (folder / "mine.toml").write_text(scale, encoding="utf-8")
    (folder / "delays.csv").write_text("delay_ms\n20\n30\n", encoding="utf-8")
    text = WHOLE.replace('text = "You may stop at any moment."', 'file = "consent.txt"').replace(
        '"acr"]', '"mine.toml"]'
    )
    text = text.replace("jitter = 'uniform:20'", 'delay_trace = "delays.csv"')
    (folder / "study.toml").write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    design = load_design("studies/study.toml")
    assert design.consent is not None and design.consent.text == "Read me.\n"
    assert design.scales[1].name == "mine"
    assert design.part("run-2").condition("b").settings["delay_trace"] == str(folder / "delays.csv")


def test_windows_line_ends_and_bom_are_read(tmp_path):
    path = tmp_path / "study.toml"
    path.write_bytes(b"\xef\xbb\xbf" + WHOLE.replace("\n", "\r\n").encode())
    assert load_design(str(path)).text == WHOLE


BROKEN = r"""
schema = 1 -> schema = 2 => schema is 2: expected 1
schema = 1⏎ ->  => the key schema is missing; thesis.toml ('hmdwarp study plan thesis' prints its path) has them all
name = "whole" -> name = "a whole" => name is 'a whole': expected a name of letters, digits
name = "whole" -> name = "../whole" => name is '../whole': expected a name
title =  -> titel =  => the key title is missing: is titel meant to be title?
seed = 7 -> seed = -1 => seed is -1: expected a whole number of at least 0
blind = "both" -> blind = "me" => blind is 'me': expected both, participant or nobody
seed = 7 -> seed = 7⏎»sede = 8 => unknown key sede: did you mean seed?
[breaks] -> [braeks] => unknown key braeks: did you mean breaks?
[trial] -> [[trial]] => trial is [{
seconds = 20 -> seconds = 0 => trial.seconds is 0: expected a number above 0 and at most 3600
seconds = 20 -> seconds = "20" => trial.seconds is '20': expected a finite number
seconds = 20 -> seconds = "when done" => is 'when done': expected a finite number, or "until done"
seconds = 20 -> seconds = 20⏎»longest = 60 => longest belongs to seconds = "until done"
seconds = 20 -> seconds = "until done"⏎»longest = 0 => trial.longest is 0: expected a number
repeats = 2 -> repeats = 0 => trial.repeats is 0: expected a whole number
repeats = 2 -> repeats = 400 => trial.repeats makes 3 x 400 trials: expected 1000 at most
order = "williams" -> order = "latin" => trial.order is 'latin': expected williams, random or fixed
scales = ["grade", "acr"] -> scales = ["grade", "grades"] => unknown scale 'grades': did you mean 'grade'?
scales = ["grade", "acr"] -> scales = ["grade", "grade"] => trial.scales has 'grade' twice
scales = ["grade", "acr"] -> scales = [] => trial.scales is empty: expected one scale at least
scales = ["grade", "acr"] -> scales = ["ssq"] => trial.scales has 'ssq', a questionnaire of 16 items with scores
scales = ["grade", "acr"] -> scales = ["grade", "fms"] => trial.scales has 'fms', which is also that of [sickness]
scales = ["grade", "acr"] -> scales = ["misc"] => trial.scales has no rating (misc): expected one scale of kind rating
scales = ["grade", "acr"] -> scales = ["none.toml"] => none.toml: no such file
every = 6 -> every = -1 => breaks.every is -1: expected a whole number of at least 0
seconds = 30 -> seconds = -30 => breaks.seconds is -30: expected a number of at least 0
seconds = 60⏎latency = 10 -> seconds = 60⏎»latency = -10 => practice: latency -10 ms: expected a finite number
stop_at = 15 -> stop_at = 21 => sickness.stop_at is 21: expected a number of at least 0 and at most 20
stop_at = 15 -> stop_at = 0 => sickness.stop_at is 0, the best answer of 'fms'
rise = 8 -> rise = 0 => sickness.rise is 0: expected a number above 0
scale = "fms" -> scale = "ssq" => sickness.scale has 'ssq', a questionnaire
scale = "fms" -> scale = "slider" => sickness.scale has 'slider', a rating
every = 1 -> every = 0 => sickness.every is 0: expected a whole number of at least 1
before = ["ssq"] -> before = "ssq" => questionnaires.before is 'ssq': expected a list of texts
before = ["ssq"] -> before = ["sqs"] => questionnaires.before has 'sqs': unknown scale 'sqs': did you mean 'ssq'?
version = "1" -> version = 1 => consent.version is 1: expected a text
text = "You may stop at any moment." -> file = "absent.txt" => absent.txt: no such file
text = "You may stop at any moment." ->  => consent needs either text, or file @ [consent]
name = "run-2" -> name = "Run-1" => part.name is 'Run-1' a second time
name = "run-2" -> nmae = "run-2" => the key part.name is missing: is nmae meant to be name?
name = "warped-200" -> name = "late-200" => name is 'late-200' a second time
[practice]⏎seconds = 60 -> [practice]⏎»secnds = 60
    => practice: unknown setting 'secnds': did you mean seconds? known are seconds, scene,
latency = 200⏎warp -> latncy = 200⏎warp => condition 'late-200': unknown setting 'latncy': did you mean latency?
latency = 200⏎warp -> latency = "200"⏎warp => condition 'late-200': latency is '200': expected a number
warp = "mesh" -> warp = "msh" => condition 'warped-200': unknown warp 'msh': did you mean 'mesh'?
warp = "mesh" -> warp = "mesh:cut=maybe" => condition 'warped-200': warp 'mesh:cut=maybe': cut is 'maybe'
warp = "mesh" -> effects = "foo" => condition 'warped-200': unknown effect 'foo'
warp = "mesh" -> warp = "auto" => condition 'warped-200': warp auto chooses what fits into a budget
warp = "mesh" -> fused = 1 => condition 'warped-200': fused is 1: expected true or false
warp = "mesh" -> size = "96x96" => part.condition.size is the same for all conditions
warp = "mesh" -> full-screen = true => part.condition.full-screen is the same for all conditions
warp = "mesh" -> seconds = 3 => condition 'warped-200': seconds is no setting of a condition: how long
warp = "mesh" -> link-seed = 1⏎»link_seed = 1 => link_seed comes twice, with - and with _
guard = 1.2 -> guard = 1000 => condition 'warped-200': guard 1000
guard = 1.2 -> guard = "auto" => condition 'warped-200': guard auto looks at the whole trace first
guard = 1.2 -> guard = 1.2⏎reference = true => reference is true a second time in this part @ reference = true⏎⏎[[part]]
loss = 0.02 -> loss = 2 => condition 'a': loss '2': expected a share of the frames
jitter = 'uniform:20' -> jitter = 'gauss:20' => condition 'b': unknown delay model 'gauss
jitter = 'uniform:20' -> jitter = 'uniform:2000' => condition 'b'
jitter = 'uniform:20' -> codec = 'av2' => condition 'b': unknown codec 'av2'
jitter = 'uniform:20' -> crf = 70⏎codec = 'h264' => condition 'b': crf 70: expected 0 (best) to 51
jitter = 'uniform:20' -> mirrors = 'glass' => condition 'b': unknown kind of mirrors 'glass': known are geometry, screen
scene = "planes" -> scene = "plains" => unknown scene 'plains': did you mean 'planes'?
scene = "planes" -> scene = "absent.glb" => absent.glb: no such file
size = "96x120" -> size = "96" => size '96': expected WIDTHxHEIGHT
size = "96x120" -> headset = "rift" => unknown headset 'rift'
size = "96x120" -> lens = "radial"⏎»headset = "flat-90" => headset 'flat-90' has no lens
[common] -> [common]⏎»late = 1 => common: unknown setting 'late'
part = "run-1"⏎pairs -> part = "run-3"⏎pairs => family.part is 'run-3': expected run-1 or run-2
part = "run-1"⏎pairs -> pairs => the key family.part is missing @ [[family]]
["late-200", "warped-200"], -> ["late-200", "warped-20"],
    => family.pairs has an unknown condition 'warped-20': did you mean
["late-200", "warped-200"], -> ["late-200"], => family.pairs has ['late-200']: expected pairs of names
["late-200", "reference"], -> ["late-200", "late-200"], => a condition beside itself
["late-200", "reference"], -> ["warped-200", "late-200"], => the same pair a second time
pairs = [ -> compare = [ {better = 'reference', baseline = 'late'} ]⏎pairs = [ => an unknown condition
pairs = [ -> compare = [ {better = 'late-200'} ]⏎pairs = [ => the key family.compare.baseline is miss
pairs = [ -> compare = []⏎pairs = [ => family.compare is empty: expected compare = [{ better
pairs = [ -> compare = [{better = 'late-200', baseline = 'warped-200'}]⏎pairs = [
    => has 'warped-200' over 'late-200': the same pair a second time @ ["late-200", "warped-200"],
[[part.condition]]⏎name = "late -> [part.condition]⏎name = "late => this is no TOML @ [[part.condition]]⏎name = "warped
[[family]] -> [[condition]]⏎name = 'x'⏎[[family]] => condition beside [[part]]: expected it within one
seed = 7 -> seed =  => this is no TOML: Invalid value (column 8)
"""


def test_a_plan_names_the_better_condition_and_its_baseline():
    pairs = WHOLE[WHOLE.index("pairs = [") :]
    compare = """compare = [
  { better = "warped-200", baseline = "late-200" },
  { better = "reference", baseline = "late-200" },
]
"""
    assert read(WHOLE.replace(pairs, compare)).families == read(WHOLE).families
    with pytest.raises(InputError, match="has no comparison: expected compare ="):
        read(WHOLE.replace(pairs, ""))


@pytest.mark.parametrize("entry", table(BROKEN))
def test_wrong_input_is_refused_with_its_line(entry):
    check_refused(entry, WHOLE, read, "study.toml")


def test_one_condition_has_no_order():
    text = WHOLE.replace("[[part.condition]]\nname = \"b\"\njitter = 'uniform:20'\n", "")
    with pytest.raises(InputError, match=r"study\.toml:14: trial\.order is williams .* one condition has no order"):
        read(text)
    assert read(text.replace('"williams"', '"fixed"')).order == "fixed"
    with pytest.raises(InputError, match=r"the key part\.condition is missing: is conditions meant to be condition\?"):
        read(text.replace("[[part.condition]]", "[[part.conditions]]"))
    with pytest.raises(InputError, match=r"the key part\.condition is missing"):
        read(text[: text.index("[[part.condition]]")])


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


def is_read_or_refused(text: str) -> None:
    try:
        assert isinstance(read(text), Design)
    except InputError as error:
        assert str(error).startswith("study.toml:") and "\n" not in str(error)


@settings(max_examples=150)
@given(st.integers(0, len(WHOLE) - 1), st.text(max_size=6))
def test_a_few_characters_overwritten_anywhere(at, put):
    is_read_or_refused(WHOLE[:at] + put + WHOLE[at + len(put) :])


LINES = WHOLE.splitlines()
NUMBERS = ["-1", "0", "1.5", "nan", "1e400", "0x" + "f" * 5000, "9" * 30]
OTHERS = ['""', '"x"', '"a\\nb"', '"auto"', "true", "[]", "[[]]", '["x"]', "{}", "2001-01-01"]
VALUES = st.sampled_from(NUMBERS + OTHERS)


@settings(max_examples=250)
@given(st.integers(0, len(LINES) - 1), VALUES)
def test_any_value_of_any_kind_for_any_key(number, value):
    key, equals, _ = LINES[number].partition(" = ")
    lines = [*LINES[:number], f"{key} = {value}" if equals else value, *LINES[number + 1 :]]
    is_read_or_refused("\n".join(lines))


@settings(max_examples=100)
@given(st.lists(st.sampled_from(LINES), max_size=60))
def test_lines_in_any_order(lines):
    is_read_or_refused("\n".join(lines))


@settings(max_examples=100)
@given(st.sets(st.integers(0, len(LINES) - 1).filter(lambda number: not LINES[number].startswith("scene")), max_size=4))
def test_lines_left_out(gone):
    """But for the scene: the usual one takes a second to load."""
    is_read_or_refused("\n".join(line for number, line in enumerate(LINES) if number not in gone))


def test_nesting_without_end_is_refused():
    is_read_or_refused(f"a = {'[' * 5000}")
    is_read_or_refused(WHOLE + "x = " + "[" * 300 + "]" * 300)
