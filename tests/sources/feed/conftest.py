"""What all tests of the feed share."""

from __future__ import annotations

from contextlib import ExitStack

import pytest
from serving import Serving

from hmdwarp.pipeline import remote
from hmdwarp.sources.feed import listener as listening
from hmdwarp.sources.feed import sockets


@pytest.fixture(autouse=True)
def nobody_is_silent(monkeypatch):
    """A machine that stands still makes clients of this process silent, and servers slow to answer;
    tests of that set it.
    """
    for module in (listening, sockets):
        monkeypatch.setattr(module, "SILENT_NS", 10**15)
    monkeypatch.setattr(remote, "_ANSWER_NS", 600_000_000_000)


@pytest.fixture
def listener():
    """A server's end; told: what it says."""
    told: list[str] = []
    made = listening.Listener("127.0.0.1:*", say=told.append)
    made.told = told
    yield made
    made.close()


@pytest.fixture(scope="session")
def serving_of():
    """Return the address of a server of a scene; each is started once."""
    with ExitStack() as stack:
        found: dict[str, Serving] = {}

        def of(scene: str) -> str:
            if scene not in found:
                found[scene] = stack.enter_context(Serving("--scene", scene))
            return found[scene].address

        yield of
