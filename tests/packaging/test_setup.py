"""Set-up on machines that lack things, played with a PATH of stand-ins."""

from __future__ import annotations

import importlib.util
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
    """A PATH that holds only what every system has, a compiler, and no Python."""
    place = tmp_path / "bin"
    place.mkdir()
    for name in ("sh", "dirname", "make", "sed", "awk"):
        found = shutil.which(name)
        if found:
            (place / name).symlink_to(found)
    stand_in(place / "c++", "exit 0")
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


def test_extras_need_a_compiler(clone, tools):
    (tools / "c++").unlink()
    done = setup(clone, tools, PYTHON=sys.executable)
    assert done.returncode == 3
    assert "has to be compiled" in done.stderr and "g++ python3" in done.stderr


def test_a_folder_that_is_no_environment_is_left_alone(clone, tools):
    (clone / ".venv").mkdir()
    (clone / ".venv" / "notes.txt").write_text("mine", encoding="utf-8")
    done = setup(clone, tools, PYTHON=sys.executable)
    assert done.returncode == 3
    assert ".venv is there but is no virtual environment" in done.stderr
    assert (clone / ".venv" / "notes.txt").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("leftover", ["half-made", "dead"])
def test_a_broken_environment_is_made_anew(clone, tools, leftover):
    """Interrupted, or its Python is gone; without an index, set-up ends in one line saying so."""
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
        "PIP_INDEX_URL": "http://127.0.0.1:9/", "PIP_RETRIES": "0", "PIP_CONFIG_FILE": os.devnull, "HOME": str(clone),
    }  # fmt: skip
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


# --- programs for tests ------------------------------------------------------------------------


@pytest.fixture
def machine(tmp_path, tools, monkeypatch):
    """Return set-up's module on a machine without tools; tmp_path/calls has the calls of apt-get.

    Its package lists hold what `known` names; `apt-get update` brings the rest of `lists`.
    """
    spec = importlib.util.spec_from_file_location("hmdwarp_setup", ROOT / ".ci" / "setup.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    for name in ("env", "grep", "cp", "touch", "chmod", "ln"):
        (tools / name).symlink_to(shutil.which(name))
    stand_in(tools / "apt-cache", f'exec grep -qx "$2" {tmp_path}/known')
    stand_in(tools / "apt-get", f"""
      echo "$@" >> {tmp_path}/calls
      for word; do case $word in
        update) cp {tmp_path}/lists {tmp_path}/known; exit 0;;
        install) installing=1;;
        -*|DPkg*) ;;
        *) [ -z "$installing" ] || grep -qx "$word" {tmp_path}/known || exit 100;;
      esac; done
      for word; do case $word in
        xvfb) ln -sf /bin/true {tools}/Xvfb;;
        glslang-tools) ln -sf /bin/true {tools}/glslangValidator;;
      esac; done""")  # fmt: skip
    monkeypatch.setenv("PATH", str(tools))
    monkeypatch.setattr(os, "geteuid", lambda: 0)
    packages = {"Xvfb": "xvfb", "glslangValidator": "glslang-tools", "chromium": "chromium"}
    monkeypatch.setattr(module, "TOOLS", tmp_path / "tools.toml")
    module.TOOLS.write_text(
        "[packages]\n" + "".join(f'{name} = "{package}"\n' for name, package in packages.items())
        + '[other_names]\nchromium = ["chrome"]\n', encoding="utf-8"
    )  # fmt: skip
    return module


@pytest.mark.parametrize("fresh", [True, False])
def test_tools_are_installed_although_one_is_in_no_package_list(machine, tmp_path, capfd, fresh):
    """As on Ubuntu, which has no package of Chromium; fresh containers and used machines."""
    (tmp_path / "lists").write_text("xvfb\nglslang-tools\n", encoding="utf-8")
    (tmp_path / "known").write_text("" if fresh else "xvfb\nglslang-tools\n", encoding="utf-8")
    machine.install_for_tests()
    assert machine.missing_tools() == {"chromium": "chromium"}
    assert "going on without chromium;" in capfd.readouterr().out.splitlines()[-1]


def test_another_name_of_a_tool_will_do(machine, tmp_path, tools):
    (tmp_path / "known").write_text("xvfb\nglslang-tools\nchromium\n", encoding="utf-8")
    stand_in(tools / "chrome", "")
    machine.install_for_tests()
    assert "chromium" not in (tmp_path / "calls").read_text(encoding="utf-8")
    assert machine.missing_tools() == {}


def test_a_driver_is_there_where_its_file_is(machine, tmp_path):
    with machine.TOOLS.open("a", encoding="utf-8") as file:
        file.write(f'[files]\nchromium = ["{tmp_path}/icd.d/lvp_icd*.json"]\n')
    assert "chromium" in machine.missing_tools()
    (tmp_path / "icd.d").mkdir()
    (tmp_path / "icd.d" / "lvp_icd.x86_64.json").touch()
    assert "chromium" not in machine.missing_tools()


def test_without_rights_the_line_to_type_is_printed_and_set_up_goes_on(machine, tmp_path, monkeypatch, capfd):
    (tmp_path / "known").write_text("xvfb\nglslang-tools\nchromium\n", encoding="utf-8")
    monkeypatch.setattr(os, "geteuid", lambda: 1000)
    machine.install_for_tests()
    said = capfd.readouterr().out
    assert "su -c 'apt-get update && apt-get install -y chromium glslang-tools xvfb'" in said
    assert not (tmp_path / "calls").exists()


def test_a_complete_machine_gets_no_message(machine, tools, capfd):
    for name in ("Xvfb", "glslangValidator", "chromium"):
        stand_in(tools / name, "")
    machine.install_for_tests()
    assert capfd.readouterr().out == ""


def test_only_the_tests_bring_tools_for_tests(clone):
    """`make replay` sets up what replaying needs."""
    for target, wanted in (("replay", False), ("setup", False), ("test", True)):
        command = ["make", "-n", "--no-print-directory", target]
        done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=clone)
        assert ("setup --tests" in done.stdout) == wanted, target
        assert ("setup --base" in done.stdout) == (target == "replay"), target


def test_what_has_all_extras_is_ready_without_them_too(machine, tmp_path, monkeypatch):
    monkeypatch.setattr(machine, "STATE", tmp_path / "state")
    for has_base_alone, ready in ((True, (True, False)), (False, (True, True))):
        machine.STATE.write_text(machine.wanted_state(has_base_alone), encoding="utf-8")
        assert (machine.is_ready(base=True), machine.is_ready(base=False)) == ready
