"""`hmdwarp record` with a real runtime.

The head as the runtime tells it, through the runtime's death and return.
"""

from __future__ import annotations

import contextlib
import signal
import threading
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from hmdwarp.display import Lost
from hmdwarp.geometry import Pose
from hmdwarp.poses import load_trace
from hmdwarp.run import RecordOptions, record

from .live_runs import LONG_S
from .remote_head import RemoteHead

pytestmark = pytest.mark.usefixtures("no_screen")

PLACES = [Pose((0.1, 1.7, -0.25), (0.1, -0.2, 0.05, 0.97)), Pose((0.0, 1.6, 0.1), (0.1, -0.1, 0.05, 0.97))]
FLOAT32 = 2e-7  # relative step of the runtime's numbers, all of which are below 2 here


def poses_in(path) -> int:
    """How many have reached the disk."""
    return sum(line[:1].isdigit() for line in path.read_text(encoding="utf-8").splitlines()) if path.is_file() else 0


@contextlib.contextmanager
def meanwhile(path, do: Callable[[], None], seen: Callable[[], bool] = lambda: False) -> Iterator[None]:
    """Do it as soon as ten poses are on the disk; press Ctrl-C ten after what follows was seen."""
    over, until = threading.Event(), time.monotonic() + LONG_S

    def wait(there: Callable[[], bool]) -> None:
        while not there() and not over.is_set() and time.monotonic() < until:
            time.sleep(0.02)

    def work() -> None:
        wait(lambda: poses_in(path) >= 10)
        do()
        wait(seen)
        count = poses_in(path)
        wait(lambda: poses_in(path) >= count + 10)
        if not over.is_set():
            signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


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
    with meanwhile(out, lambda: remote_head.put(PLACES[1]), lambda: places_in(out)[-1] == 1):
        record(RecordOptions(source="openxr", out=out, rate_hz=50.0), said.append)
    places = places_in(out)
    assert (np.diff(places) >= 0).all()
    assert places[0] == 0
    assert places[-1] == 1
    track = load_trace(out).track
    # A busy machine samples late, after which the next one has its whole period; now and then it is
    # in time.
    assert track.duration_ns >= (len(track) - 2) * 20_000_000 and np.diff(track.time_ns).min() < 30_000_000
    assert "# rate: 50 Hz" in out.read_text().splitlines()
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

    began = time.monotonic()
    with meanwhile(out, restart, lambda: "it is back" in said):
        record(RecordOptions(source="openxr", out=out, rate_hz=50.0, reconnect_s=LONG_S), said.append)
    track = load_trace(out).track
    assert track.broken[9:].any()  # the gap is one in the recording, too
    assert track.duration_ns < 1e9 * (time.monotonic() - began)


def test_a_runtime_that_stays_away_leaves_what_was_recorded(monado, remote_head, tmp_path):
    out, said = tmp_path / "head.csv", []
    remote_head.put(PLACES[0])
    with meanwhile(out, monado.kill), pytest.raises(Lost, match="has not come back within 1 s"):
        record(RecordOptions(source="openxr", out=out, rate_hz=50.0, reconnect_s=1.0), said.append)
    assert len(load_trace(out).track) >= 10
    assert "waiting up to 1 s" in said[1]
