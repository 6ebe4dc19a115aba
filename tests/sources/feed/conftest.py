"""What all tests of the feed share."""

from __future__ import annotations

import pytest

from hmdwarp.sources.feed import listener, sockets


@pytest.fixture(autouse=True)
def nobody_is_silent(monkeypatch):
    """A machine that stands still makes clients of this process silent: tests of silence set it."""
    for module in (listener, sockets):
        monkeypatch.setattr(module, "SILENT_NS", 10**15)
