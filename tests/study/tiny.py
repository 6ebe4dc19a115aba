"""A study as small as one can be that has everything in it, its simulated people, and the real
command that runs it.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest
from commands import hmdwarp

from .plans import text_of
from .session.conftest import hurry

ROOT = Path(__file__).resolve().parents[2]
PATIENCE_S = 600  # against hanging; nothing here takes a tenth of it on an idle machine

STUDY = text_of("tiny")


def write(folder: Path, **people: float) -> tuple[Path, Path]:
    """The study's file and the model's. people: other values than those of the model."""
    study, model = folder / "tiny.toml", folder / "people.toml"
    study.write_text(STUDY)
    text = text_of("tiny-people")
    for name, value in people.items():
        text = re.sub(rf"^{name} = .*", f"{name} = {value}", text, flags=re.MULTILINE)
    model.write_text(text)
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
