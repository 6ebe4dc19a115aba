"""Servers of scenes, for tests."""

from __future__ import annotations

from contextlib import ExitStack, closing

import pytest

from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server


@pytest.fixture
def serve(gpu):
    """Return a server of a scene, or of one of the library by its name; it ends with the test."""
    with ExitStack() as stack:

        def made(scene, **how) -> Server:
            scene = load_scene(scene) if isinstance(scene, str) else scene
            return stack.enter_context(closing(Server(gpu, scene, **how)))

        yield made
