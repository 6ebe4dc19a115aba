"""Without the modules of POSIX, as on Windows: all is imported, and a replay runs.

It is still Linux that this runs on: what Windows does differently beside that is not tested.
"""

from __future__ import annotations

import subprocess
import sys

import pytest

TAKEN = ("fcntl", "termios", "resource", "pty", "tty", "pwd", "grp", "syslog", "readline")
_AWAY = f"import sys; sys.modules.update(dict.fromkeys({TAKEN}))\n"
# Other libraries that have no Windows, or load POSIX's modules themselves on Linux.
_THEIRS = ("textual", "pexpect", "ptyprocess")


def run(script: str, *arguments: str) -> str:
    command = [sys.executable, "-c", _AWAY + script, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_every_module_can_be_imported():
    found = run(
        """
import importlib, pkgutil, traceback, hmdwarp
for module in pkgutil.walk_packages(hmdwarp.__path__, "hmdwarp."):
    if module.name.endswith("__main__"):
        continue
    try:
        importlib.import_module(module.name)
    except ImportError as error:
        frames = traceback.extract_tb(error.__traceback__)
        print(module.name, next((frame.filename for frame in frames[::-1] if "importlib" not in frame.filename), ""))
"""
    )
    ours = [line for line in found.splitlines() if not any(f"site-packages/{name}" in line for name in _THEIRS)]
    assert ours == []


@pytest.mark.slow(10)
def test_a_replay_runs(tmp_path):
    run(
        "from hmdwarp.cli import main; main()",
        *("replay", "walk", "--scene", "planes", "--size", "48x40", "--seconds", "0.1", "--workers", "0"),
        *("--out", str(tmp_path / "out")),
    )
    assert (tmp_path / "out" / "summary.json").is_file()
