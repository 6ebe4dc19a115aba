"""The frame loop with a real runtime: through EGL without X, in a window, and with eyes that are not alike."""

from __future__ import annotations

import json

import pytest

from hmdwarp.report.schema import validate_summary

from .live_runs import Here, quick
from .monado import UNSEEN, WOBBLING


@pytest.fixture
def here(monkeypatch) -> Here:
    return Here(monkeypatch)


def looks_right(here: Here, out, graphics: str) -> None:
    """200 frames, each with the head where the runtime saw it."""
    result = here.run(quick(frames=10, latency_ms=175.0, out=out))
    assert result.summary["frames"] == 10
    validate_summary(json.loads((out / "summary.json").read_text()))
    assert here.watched.about["graphics"].startswith(graphics)
    shown = [refresh for refresh in here.watched.shown if refresh is not None]
    assert len({refresh.head.pose.position_m.tobytes() for refresh in shown}) > 3  # it wobbles
    assert all(refresh.age_ns >= 175e6 for refresh in shown)


def test_200_frames_without_x(runtime, no_screen, here, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    looks_right(here, tmp_path / "out", "EGL")


def test_200_frames_in_a_window(runtime, screen, here, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    looks_right(here, tmp_path / "out", "GLX")
