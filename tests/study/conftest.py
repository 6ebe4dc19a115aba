"""No test of this process cuts the power: stores commit without waiting for the disk."""

from __future__ import annotations

import pytest

from hmdwarp.study.store import database


@pytest.fixture(scope="session", autouse=True)
def nobody_waits_for_the_disk():
    """What is killed, and what is asked of the disk, runs in processes of their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(database, "SYNCHRONOUS", "OFF")
        yield
