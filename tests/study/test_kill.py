"""The whole program, killed at random moments.

No confirmed answer is missing or doubled, and the session goes on where it was.

STUDY_KILLS (12) says how many, STUDY_KILL_SEED which moments; `make test-kill` does 500.
"""

from __future__ import annotations

import os

import pytest

from .killing import Killed, faults

KILLS = int(os.environ.get("STUDY_KILLS", "12"))
SEED = int(os.environ.get("STUDY_KILL_SEED", "1"))


@pytest.mark.slow(20)
def test_killing_the_program_loses_nothing(tmp_path, capsys):
    killed = Killed(tmp_path, SEED, KILLS)
    killed.run()
    assert not faults(killed), f"STUDY_KILL_SEED={SEED}"
    answers = sum(line[0] == "answer" for line in killed.told)
    with capsys.disabled():
        told = ", ".join(f"{count} {phase}" for phase, count in sorted(killed.tally.items()))
        sessions = f"{len(killed.codes)} sessions, {answers} confirmed answers"
        print(f"\n{sum(killed.tally.values())} kills, seed {SEED} ({told}): {sessions}, all there once")
