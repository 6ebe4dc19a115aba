"""hmdwarp study plan, as a person and as a program see it."""

from __future__ import annotations

import json

import pytest
from commands import hmdwarp
from typer.testing import CliRunner

from hmdwarp.cli.study import app
from hmdwarp.errors import HmdwarpError

from .plans import WHOLE


def run(*arguments: object) -> str:
    """Standard output of the command in 80 columns; its error if it raised one."""
    result = CliRunner().invoke(app, ["plan", *map(str, arguments)], env={"COLUMNS": "80"})
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    assert result.exit_code == 0, result.output
    return result.stdout


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(WHOLE, encoding="utf-8")
    return path


def test_the_outline_fits_80_columns(study):
    out = run(study, "--orders")
    lines = out.splitlines()
    assert max(map(len, lines)) <= 80 and not any(line.endswith(" ") for line in lines)
    told = " ".join(out.split())
    for text in (
        "Everything at once",
        "both see only numbers of trials",
        "Williams design, seed 7",
        "60 s first, not scored: scene planes, size 96x120, latency 10, warp none, fill none",
        "fms after every trial; ends the session at 15 or more or at 8 worse than at first",
        "Part run-1: 3 conditions",
        "2 warped-200 latency 200, warp mesh, guard 1.2; by default fill memory+pyramid, predict cautious",
        "3 reference latency 0; by default warp iterative, fill memory+pyramid, guard 1.5, predict cautious (the "
        "hidden reference)",
        "1 a loss 0.02; by default latency 200, warp iterative, fill memory+pyramid, guard 1.5, predict cautious",
        "all scene planes, size 96x120",
        "trials 4 min 6 of 20 s, each rated: grade, acr, fms",
        "each condition in each place 4 times",
        "balanced with 6, 12, 18 .. complete sessions",
        "order 6:",
        "1 = very good",
        "high is good",
        "warped-200 over late-200, reference over late-200",
        "fewer than 7 people",
        "no condition is a hidden reference",
    ):
        assert text in told, text


def test_programs_get_json(study):
    told = json.loads(run(study, "--json"))
    assert told["name"] == "whole" and len(told["parts"][0]["orders"]) == 6
    assert told["parts"][0]["session_seconds"] == sum(step["seconds"] for step in told["parts"][0]["session"])


@pytest.mark.parametrize("order", ["fixed", "random"])
def test_other_orders(study, order):
    study.write_text(WHOLE.replace('"williams"', f'"{order}"'), encoding="utf-8")
    out = run(study, "--orders")
    assert ("there is one order" in out) == (order == "fixed")
    assert (".. and 960 more" in out) == (order == "random")


def test_a_wrong_plan_ends_with_status_2_and_one_line(study):
    study.write_text(WHOLE.replace("latency = 200", "latency = -200", 1), encoding="utf-8")
    with pytest.raises(HmdwarpError) as caught:
        run(study)
    assert caught.value.exit_status == 2
    done = hmdwarp("study", "plan", study)
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith(f"hmdwarp: {study}:") and done.stderr.count("\n") == 1
    assert "condition 'late-200': latency -200 ms: expected a finite number of at least 0 ms" in done.stderr
