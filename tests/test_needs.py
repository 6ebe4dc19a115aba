"""A run names what it left out, and how to get it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import needs
import pytest

ROOT = Path(__file__).resolve().parents[1]


def test_omitted_tests_are_reported_in_one_line():
    """Each remedy once, with all that it brings; other skips are no lack."""
    skipped = [
        ("a", "Skipped: " + needs.missing("Xvfb", needs.APT + "xvfb")),
        ("b", "Skipped: " + needs.missing("Xvfb", needs.APT + "xvfb")),
        ("b", "Skipped: " + needs.missing("Xvfb", needs.APT + "xvfb")),
        ("c", "Skipped: " + needs.missing("chromium", needs.APT + "chromium")),
        ("d", "Skipped: " + needs.missing("OpenXR runtime", "needs root,\nwhich needs a password (sudo)")),
        ("e", "Skipped: root may write anywhere"),
    ]
    assert needs.left_out(skipped) == (
        "left out: 3 for lack of Xvfb, chromium (Debian, Ubuntu: sudo apt-get install chromium xvfb); "
        "1 for lack of OpenXR runtime (needs root, which needs a password (sudo))"
    )
    assert needs.left_out(skipped[-1:]) is None


@pytest.mark.parametrize("last", [False, True])
def test_a_run_says_it_before_or_after_the_closing_line(tmp_path, last):
    """Before it where CI reads the counts from the last line."""
    env = {name: value for name, value in os.environ.items() if name != "LEFT_OUT"}
    env["PATH"] = str(tmp_path)  # an empty folder: no program at all
    test = "tests/client/test_forward.py::test_the_one_pass_shader_is_valid_glsl"
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", test],
        cwd=ROOT, env={**env, **({"LEFT_OUT": "last"} if last else {})}, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    line = "left out: 2 for lack of glslangValidator (Debian, Ubuntu: sudo apt-get install glslang-tools)"
    lines = done.stdout.splitlines()
    assert lines.count(line) == 1
    assert (lines[-1] == line) == last
    assert ("2 skipped" in lines[-1]) != last


def test_every_program_has_a_package():
    assert set(needs.TOOLS["other_names"]) <= set(needs.TOOLS["packages"])
    with pytest.raises(KeyError):
        needs.programs("a program that .ci/tools.toml lacks")
