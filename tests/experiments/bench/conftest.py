"""What all benches here share."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module", autouse=True)
def small_copies():
    """The copy that both clocks time is of 1 MiB."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hmdwarp.gpu.timers._CHECK_BYTES", 1 << 20)
        yield
