"""Tests with a real OpenXR runtime.

They run in Monado's root (root.py), where this file is read a second time.

Outside, a test here waits for its namesake inside and ends as that one did; where there can be no
such root it is skipped with the reason. `tests/openxr/with-monado CMD...` runs anything else beside
the runtime.
"""

from __future__ import annotations

import os
from collections.abc import Generator
from pathlib import Path

import needs
import pytest

from .handover import PIPES, Inner, Reporter
from .root import Lacking, ready_root

INSIDE = PIPES in os.environ
HERE = Path(__file__).parent
_inner = pytest.StashKey[dict[tuple[str, ...], Inner]]()
_root = pytest.StashKey[Path | Lacking]()
_following = pytest.StashKey[str | None]()
# Files whose tests open windows in their own process, where GLX follows EGL badly: see test_window.
_windows = pytest.StashKey[set[Path]]()

if INSIDE:
    from .fixtures import *  # noqa: F403


def pytest_configure(config: pytest.Config) -> None:
    if INSIDE:
        config.pluginmanager.register(Reporter(*map(int, os.environ[PIPES].split(","))), "hmdwarp-reporter")


def pytest_unconfigure(config: pytest.Config) -> None:
    _close(config)


@pytest.hookimpl(trylast=True)
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Their fixtures are needed inside only."""
    windows = config.stash.setdefault(_windows, set())
    for item in items:
        if not INSIDE and _is_of_monado(item):
            if "screen" in item.fixturenames:
                windows.add(item.path)
            item.fixturenames = []


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None, bool, bool]:
    """Note which test comes next, and end the pytests inside with the last test here."""
    item.stash[_following] = nextitem and nextitem.nodeid
    try:
        return (yield)
    finally:
        if nextitem is None or not _is_of_monado(nextitem):
            _close(item.config)


def _is_of_monado(item: pytest.Item) -> bool:
    return isinstance(item, pytest.Function) and str(item.path).startswith(f"{HERE}{os.sep}")


def _close(config: pytest.Config) -> None:
    for inner in config.stash.get(_inner, {}).values():
        inner.close()
    config.stash[_inner] = {}


def pytest_pyfunc_call(pyfuncitem: pytest.Function) -> bool | None:
    """Outside, instead of the test."""
    if INSIDE:
        return None
    outcome = _inner_of(pyfuncitem).outcome_of(pyfuncitem.nodeid, pyfuncitem.stash[_following])
    if outcome.outcome == "skipped":
        pytest.skip(outcome.text)
    if outcome.outcome == "failed":
        pytest.fail(outcome.text, pytrace=False)
    return True


def _inner_of(item: pytest.Function) -> Inner:
    """The pytest inside for this one's file; files without windows share one."""
    started, windows = item.config.stash.setdefault(_inner, {}), item.config.stash[_windows]
    here = {other.path for other in item.session.items if _is_of_monado(other)}
    paths = {item.path} if item.path in windows else here - windows
    files = tuple(sorted(path.relative_to(item.config.rootpath).as_posix() for path in paths))
    if files in started and started[files].has_ended:
        started.pop(files).close()
    if files not in started:
        started[files] = Inner(_root_for(item.config), [*files])
    return started[files]


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
