"""hmdwarp study plan, as a person and as a program see it."""

from __future__ import annotations

import pytest
from commands import hmdwarp

from .plans import WHOLE


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "s.toml"
    path.write_text(WHOLE, encoding="utf-8")
    return path


@pytest.mark.parametrize("order", ["fixed", "random"])
def test_other_orders(study, order):
    study.write_text(WHOLE.replace('"williams"', f'"{order}"'), encoding="utf-8")
    out = hmdwarp("study", "plan", study, "--orders").stdout
    assert ("there is one order" in out) == (order == "fixed")
    assert (".. and 960 more" in out) == (order == "random")


def test_a_wrong_plan_ends_with_status_2_and_one_line(study):
    study.write_text(WHOLE.replace("latency = 200", "latency = -200", 1), encoding="utf-8")
    done = hmdwarp("study", "plan", study)
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith(f"hmdwarp: {study}:") and done.stderr.count("\n") == 1
    assert "condition 'late-200': latency -200 ms: expected a finite number of at least 0 ms" in done.stderr
