"""Fixtures that every test may use.

One GPU context for the session, the development head traces, the order of tests.
"""

from __future__ import annotations

import signal
import sys
from pathlib import Path

import pytest

DEVELOPMENT_TRACES = Path(__file__).resolve().parents[2] / "shared" / "traces"


@pytest.fixture(scope="session")
def gpu():
    """One OpenGL context for the whole session (llvmpipe where there is no GPU)."""
    from hmdwarp.gpu.context import Gpu

    with Gpu() as made:
        yield made


@pytest.fixture(autouse=True)
def no_context_is_left_behind():
    """A test that leaves an OpenGL context of its own open makes every later one draw there.

    Black pictures, far from the cause.
    """
    before = _current_gpu()
    yield
    assert _current_gpu() is before, "this test left an OpenGL context open: close it"


def _current_gpu():
    context = sys.modules.get("hmdwarp.gpu.context")
    return context and getattr(context._thread, "gpu", None)


@pytest.fixture(scope="session")
def real_traces() -> Path:
    """The folder of real recorded head motion used in development.

    It is not part of the project.
    """
    if not DEVELOPMENT_TRACES.is_dir():
        pytest.skip(f"no real head traces at {DEVELOPMENT_TRACES} (they lie beside the development checkout only)")
    return DEVELOPMENT_TRACES


def pytest_configure() -> None:
    """Signals as a terminal has them.

    Under nohup, or in the background of a script, they are ignored, and so would be in every
    program that a test starts and then interrupts.
    """
    for number, usual in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
        if signal.getsignal(number) is signal.SIG_IGN:
            signal.signal(number, usual)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Slow tests last, so that a mistake shows early."""
    items.sort(key=lambda item: item.get_closest_marker("slow") is not None)
