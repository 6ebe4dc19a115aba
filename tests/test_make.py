"""Every target of the Makefile runs: here, with settings that make it small, or as LISTED says."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import attrs
import pytest

ROOT = Path(__file__).resolve().parents[1]
TARGETS = set(re.findall(r"^([a-z-]+):(?!=)", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))


@attrs.frozen
class Small:
    """How a target is run here."""

    settings: dict[str, str] = attrs.field(factory=dict)
    prints: str = ""  # what it prints, among other things
    never: str = "Traceback"  # what it does not print
    leaves: tuple[str, str] | None = None  # a file below OUT, and what it says, among other things


SMALL = {
    "help": Small(prints="make replay"),
    # The suite runs these tests.
    "test-kill": Small({"OPTIONS": "-p no:cacheprovider --collect-only"}, "test_killing_the_program_loses_nothing"),
    "test-statistics": Small({"OPTIONS": "-p no:cacheprovider -k 'no_effect and 12'"}, "passed"),
    "test-faults": Small({"OPTIONS": "--list"}, "not run"),
    # CI runs 1,000 cases of all kinds beside the suite.
    "fuzz": Small({"SECONDS": "inf", "OPTIONS": "--cases 8 --only unity"}, " 0 findings"),
    "bench-quick": Small({"OPTIONS": "--rounds 1 --seconds 0 --sizes 1"}, "warpFrame"),
    "bench-gpu": Small({"OPTIONS": "--quick"}, "page: ", "left out", ("gpu.md", "A refresh outside OpenGL")),
    "docs": Small({"OPTIONS": "readme"}),
    # All of the recording takes minutes.
    "replay": Small(
        {"SCENE": "planes", "SECONDS": "0.3", "OPTIONS": "--size 96x120 --images 1"}, leaves=("report.html", "</html>")
    ),
}
LISTED = {
    "test-jod": "brings several GB of PyTorch; tests/metrics/test_jod.py has what a crash of it does",
    "test-requests": "runs for an hour or two; tests/sources/feed has a short run of it",
    "test-silence": "runs for a quarter of an hour; tests/sources/feed runs the same for a second",
    "test-soak": "runs for an hour; tests/feed has short runs over the same relay",
    "bench-live": "is a part of bench-gpu, whose page has its lines",
    "setup": "makes the environment this runs in; tests/packaging/test_setup.py runs its script",
    "test": "is the suite itself", "test-quick": "is a part of the suite",
    "test-openxr": "needs root and apt, and builds 1.4 GB; where they are there it runs as part of the suite",
    "check": "is the four below", "check-lint": "tests/test_checks.py runs it",
    "check-format": "tests/test_checks.py runs it", "check-types": "tests/test_checks.py runs it",
    "check-shaders": "runs tests/gpu/test_shader_files.py, a part of the suite",
    "site": "tests/packaging/test_site.py runs it",
}  # fmt: skip


def test_every_target_is_run_or_says_why_not():
    assert sorted([*SMALL, *LISTED]) == sorted(TARGETS)


@pytest.mark.slow(15)
@pytest.mark.parametrize("target", SMALL)
def test_it_runs(target, tmp_path):
    small = SMALL[target]
    at = _copy(tmp_path) if target == "docs" else ROOT  # docs writes its pages
    settings = {"OUT": str(tmp_path / "out"), **small.settings}
    lines = _printed("make", "-n", target, *(f"{name}={value}" for name, value in settings.items()))
    # The environment is that of this test, not the checkout's, which may have none.
    script = re.sub(r"(?m)^\.ci/setup.*\n", "", lines).replace(".venv/bin/", f"{Path(sys.executable).parent}/")
    done = subprocess.run(["sh", "-ec", script], cwd=at, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stdout + done.stderr
    assert small.prints in done.stdout and small.never not in done.stdout, done.stdout + done.stderr
    if small.leaves:
        name, words = small.leaves
        assert words in (tmp_path / "out" / name).read_text(encoding="utf-8"), done.stdout


def _copy(folder: Path) -> Path:
    """The pages and what writes them, apart."""
    for name in ("docs", "README.md", "CONTRIBUTING.md"):
        source = ROOT / name
        shutil.copytree(source, folder / name) if source.is_dir() else shutil.copy(source, folder)
    (folder / "tests").symlink_to(ROOT / "tests")
    return folder


def _printed(*command: str) -> str:
    done = subprocess.run([*command, "--no-print-directory"], cwd=ROOT, capture_output=True, text=True, check=True)
    return done.stdout
