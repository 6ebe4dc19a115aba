"""Known colours through the real compositor.

What is in the panel is on the screen, for both eyes, the right way up.
"""

from __future__ import annotations

import time

import numpy as np
import pytest

from hmdwarp.colour import linear_from_srgb
from hmdwarp.geometry import Fov, Pose
from hmdwarp.gpu import upload
from hmdwarp.pipeline import Refresh

from .live_runs import LONG_S, Here, quick
from .monado import ON_SCREEN, REMOTE
from .remote_head import RemoteHead
from .screen import Screen

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


def chart(eye: int) -> np.ndarray:
    """(h, w, 3) in sRGB; the right eye's has its columns the other way round."""
    patches = CHART if eye == 0 else CHART[:, ::-1]
    return patches.repeat(SIZE[1] // 4, axis=0).repeat(SIZE[0] // 4, axis=1)


@pytest.mark.slow(30)
def test_known_colours_arrive_on_the_screen(runtime, screen, monkeypatch):
    runtime(REMOTE, ON_SCREEN).start()
    monkeypatch.setenv("HMDWARP_OPENXR_GRAPHICS", "egl")  # no window of ours over Monado's

    def paint(refresh: Refresh) -> None:
        for eye, result in enumerate(refresh.eyes):
            upload(result.panel.texture, linear_from_srgb(chart(eye) / 255).astype(np.float16))

    here, pictures = Here(monkeypatch, paint), []
    fov = Fov(-0.7, 0.7, -0.7, 0.7)
    with RemoteHead() as head:
        head.put(Pose((0, 1.6, 0)))
        head.put_eyes([(Pose((-0.03, 0, 0)), fov), (Pose((0.03, 0, 0)), fov)])

    def after(number: int) -> None:
        if number == LAST:
            pictures.append(when_lit(screen))

    here.run(quick(size=SIZE, pictures=LAST), after)
    (picture,) = pictures
    for eye, seen in enumerate(charts_in(picture)):
        patches = CHART if eye == 0 else CHART[:, ::-1]
        # Half a step by rounding here and in the compositor, and what hardware may be off by in
        # encoding and decoding.
        assert np.abs(seen.astype(int) - patches).max() <= 1


def when_lit(screen: Screen) -> np.ndarray:
    """The first picture that is not all black, and whole: a compositor under load comes late."""
    until, lit, picture = time.monotonic() + LONG_S, -1, screen.picture()
    while not picture.any() or picture.any(axis=-1).sum() > 1.01 * lit:
        assert time.monotonic() < until, "the screen stays black"
        lit = picture.any(axis=-1).sum()
        time.sleep(0.2)
        picture = screen.picture()
    return picture


def charts_in(picture: np.ndarray) -> list[np.ndarray]:
    """(4, 4, 3) the middle of each patch of each chart on the screen, the left one first.

    Errors: AssertionError unless there are two.
    """
    lit = picture.any(axis=-1)
    rows = np.flatnonzero(lit.any(axis=1))
    edges = np.flatnonzero(np.diff(lit.any(axis=0).astype(int), prepend=0, append=0))
    assert len(edges) == 4, f"lit columns begin and end at {edges}: expected two charts with black between"
    y = rows[0] + (len(rows) * (np.arange(4) + 0.5) / 4).astype(int)
    found = []
    for left, right in (edges[:2], edges[2:]):
        x = left + ((right - left) * (np.arange(4) + 0.5) / 4).astype(int)
        found.append(picture[np.ix_(y, x)])
    return found
