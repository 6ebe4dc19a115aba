"""A renderer in Python: what it is asked for, what it may return, and how it ends."""

from __future__ import annotations

import signal
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest

from hmdwarp import Fov, InputError, Pose, View, feed
from hmdwarp.sources.feed.caller import Viewer

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install '.[feed]'")

FOV, SIZE = Fov.symmetric(1.0, 0.8), (6, 4)
ASKED, CAMERA = View(Pose((0.1, 1.6, 0.2)), FOV), View(Pose((1, 2, 3), (0, 1, 0, 1)), Fov.symmetric(0.9, 0.7))
BYTES = np.random.default_rng(2).integers(0, 256, (4, 6, 3), np.uint8)
DEPTH_M = np.linspace(0.5, 9, 24).reshape(4, 6)
DEPTH_M[0, :3] = np.inf, 0, np.nan


def fetched(render, view: View = ASKED, size=SIZE):
    with feed.serving(render) as address, closing(Viewer(address)) as viewer:
        return viewer.fetch(view, size, 5_000_000)


def test_a_frame_is_what_render_returns_for_the_view(capfd):
    got = []

    def render(views, time_ns):
        got.append((views, views.size, time_ns))
        return [BYTES], [DEPTH_M]

    frame = fetched(render)
    ((views, *rest),) = got
    assert (*views, *rest) == (ASKED, SIZE, 5_000_000) and frame.views == (ASKED,)
    assert (frame.colours[0][..., :3] == BYTES).all() and (frame.colours[0][..., 3] == 255).all()
    with np.errstate(divide="ignore"):
        expected = np.where(DEPTH_M > 0, 1 / DEPTH_M, -1).astype(np.float32)
    assert (frame.inverse_depths[0] == expected).all()
    assert "listening at tcp://127.0.0.1:" in capfd.readouterr().err


def test_light_coverage_and_the_view_of_a_camera_come_along():
    light = np.dstack([np.full((4, 6, 3), 1.0), np.eye(4, 6)])
    frame = fetched(lambda views, _: ([light], [np.ones((4, 6))], [CAMERA]))
    assert frame.views == (CAMERA,)
    assert (frame.colours[0] == np.dstack([np.full((4, 6, 3), 255), 255 * np.eye(4, 6)])).all()
    assert (frame.inverse_depths[0] == np.where(np.eye(4, 6) > 0, 1, -1)).all()


@pytest.mark.parametrize(
    "result",
    [([BYTES] * 2, [DEPTH_M]), ([BYTES], [DEPTH_M.T]), ([BYTES[..., :2]], [DEPTH_M]), ([BYTES], [DEPTH_M], [])],
)
def test_other_shapes_end_it_with_what_was_expected(result, monkeypatch):
    monkeypatch.setattr("hmdwarp.sources.feed.caller._ANSWER_NS", 10**8)  # nobody answers any more
    asked = []
    with (
        pytest.raises(InputError, match="render returned .*: expected"),
        feed.serving(lambda views, _: asked.append(views) or result) as address,
        closing(Viewer(address)) as viewer,
    ):
        while not asked:
            viewer.fetch(ASKED, SIZE, 0)


def test_a_request_beyond_what_a_cpu_draws_is_refused():
    """More than 2^28 bytes, at 13 a pixel."""
    assert fetched(lambda *_: pytest.fail("asked"), size=(8192, 8192)) is None


def test_served_by_a_process_of_its_own_until_it_is_interrupted():
    program = (
        "import hmdwarp, numpy as np\ndef render(views, time_ns):\n    w, h = views.size\n"
        "    return [np.full((h, w, 3), 0.5)], [np.full((h, w), 2.0)]\nhmdwarp.feed.serve(render, '127.0.0.1:*')"
    )
    with subprocess.Popen([sys.executable, "-c", program], stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        with closing(Viewer(process.stderr.readline().split()[2])) as viewer:
            assert (viewer.fetch(ASKED, SIZE, 0).inverse_depths[0] == 0.5).all()
        process.send_signal(signal.SIGINT)
        assert "Traceback" not in process.stderr.read()
    assert process.returncode == 0
