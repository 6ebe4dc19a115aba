"""Tests with a real OpenXR runtime.

They run in Monado's root (root.py), where this file is read a second time.

Outside, a test here waits for its namesake inside and ends as that one did; where there can be no
such root it is skipped with the reason. `tests/openxr/with-monado CMD...` runs anything else beside
the runtime.
"""

from __future__ import annotations

import os
from pathlib import Path

import needs
import pytest

from .handover import PIPE, Inner, Reporter
from .root import Lacking, ready_root

INSIDE = PIPE in os.environ
HERE = Path(__file__).parent
_inner = pytest.StashKey[dict[str, Inner]]()
_root = pytest.StashKey[Path | Lacking]()

if INSIDE:
    from .fixtures import *  # noqa: F403


def pytest_configure(config: pytest.Config) -> None:
    if INSIDE:
        config.pluginmanager.register(Reporter(int(os.environ[PIPE])), "hmdwarp-reporter")


def pytest_unconfigure(config: pytest.Config) -> None:
    for inner in config.stash.get(_inner, {}).values():
        inner.close()


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Their fixtures are needed inside only."""
    for item in items:
        if not INSIDE and isinstance(item, pytest.Function) and HERE in item.path.parents:
            item.fixturenames = []


def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Outside, instead of the test."""
    if INSIDE:
        return None
    outcome = _inner_of(pyfuncitem).outcome_of(pyfuncitem.nodeid)
    if outcome.outcome == "skipped":
        pytest.skip(outcome.text)
    if outcome.outcome == "failed":
        pytest.fail(outcome.text, pytrace=False)
    return True


def _inner_of(item: pytest.Function) -> Inner:
    """The pytest inside that runs the tests of this one's file.

    Those of them that were asked for here.
    """
    started = item.config.stash.setdefault(_inner, {})
    name = item.nodeid.partition("::")[0]
    if name not in started:
        root = _root_for(item.config)
        asked = [other.nodeid for other in item.session.items if other.nodeid.startswith(f"{name}::")]
        started[name] = Inner(root, asked)
    return started[name]


def _root_for(config: pytest.Config) -> Path:
    """Built at the first test that needs it, not before; tried once."""
    if _root not in config.stash:
        try:
            config.stash[_root] = ready_root(lambda text: _say(config, text))
        except Lacking as lacking:
            config.stash[_root] = lacking
    root = config.stash[_root]
    if isinstance(root, Lacking):
        pytest.skip(needs.missing("OpenXR runtime", str(root)))
    return root


def _say(config: pytest.Config, text: str) -> None:
    terminal, capture = (
        config.pluginmanager.getplugin("terminalreporter"),
        config.pluginmanager.getplugin("capturemanager"),
    )
    if terminal is not None and capture is not None:  # the workers of pytest-xdist have no terminal
        with capture.global_and_fixture_disabled():
            terminal.write_line(text)
