"""Without the modules of POSIX, as on Windows, and without the packages of extras.

It is still Linux that this runs on: what Windows does differently beside that is not tested.
"""

from __future__ import annotations

import subprocess
import sys

import pytest

TAKEN = ("fcntl", "termios", "resource", "pty", "tty", "pwd", "grp", "syslog", "readline")
# What the extras bring beside Python's own; tests alone need scikit-image.
EXTRAS = ("av", "xr", "trimesh", "skimage", "cv2", "pyarrow", "statsmodels", "zmq", "rosbags", "meshoptimizer")
_FUNCTIONS = ("O_PATH", "O_NOFOLLOW", "posix_fallocate", "sysconf", "nice")
_AWAY = """
import os, sys
sys.modules.update(dict.fromkeys({}))
for name in {}:
    delattr(os, name)
"""
_THEIRS = ("pexpect", "ptyprocess")  # Other libraries that have no Windows, or load POSIX's modules themselves on Linux


# Each argument is a command line; on stderr stands how each ended.
_COMMANDS = """
from hmdwarp.cli import main
for line in sys.argv[1:]:
    sys.argv[1:] = line.split()
    try:
        main()
    except SystemExit as left:
        print("ended", left.code or 0, file=sys.stderr)
"""
_SMALL = "replay walk --headset rift-dk1 --scene planes --size 48x40 --seconds 0.1 --workers 0"


def start(taken: tuple[str, ...], script: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-c", _AWAY.format(taken, _FUNCTIONS) + script, *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def run(script: str, *arguments: str, taken: tuple[str, ...] = TAKEN) -> str:
    done = start(taken, script, *arguments)
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
    run(_COMMANDS, f"{_SMALL} --out {tmp_path / 'out'}", taken=(*TAKEN, *EXTRAS))
    assert (tmp_path / "out" / "summary.json").is_file()


_NEED_NONE = ("study plan quick", "trace info walk", "list formats")
_NEED = {
    f"{_SMALL} --video": "video",
    f"{_SMALL} --codec h264": "video",
    "live --source openxr --seconds 1": "openxr",
    f"{_SMALL} --scene box.ply": "scenes",
    f"{_SMALL} --scene spheres --fill model": "reduce",
}


def test_an_extra_is_asked_for_by_one_line_where_it_is_needed(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    faces = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n"
    header = f"ply\nformat ascii 1.0\n{faces}property list uchar int vertex_indices\nend_header\n"
    (tmp_path / "box.ply").write_text(f"{header}0 0 -1\n1 0 -1\n0 1 -1\n3 0 1 2\n", encoding="ascii")
    done = start(EXTRAS, _COMMANDS, *_NEED_NONE, *_NEED)
    assert done.stderr.startswith("ended 0\n" * len(_NEED_NONE)) and "Traceback" not in done.stderr, done.stderr
    ended = done.stderr.split("ended 0\n")[-1].split("ended 3\n")
    assert len(ended) == len(_NEED) + 1, done.stderr
    for text, extra in zip(ended, _NEED.values(), strict=False):
        assert f"pip install '.[{extra}]'" in text.splitlines()[-1], text
