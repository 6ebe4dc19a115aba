"""Tests with a real OpenXR runtime run in Monado's root (root.py), by a pytest of their own.

Outside, test_beside_monado.py starts that pytest.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from display.virtual_screen import VirtualScreen

from .monado import REMOTE, UNSEEN, WOBBLING, Monado
from .remote_head import RemoteHead

OUTSIDE = "test_beside_monado.py"
INSIDE = sorted(path.name for path in Path(__file__).parent.glob("test_*.py") if path.name != OUTSIDE)
collect_ignore = [OUTSIDE] if "HMDWARP_BESIDE_MONADO" in os.environ else INSIDE


@pytest.fixture
def runtime(tmp_path_factory, monkeypatch) -> Iterator[Callable[..., Monado]]:
    """runtime(settings...) -> a Monado that was not started yet.

    This process and those it starts find it by their environment.
    """
    made: list[Monado] = []

    def make(*settings: dict[str, str]) -> Monado:
        joined = {name: value for some in settings for name, value in some.items()}
        monado = Monado(tmp_path_factory.mktemp("runtime"), joined)
        for name, value in monado.environment.items():
            monkeypatch.setenv(name, value)
        made.append(monado)
        return monado

    yield make
    for monado in made:
        monado.kill()


@pytest.fixture
def monado(runtime) -> Monado:
    """A running service whose head stays where `remote_head` puts it, and whose pictures go
    nowhere, at 20 a second.
    """
    return runtime(REMOTE, UNSEEN).start()


@pytest.fixture
def wobbling(runtime) -> Monado:
    """One whose head wobbles by itself."""
    return runtime(WOBBLING, UNSEEN).start()


@pytest.fixture
def remote_head(monado) -> Iterator[RemoteHead]:
    """Moves the head of `monado`."""
    with RemoteHead() as head:
        yield head


@pytest.fixture
def no_screen(monkeypatch) -> None:
    """Neither X nor Wayland."""
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)


@pytest.fixture
def screen(tmp_path_factory, monkeypatch) -> Iterator[VirtualScreen]:
    """An X server; DISPLAY leads to it."""
    with VirtualScreen(tmp_path_factory.mktemp("screen"), (2000, 1200)) as made:
        monkeypatch.setenv("DISPLAY", made.display)
        monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
        yield made
