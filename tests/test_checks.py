"""What `make check` and pre-commit run holds here too."""

from __future__ import annotations

import re
import shlex
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]
TARGETS = re.findall(r"^(check-\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
HERE = ("check-lint", "check-format", "check-types")  # the suite compiles the shaders itself


def lines_of(target: str) -> str:
    command = ["make", "-n", "--no-print-directory", target]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout


@pytest.mark.slow(60)
@pytest.mark.parametrize("line", [line for target in HERE for line in lines_of(target).splitlines() if " -m " in line])
def test_it_finds_nothing(line):
    _, *arguments = shlex.split(line)
    done = subprocess.run([sys.executable, *arguments], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


def test_pre_commit_runs_the_same_and_fetches_nothing():
    config = yaml.safe_load((ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8"))
    hooks = [hook for repo in config["repos"] for hook in repo["hooks"]]
    assert {repo["repo"] for repo in config["repos"]} == {"local"}
    assert {hook["language"] for hook in hooks} == {"system"}
    assert [hook["entry"].split()[-1] for hook in hooks] == TARGETS
    whole = lines_of("check")
    assert TARGETS and all(line in whole for target in TARGETS for line in lines_of(target).splitlines())


def test_the_public_host_runs_what_ci_runs():
    workflow = yaml.safe_load((ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8"))
    (job,) = workflow["jobs"].values()
    assert job["strategy"]["matrix"]["python"] == ["3.11", "3.13"]
    assert [step["run"] for step in job["steps"] if "run" in step] == [".ci/run"]
    assert not [step for step in job["steps"] if "upload" in step.get("uses", "")]


def test_no_test_sets_a_deadline_of_its_own():
    """Or a list of health checks that leaves the one for slow strategies on."""
    own = re.compile(r"\bdeadline=|suppress_health_check=(?!ONE_FIXTURE_FOR_ALL|list\(HealthCheck\))")
    paths = [path for path in (ROOT / "tests").rglob("*.py") if path.stem not in ("properties", "test_checks")]
    assert [path for path in paths if own.search(path.read_text(encoding="utf-8"))] == []
