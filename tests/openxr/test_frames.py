"""The frame loop with a real runtime, without X: for long, and with eyes that are not alike."""

from __future__ import annotations

import numpy as np
import pytest

from hmdwarp.colour import picture_from_linear
from hmdwarp.geometry import Fov, Pose, View
from hmdwarp.gpu import download
from hmdwarp.scenes import load_scene
from hmdwarp.sources.server import Server

from .live_runs import SMALL, Here, many_frames, quick
from .monado import UNSEEN, WOBBLING

pytestmark = pytest.mark.usefixtures("no_screen")
HEAD = Pose((0.4, 1.5, 0.3), (-0.05, 0.25, 0.02, 0.95))
# Wide outwards, narrow inwards, one eye higher and turned: nothing is mirrored, nothing is
# symmetric.
UNLIKE = [
    (Pose((-0.034, 0.002, 0.01)), Fov(left=-0.9, right=0.6, down=-0.7, up=0.5)),
    (Pose((0.029, -0.004, 0.0), (0.02, -0.04, 0.0, 1.0)), Fov(left=-0.5, right=0.85, down=-0.65, up=0.75)),
]


def test_120_frames(runtime, monkeypatch, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    many_frames(Here(monkeypatch), tmp_path / "out", 120, "EGL")


def test_each_eye_gets_its_own_view(remote_head, monkeypatch):
    """Without latency the warp has nothing to do.

    Each picture is what the server draws for where the eye was told to be.
    """
    remote_head.put(HEAD)
    remote_head.put_eyes(UNLIKE)
    here, pictures, drawn = Here(monkeypatch), [], []
    options = quick(scene="room", pictures=3)

    def after(number: int) -> None:
        if number < 3:
            return  # the head has arrived for certain
        pictures.extend(
            picture_from_linear(download(eye.panel.texture)).astype(int) for eye in here.watched.shown[-1].eyes
        )
        server = Server(here.watched.gpu, load_scene("room"), samples=options.samples)
        for (head_from_eye, fov), told in zip(UNLIKE, here.watched.shown[-1].inputs, strict=True):
            view = View(HEAD @ head_from_eye, fov, hidden=told.shown.hidden)
            drawn.append(picture_from_linear(download(server.draw(view, SMALL).colour)).astype(int))
        server.close()

    here.run(options, after)
    assert not np.array_equal(drawn[0], drawn[1])
    for picture, wanted in zip(pictures, drawn, strict=True):
        # The runtime's float32 moves edges by 1e-5 pixels: of 11,520 pixels a few may fall on their
        # other side (here none did).
        assert (np.abs(picture - wanted).max(axis=-1) > 1).mean() < 2e-3
