"""Waits that are for people are short here; all sessions of a test run share one OpenGL context."""

from __future__ import annotations

import pytest

from hmdwarp.study.session import runner

from .sessions import study

LEAD_S, SETTLED_S, FAREWELL_S = 0.05, 0.03, 0.05


def hurry(patch: pytest.MonkeyPatch) -> None:
    """The waits, until the patch is undone."""
    patch.setattr(runner, "LEAD_S", LEAD_S)
    patch.setattr(runner, "SETTLED_S", SETTLED_S)
    patch.setattr(runner, "FAREWELL_S", FAREWELL_S)


@pytest.fixture(autouse=True)
def nobody_rests_their_eyes(monkeypatch):
    hurry(monkeypatch)


@pytest.fixture
def path(tmp_path):
    """The file of the small study."""
    return study(tmp_path)
