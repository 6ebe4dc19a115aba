"""Without a root for the tests with a real OpenXR runtime they are skipped, and nothing stays."""

from __future__ import annotations

import fcntl
import os
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest
from openxr import root

PROJECT = Path(__file__).resolve().parents[2]


@pytest.fixture
def folder(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("HMDWARP_MONADO_ROOT", str(tmp_path / "roots"))
    return tmp_path / "roots"


@pytest.fixture
def allowed(monkeypatch) -> None:
    """As on a machine where root may do everything."""
    monkeypatch.setattr(root, "_check_rights", lambda: None)


def test_without_rights_the_tests_are_skipped_with_the_reason(folder):
    """Nobody may; who runs this as root becomes nobody first."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/openxr"]
    if os.geteuid() == 0:
        if not shutil.which("setpriv"):
            pytest.skip("there is no setpriv (util-linux) to become nobody with")
        command = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups", *command]
        if subprocess.run(
            [*command[:4], sys.executable, "-c", "import hmdwarp"], check=False, cwd=PROJECT, capture_output=True
        ).returncode:
            pytest.skip("nobody but root may read this checkout")
    done = subprocess.run(command, check=False, cwd=PROJECT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Monado's root needs Linux and root's rights" in done.stdout
    assert " skipped" in done.stdout and " passed" not in done.stdout
    assert not folder.exists()


def test_where_root_may_not_mount(monkeypatch, folder, tmp_path):
    stand_in(monkeypatch, tmp_path, "unshare", "echo 'unshare: unshare failed: Operation not permitted' >&2; exit 1")
    stand_in(monkeypatch, tmp_path, "apt-get", "exit 0")
    monkeypatch.setattr(root.os, "geteuid", lambda: 0)
    with pytest.raises(root.Lacking, match="does not let root mount .*Operation not permitted"):
        root.ready_root()


@pytest.mark.parametrize("culprit", ["mmdebstrap", "pip"])
def test_a_build_that_fails_says_why_and_leaves_nothing(monkeypatch, folder, tmp_path, allowed, culprit):
    failing = "mkdir -p half-made; echo 'E: cannot reach the mirror' >&2; exit 1"
    stand_in(monkeypatch, tmp_path, "mmdebstrap", failing if culprit == "mmdebstrap" else "exit 0")
    stand_in(monkeypatch, tmp_path, "apt-config", "exit 0")
    script = "mkdir -p $0; " + (
        "echo 'ERROR: cannot reach the index'; echo more; exit 1" if culprit == "pip" else "exit 0"
    )
    monkeypatch.setattr(root, "_pip", lambda target: ["sh", "-c", script, str(target)])
    with pytest.raises(root.Lacking, match=rf"{culprit} failed \((E|ERROR): cannot reach"):
        root.ready_root()
    assert {path.suffix for path in folder.iterdir()} == {".lock"}


def test_a_root_is_built_once_and_who_waits_for_a_failure_does_not_try_again(monkeypatch, folder, allowed):
    built = []

    def build(place: Path) -> None:
        built.append(place)
        place.mkdir()

    monkeypatch.setattr(root, "_build", build)
    assert root.ready_root() == root.ready_root() == built[0]
    assert len(built) == 1
    built[0].rmdir()

    with built[0].with_suffix(".lock").open("w") as other:
        fcntl.flock(other, fcntl.LOCK_EX)
        said: list[str] = []
        waiting = threading.Thread(target=lambda: said.append(lacking()))
        waiting.start()
        time.sleep(0.2)
        assert waiting.is_alive()
    waiting.join(60)
    assert "by another process" in said[0]
    assert len(built) == 1


def lacking() -> str:
    with pytest.raises(root.Lacking) as error:
        root.ready_root()
    return str(error.value)


def stand_in(monkeypatch, tmp_path: Path, name: str, script: str) -> None:
    """A program of that name, first in PATH."""
    place = tmp_path / "bin"
    place.mkdir(exist_ok=True)
    (place / name).write_text(f"#!/bin/sh\ncd {tmp_path}\n{script}\n", encoding="utf-8")
    (place / name).chmod(0o755)
    if str(place) not in os.environ["PATH"]:
        monkeypatch.setenv("PATH", f"{place}:{os.environ['PATH']}")
