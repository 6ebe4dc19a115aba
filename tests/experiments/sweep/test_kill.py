"""A worker, a scheduler and a driver killed in mid-run: no case is lost, none doubled.

SWEEP_KILLS (3) says how many, SWEEP_KILL_SEED which moments; `make test-kill` does 41.
"""

from __future__ import annotations

import os
import random

import pytest

pytest.importorskip("distributed")

from .killing import VICTIMS, kill_in

KILLS = int(os.environ.get("SWEEP_KILLS", "3"))
SEED = int(os.environ.get("SWEEP_KILL_SEED", "1"))


@pytest.mark.slow(30)
@pytest.mark.parametrize("number", range(KILLS))
def test_a_kill_loses_no_case_and_doubles_none(number, tmp_path):
    chance = random.Random(1000 * SEED + number)
    assert not kill_in(VICTIMS[number % len(VICTIMS)], tmp_path / "out", chance), f"SWEEP_KILL_SEED={SEED}"
