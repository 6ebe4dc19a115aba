"""Fixtures of all tests of studies."""

from __future__ import annotations

import gc

import pytest


@pytest.fixture(scope="module")
def quick_corrections():
    """Keep statsmodels from collecting garbage at each correction: 0.1 s with all our objects."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gc, "collect", lambda generation=2: 0)
        yield
