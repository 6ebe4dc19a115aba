"""`hmdwarp record` with a real runtime.

The head as the runtime tells it, through the runtime's death and return.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

from hmdwarp.display import Lost
from hmdwarp.geometry import Pose
from hmdwarp.poses import load_trace
from hmdwarp.run import RecordOptions, record

from .remote_head import RemoteHead

pytestmark = pytest.mark.usefixtures("no_screen")

PLACES = [Pose((0.1, 1.7, -0.25), (0.1, -0.2, 0.05, 0.97)), Pose((0.0, 1.6, 0.1), (0.1, -0.1, 0.05, 0.97))]
FLOAT32 = 2e-7  # relative step of the runtime's numbers, all of which are below 2 here
LONG_S = 60.0


def poses_in(path) -> int:
    """How many have reached the disk."""
    return sum(line[:1].isdigit() for line in path.read_text(encoding="utf-8").splitlines()) if path.is_file() else 0


def after_poses(path, count: int, do: Callable[[], None]) -> threading.Thread:
    """Do it as soon as so many are on the disk."""

    def wait() -> None:
        until = time.monotonic() + LONG_S
        while poses_in(path) < count and time.monotonic() < until:
            time.sleep(0.02)
        do()

    thread = threading.Thread(target=wait)
    thread.start()
    return thread


def places_in(path) -> np.ndarray:
    """Which of PLACES each pose is; exactly one.

    A trace's reader would take the first of them for a tracker that had not begun.
    """
    meant = np.array([np.concatenate([pose.position_m, pose.orientation_xyzw]) for pose in PLACES])
    found = np.loadtxt(path, delimiter=",", comments=("#", "t"))[:, 1:]
    near = np.abs(found[:, None] - meant[None]).max(axis=2) < 2 * FLOAT32
    assert (near.sum(axis=1) == 1).all()
    return near[:, 1].astype(int)


def test_poses_are_the_runtime_s(monado, remote_head, tmp_path):
    out, said = tmp_path / "head.csv", []
    remote_head.put(PLACES[0])
    moving = after_poses(out, 20, lambda: remote_head.put(PLACES[1]))
    record(RecordOptions(source="openxr", out=out, seconds=3.0, rate_hz=50.0), said.append)
    moving.join()
    places = places_in(out)
    assert (np.diff(places) >= 0).all()
    assert places[0] == 0
    assert places[-1] == 1
    track = load_trace(out).track
    assert track.rate_hz == pytest.approx(50.0, rel=0.2)  # a median, on a machine that may be busy
    assert "Monado" in track.origin
    assert "headset" in track.origin
    assert said[0].startswith("recording ")
    assert said[-1].startswith(f"{out}: {len(places)} poses, ")


def test_a_runtime_that_comes_back_goes_on_in_the_same_file(monado, tmp_path):
    out, said = tmp_path / "head.csv", []
    with RemoteHead() as head:
        head.put(PLACES[0])

    def restart() -> None:
        monado.kill()
        monado.start()
        with RemoteHead() as again:
            again.put(PLACES[0])

    restarting = after_poses(out, 10, restart)
    record(RecordOptions(source="openxr", out=out, seconds=6.0, rate_hz=50.0), said.append)
    restarting.join()
    assert "it is back" in said
    track = load_trace(out).track
    assert track.broken.sum() >= 1  # the gap is one in the recording, too
    assert np.diff(track.time_ns).max() < 6e9
    assert track.broken.argmax() >= 9


def test_a_runtime_that_stays_away_leaves_what_was_recorded(monado, remote_head, tmp_path):
    out, said = tmp_path / "head.csv", []
    remote_head.put(PLACES[0])
    killing = after_poses(out, 10, monado.kill)
    with pytest.raises(Lost, match="has not come back within 1 s"):
        record(RecordOptions(source="openxr", out=out, rate_hz=50.0, reconnect_s=1.0), said.append)
    killing.join()
    assert len(load_trace(out).track) >= 10
    assert "waiting up to 1 s" in said[1]
