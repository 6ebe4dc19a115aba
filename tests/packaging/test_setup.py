"""Set-up on machines that lack things, played with a PATH of stand-ins; the real thing is tried on bare Debian roots by hand."""

from __future__ import annotations

import os
import shutil
import stat
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture
def clone(tmp_path) -> Path:
    """A checkout with no .venv: only what set-up reads."""
    place = tmp_path / "clone"
    shutil.copytree(ROOT / ".ci", place / ".ci")
    for name in ("pyproject.toml", "Makefile"):
        shutil.copy(ROOT / name, place)
    return place


@pytest.fixture
def tools(tmp_path) -> Path:
    """A PATH that holds only what every system has, and no Python."""
    place = tmp_path / "bin"
    place.mkdir()
    for name in ("sh", "dirname", "make", "sed", "awk"):
        found = shutil.which(name)
        if found:
            (place / name).symlink_to(found)
    return place


def stand_in(place: Path, script: str) -> None:
    place.write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    place.chmod(place.stat().st_mode | stat.S_IXUSR)


def setup(clone: Path, tools: Path, **env: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [clone / ".ci" / "setup"], check=False, capture_output=True, text=True, env={"PATH": str(tools), **env}
    )


def test_python_too_old(clone, tools):
    stand_in(tools / "python3", '[ "$1" = --version ] && echo Python 3.9.2 || exit 1')
    done = setup(clone, tools)
    assert done.returncode == 3
    assert "needs Python 3.11 or newer, found: Python 3.9.2" in done.stderr
    assert done.stderr.splitlines()[-1].strip().startswith("make PYTHON=")


def test_python_too_old_where_apt_has_a_newer_one(clone, tools):
    stand_in(tools / "python3", '[ "$1" = --version ] && echo Python 3.10.12 || exit 1')
    stand_in(tools / "apt-cache", '[ "$2" = python3.11 ]')
    done = setup(clone, tools)
    assert done.returncode == 3
    assert done.stderr.splitlines()[-1].strip() == "sudo apt-get install -y python3.11 python3.11-venv"


def test_python_too_old_and_no_package_lists_yet(clone, tools):
    stand_in(tools / "python3", '[ "$1" = --version ] && echo Python 3.10.12 || exit 1')
    stand_in(tools / "apt-cache", "exit 100")
    stand_in(tools / "apt-get", "exit 0")
    done = setup(clone, tools)
    assert done.returncode == 3
    assert done.stderr.splitlines()[-1].strip().startswith("sudo apt-get update")


def test_no_python_at_all(clone, tools):
    done = setup(clone, tools)
    assert done.returncode == 3
    assert "found: none" in done.stderr


def test_a_folder_that_is_no_environment_is_left_alone(clone, tools):
    (clone / ".venv").mkdir()
    (clone / ".venv" / "notes.txt").write_text("mine", encoding="utf-8")
    done = setup(clone, tools, PYTHON=sys.executable)
    assert done.returncode == 3
    assert ".venv is there but is no virtual environment" in done.stderr
    assert (clone / ".venv" / "notes.txt").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("leftover", ["half-made", "dead"])
def test_a_broken_environment_is_made_anew(clone, tools, leftover):
    """Interrupted, or its Python is gone. The index is nowhere, so set-up ends in one line about the network."""
    (clone / ".venv" / "bin").mkdir(parents=True)
    (clone / ".venv" / "pyvenv.cfg").write_text("home = nowhere\n", encoding="utf-8")
    if leftover == "half-made":
        (clone / ".venv" / "hmdwarp-setup").write_text("half-made", encoding="utf-8")
        (clone / ".venv" / "bin" / "python").symlink_to(sys.executable)
    else:
        (clone / ".venv" / "bin" / "python").symlink_to("nowhere/python3")
    stale = clone / ".venv" / "stale.txt"
    stale.touch()
    unreachable = {
        "PIP_INDEX_URL": "http://127.0.0.1:9/",
        "PIP_RETRIES": "0",
        "PIP_CONFIG_FILE": os.devnull,
        "HOME": str(clone),
    }
    done = setup(clone, tools, PYTHON=getattr(sys, "_base_executable", sys.executable), **unreachable)
    assert done.returncode == 3
    assert "making it anew" in done.stdout
    assert not stale.exists()
    (line,) = done.stderr.splitlines()
    assert line.startswith("setup: cannot reach the package index")


def test_make_alone_lists_the_targets(clone):
    done = subprocess.run(["make", "--no-print-directory"], check=False, capture_output=True, text=True, cwd=clone)
    assert done.returncode == 0, done.stderr
    assert {"make setup", "make replay", "make test"} <= {
        line.strip().split("  ")[0] for line in done.stdout.splitlines()
    }
