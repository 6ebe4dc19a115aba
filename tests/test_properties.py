"""Property tests draw the same examples everywhere and never fail for taking long."""

from __future__ import annotations

import re
from pathlib import Path

from hypothesis import HealthCheck, settings
from properties import ONE_FIXTURE_FOR_ALL

TESTS = Path(__file__).parent


def test_the_profile_has_no_time_limit():
    assert settings.default.deadline is None
    assert HealthCheck.too_slow in settings.default.suppress_health_check
    assert HealthCheck.too_slow in ONE_FIXTURE_FOR_ALL


def test_no_test_sets_a_deadline_of_its_own():
    """Or a list of health checks that leaves the one for slow strategies on."""
    own = re.compile(r"\bdeadline=|suppress_health_check=(?!ONE_FIXTURE_FOR_ALL|list\(HealthCheck\))")
    found = [
        p
        for p in TESTS.rglob("*.py")
        if p.stem not in ("properties", "test_properties") and own.search(p.read_text(encoding="utf-8"))
    ]
    assert not found
