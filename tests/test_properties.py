"""Property tests draw the same examples everywhere and never fail for taking long."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings
from properties import ONE_FIXTURE_FOR_ALL

TESTS = Path(__file__).parent


def test_the_profile_has_no_time_limit():
    assert settings.default.deadline is None
    assert HealthCheck.too_slow in settings.default.suppress_health_check
    assert HealthCheck.too_slow in ONE_FIXTURE_FOR_ALL


@pytest.mark.parametrize("ci", ["", "true"])
def test_the_profile_is_the_same_in_ci_and_outside(ci):
    env = {name: value for name, value in os.environ.items() if name not in ("CI", "GITHUB_ACTIONS")}
    program = "import properties; from hypothesis import settings; print(settings.default)"
    done = subprocess.run(
        [sys.executable, "-c", program],
        cwd=TESTS, env={**env, **({"CI": ci} if ci else {})}, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.strip() == str(settings.default)


def test_no_test_sets_a_deadline_of_its_own():
    """Or a list of health checks that leaves the one for slow strategies on."""
    own = re.compile(r"\bdeadline=|suppress_health_check=(?!ONE_FIXTURE_FOR_ALL|list\(HealthCheck\))")
    found = [
        p
        for p in TESTS.rglob("*.py")
        if p.stem not in ("properties", "test_properties") and own.search(p.read_text(encoding="utf-8"))
    ]
    assert not found
