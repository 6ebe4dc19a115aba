"""A page with the shaders alone, for tests of the warp in a browser."""

from __future__ import annotations

import pytest

from hmdwarp.web.door import shaders

from .browser import Browser, page


@pytest.fixture(scope="module")
def browser():
    with Browser() as driven, page(shaders()) as address:
        driven.open(address)
        driven.until("globalThis.chain")
        yield driven
