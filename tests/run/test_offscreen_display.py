"""The display that the other tests here use is one: a whole run on it, and twice the same."""

from __future__ import annotations

import numpy as np

from hmdwarp.run import LiveOptions

from .offscreen import OffscreenDisplay, closed_at, run_on


def run(monkeypatch, **options) -> OffscreenDisplay:
    display = OffscreenDisplay(keeps=True, events={2: None, **closed_at(12)})
    run_on(monkeypatch, display, LiveOptions(scene="planes", latency_ms=30, **options))
    assert display.closed == 1
    return display


def test_a_run_shows_pictures_and_twice_the_same(monkeypatch):
    first, second = run(monkeypatch), run(monkeypatch)
    assert first.said == ["the window was closed"]
    assert len(first.pictures) == 11
    shown = [picture.any() for picture in first.pictures]
    assert shown == sorted(shown)
    assert sum(shown) >= 8  # a frame is 30 ms under way, and shown 20 ms after it is asked for
    assert all(np.array_equal(a, b) for a, b in zip(first.pictures, second.pictures, strict=True))
    assert not np.array_equal(first.pictures[-1], first.pictures[-2])  # the head moves


def test_a_flat_view_is_one_picture(monkeypatch):
    display = OffscreenDisplay(keeps=True, view="flat", events=closed_at(6))
    run_on(monkeypatch, display, LiveOptions(scene="planes", latency_ms=0, view="flat"))
    assert display.pictures[-1].shape == (120, 96, 3)
    assert display.pictures[-1].any()
