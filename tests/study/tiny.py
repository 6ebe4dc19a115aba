"""A study as small as one can be that has everything in it, its simulated people, and the real
command that runs it.
"""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from commands import hmdwarp

from .plans import text_of
from .session.conftest import hurry

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 600  # against hanging; nothing here takes a tenth of it on an idle machine

STUDY = text_of("tiny")

MODEL = """schema = 1
title = "test people"
[rating.grade]
people_sd = 0.5
condition_sd = 0.2
noise_sd = 0.3
drift = 0.02
carry_over = -0.05
missing = {missing}
[rating.grade.means]
late = 4.5
turned = 3.6
warped = 2.8
reference = 1.8
[sickness]
start = 0.02
per_trial = {sickening}
people_sd = {easily_sick}
noise_sd = 0.03
[sessions]
dropout = {dropout}
pause = {pause}
again = {again}
[answers]
median_s = 0.1
"""

# Nobody leaves.
USUAL = {"missing": 0.05, "dropout": 0.0, "pause": 0.1, "again": 0.1, "sickening": 0.02, "easily_sick": 0.5}


def write(folder: Path, **people: float) -> tuple[Path, Path]:
    """The study's file and the model's. people: other values of USUAL."""
    study, model = folder / "tiny.toml", folder / "people.toml"
    study.write_text(STUDY)
    model.write_text(MODEL.format(**{**USUAL, **people}))
    return study, model


def session(study: Path, model: Path, code: str, *more: str) -> list[str]:
    """The arguments of one."""
    display = ("--source", "offscreen", "--trace", "walk", "--console", "none")
    return ["study", "run", str(study), "--participant", code, "--simulate", str(model), *display, *more]


def program(*arguments: object) -> subprocess.CompletedProcess[str]:
    """Run the command in this process, people's waits short; what it says, and its exit status."""
    with pytest.MonkeyPatch.context() as patch:
        hurry(patch)
        return hmdwarp(*arguments)


def ran(*arguments: object) -> str:
    """Run a command that must do what it is asked; its standard output."""
    done = program(*arguments)
    assert done.returncode == 0, f"{arguments}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout
