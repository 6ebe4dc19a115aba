"""What all benches here share."""

from __future__ import annotations

import pytest


@pytest.fixture(scope="module", autouse=True)
def small_copies():
    """The copies that measure the memory are of 1 MiB."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("hmdwarp.gpu.memory_bandwidth.suitable_bytes", lambda gpu: 1 << 20)
        yield
