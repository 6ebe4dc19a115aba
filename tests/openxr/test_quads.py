"""Panels as the runtime's own quad layers: on the screen, the right way up, in their colours."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.geometry import Fov, Pose
from hmdwarp.pipeline import Refresh
from hmdwarp.scenes import Panel, Scene, SceneSource, scenes
from hmdwarp.scenes.library import textures_named

from .live_runs import Here, quick
from .monado import ON_SCREEN, REMOTE, UNSEEN
from .remote_head import RemoteHead
from .screen import Screen
from .test_colours import CHART, LAST, SIZE, charts_in, when_lit

HEAD = Pose((0.2, 1.5, 0.3), (0.0, 0.0998334, 0.0, 0.9950042))
BEFORE_HEAD = Pose((0.0, 0.0, -1.0))
IMAGE = CHART.repeat(30, axis=0).repeat(30, axis=1)


def panel(place: str) -> Panel:
    if place == "head":
        return Panel(IMAGE, BEFORE_HEAD, (0.8, 0.8), head_locked=True)
    return Panel(IMAGE, HEAD @ BEFORE_HEAD, (0.8, 0.8))


@pytest.mark.parametrize("place", ["head", "world"])
def test_a_panel_is_composed_by_the_runtime(runtime, screen: Screen, monkeypatch, place):
    runtime(REMOTE, ON_SCREEN).start()
    monkeypatch.setenv("HMDWARP_OPENXR_GRAPHICS", "egl")  # no window of ours over Monado's
    name = f"chart-{place}"
    scenes.register(SceneSource(name, "a panel alone", lambda: Scene(name, "", (), panels=[panel(place)]), ("panels",)))
    seen, pictures = [], []

    def look(refresh: Refresh) -> None:
        seen.append((refresh.plan.left_out, [len(eye.panels) for eye in refresh.eyes]))

    with RemoteHead() as head:
        head.put(HEAD)
        fov = Fov(-0.7, 0.7, -0.7, 0.7)
        head.put_eyes([(Pose((-0.03, 0, 0)), fov), (Pose((0.03, 0, 0)), fov)])

    def after(number: int) -> None:
        if number == LAST:
            pictures.append(when_lit(screen))

    Here(monkeypatch, look).run(quick(scene=name, size=SIZE, pictures=LAST), after)
    left_out, counts = seen[-1]
    assert "composes them by itself" in dict(left_out)["panels"]
    assert counts == [1, 1]
    (picture,) = pictures
    for found in charts_in(picture):
        # As in test_colours: half a step of rounding here and there.
        assert np.abs(found.astype(int) - CHART).max() <= 1


def test_what_is_nearer_hides_a_panel_that_the_client_draws_then(runtime, monkeypatch):
    """Of two panels one asks to be hidden: the runtime gets the other."""
    runtime(REMOTE, UNSEEN).start()
    seen = []
    here = Here(monkeypatch, lambda refresh: seen.append((refresh.plan, refresh.eyes[0].panels)))
    here.run(quick(scene="reading", size=(96, 120), pictures=4))
    plan, panels = seen[-1]
    assert [each.panel.head_locked for each in panels] == [True]
    (step,) = [step for step in plan.steps if step.name == "panels"]
    assert "composes those that nothing hides" in step.reason
    assert textures_named("label-1")[0].image.shape[1::-1] == panels[0].texture.size
