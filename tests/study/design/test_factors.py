"""Conditions that cross several values of a setting."""

from __future__ import annotations

from together import together

from hmdwarp.study.design import Design, design_from_text

from ..refusals import check_refused, table

PLAN = """schema = 1
name = "s"
title = "S"
[common]
scene = "planes"
size = "96x120"
[trial]
scales = ["acr"]
[[condition]]
latency = [200, 400]
warp = ["forward", "none"]
fill = "none"
[[condition]]
name = "reference"
latency = 0
warp = "none"
fill = "none"
reference = true
[[family]]
name = "a warp against none"
pairs = [["latency200-none", "latency200-forward"]]
"""
NAMES = ["latency200-forward", "latency200-none", "latency400-forward", "latency400-none", "reference"]


def read(*changes: tuple[str, str]) -> Design:
    text = PLAN
    for found, put in changes:
        assert found in text
        text = text.replace(found, put)
    return design_from_text(text, "study.toml")


def names(design: Design) -> list[str]:
    return [condition.name for condition in design.parts[0].conditions]


def test_lists_of_values_are_crossed():
    design = read()
    assert names(design) == NAMES
    settings = [dict(condition.settings) for condition in design.parts[0].conditions[:4]]
    assert [(setting["latency"], setting["warp"], setting["fill"]) for setting in settings] == [
        (200, "forward", "none"), (200, "none", "none"), (400, "forward", "none"), (400, "none", "none"),
    ]  # fmt: skip


def test_a_condition_s_own_name_comes_first_and_values_become_plain_words():
    factors = 'name = "x"\nwarp = ["mesh:cut=vertex"]\nguard = [1, 1.5]\nfused = [false]'
    a, b = "x-mesh-cut-vertex-guard1-no-fused", "x-mesh-cut-vertex-guard1.5-no-fused"
    design = read(
        ('latency = [200, 400]\nwarp = ["forward", "none"]', factors), ("latency200-none", a), ("latency200-forward", b)
    )
    assert names(design) == [a, b, "reference"]


WRONG = r"""
[200, 400] -> [200, 400, 200] => makes a second condition 'latency200-forward'
name = "reference" -> name = "latency400-none" => a second time
[200, 400] -> [] => is an empty list
[200, 400] -> MANY
    => makes 118 combinations: expected 100 conditions at most
"forward", "none"] -> "forward", "nnone"] => nnone
"forward", "none"] -> "forward", [1]] => has [1]: expected texts, numbers
fill = "none"⏎[[c -> reference = true⏎[[c => expected one hidden reference
"""


@together("entry", table(WRONG.replace("MANY", str([*range(1, 60)]))))
def test_impossible_combinations_are_refused_with_their_line(entry):
    check_refused(entry, PLAN, lambda wrong: design_from_text(wrong, "study.toml"), "study.toml")
