"""Known colours through the real compositor: pictures of both eyes, and panels as quad layers."""

from __future__ import annotations

import time

import numpy as np
import pytest

from hmdwarp.base import linear_from_srgb
from hmdwarp.geometry import Fov, Pose
from hmdwarp.gpu import upload
from hmdwarp.scenes import Panel, Scene, SceneSource, scenes
from hmdwarp.scenes.library import textures_named

from .live_runs import LONG_S, Here, quick
from .monado import ON_SCREEN, REMOTE, UNSEEN
from .remote_head import RemoteHead

SIZE = (400, 400)
LAST = 12  # the picture to look at: by then the first ones have gone all the way
# sRGB levels, left to right and top to bottom: black and white, greys on both sides of the linear
# part of the curve, and one primary each.
CHART = np.array([
    [(0, 0, 0), (255, 255, 255), (128, 128, 128), (188, 188, 188)],
    [(10, 10, 10), (64, 64, 64), (255, 0, 0), (0, 255, 0)],
    [(0, 0, 255), (200, 100, 50), (50, 100, 200), (32, 32, 32)],
    [(224, 224, 224), (0, 128, 128), (128, 0, 128), (128, 128, 0)],
], np.uint8)  # fmt: skip
HEAD = Pose((0.2, 1.5, 0.3), (0.0, 0.0998334, 0.0, 0.9950042))
AHEAD = Pose((0.0, 0.0, -1.0))
FOV = Fov(-0.7, 0.7, -0.7, 0.7)


@pytest.fixture
def shown(runtime, screen, monkeypatch):
    """shown(scene, before) -> the chart that each eye sees on the screen; before: as Here."""
    runtime(REMOTE, ON_SCREEN).start()
    monkeypatch.setenv("HMDWARP_OPENXR_GRAPHICS", "egl")  # no window of ours over Monado's
    with RemoteHead() as head:
        head.put(HEAD)
        head.put_eyes([(Pose((-0.03, 0, 0)), FOV), (Pose((0.03, 0, 0)), FOV)])

    def run(scene, before) -> list[np.ndarray]:
        pictures = []

        def after(number: int) -> None:
            if number == LAST:
                pictures.append(when_lit(screen))

        Here(monkeypatch, before).run(quick(scene=scene, size=SIZE, pictures=LAST), after)
        return charts_in(*pictures)

    return run


def when_lit(screen) -> np.ndarray:
    """The first picture that is not all black, and whole: a compositor under load comes late."""
    until, lit, picture = time.monotonic() + LONG_S, -1, screen.picture()
    while not picture.any() or picture.any(axis=-1).sum() > 1.01 * lit:
        assert time.monotonic() < until, "the screen stays black"
        lit = picture.any(axis=-1).sum()
        time.sleep(0.2)
        picture = screen.picture()
    return picture


def charts_in(picture: np.ndarray) -> list[np.ndarray]:
    """(4, 4, 3) the middle of each patch of each chart on the screen, the left one first."""
    lit = picture.any(axis=-1)
    rows = np.flatnonzero(lit.any(axis=1))
    edges = np.flatnonzero(np.diff(lit.any(axis=0).astype(int), prepend=0, append=0))
    assert len(edges) == 4, f"lit columns begin and end at {edges}: expected two charts with black between"
    middles = (np.arange(4) + 0.5) / 4
    y = rows[0] + (len(rows) * middles).astype(int)
    sides = zip(edges[::2], edges[1::2], strict=True)
    return [picture[np.ix_(y, left + ((right - left) * middles).astype(int))] for left, right in sides]


# Half a step by rounding here and in the compositor, and what hardware may be off by in encoding
# and decoding.
def are_near(found: np.ndarray, chart: np.ndarray) -> bool:
    return np.abs(found.astype(int) - chart).max() <= 1


def test_known_colours_arrive_before_both_eyes_the_right_way_up(shown):
    charts = CHART, CHART[:, ::-1]  # the right eye's has its columns the other way round

    def paint(refresh) -> None:
        for result, chart in zip(refresh.eyes, charts, strict=True):
            picture = chart.repeat(SIZE[1] // 4, axis=0).repeat(SIZE[0] // 4, axis=1)
            upload(result.panel.texture, linear_from_srgb(picture / 255).astype(np.float16))

    assert all(map(are_near, shown("planes", paint), charts))


@pytest.mark.parametrize("head_locked", [True, False])
def test_a_panel_is_composed_by_the_runtime(shown, head_locked):
    image, name, seen = CHART.repeat(30, axis=0).repeat(30, axis=1), f"chart-{head_locked}", []
    panel = Panel(image, AHEAD if head_locked else HEAD @ AHEAD, (0.8, 0.8), head_locked=head_locked)
    scenes.register(SceneSource(name, "a panel alone", lambda: Scene(name, "", (), panels=[panel]), ("panels",)))
    found = shown(name, seen.append)
    assert "composes them by itself" in dict(seen[-1].plan.left_out)["panels"]
    assert [len(eye.panels) for eye in seen[-1].eyes] == [1, 1]
    assert all(are_near(chart, CHART) for chart in found)


def test_what_is_nearer_hides_a_panel_that_the_client_draws_then(runtime, monkeypatch):
    """Of two panels one asks to be hidden: the runtime gets the other."""
    runtime(REMOTE, UNSEEN).start()
    seen = []
    Here(monkeypatch, seen.append).run(quick(scene="reading", pictures=4))
    (panel,) = seen[-1].eyes[0].panels
    assert panel.panel.head_locked
    (step,) = [step for step in seen[-1].plan.steps if step.name == "panels"]
    assert "composes those that nothing hides" in step.reason
    assert textures_named("label-1")[0].image.shape[1::-1] == panel.texture.size
