"""Other commands with a real runtime: doctor, headset and record."""

from __future__ import annotations

import contextlib
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest

from hmdwarp.display import Lost
from hmdwarp.geometry import Pose
from hmdwarp.headsets import load_headset
from hmdwarp.poses import load_trace
from hmdwarp.run import RecordOptions, record

from .live_runs import LONG_S
from .monado import UNSEEN, WOBBLING
from .remote_head import RemoteHead

pytestmark = pytest.mark.usefixtures("no_screen")

COMMAND = (sys.executable, "-m", "hmdwarp")
PLACES = [Pose((0.1, 1.7, -0.25), (0.1, -0.2, 0.05, 0.97)), Pose((0.0, 1.6, 0.1), (0.1, -0.1, 0.05, 0.97))]
FLOAT32 = 2e-7  # relative step of the runtime's numbers, all of which are below 2 here


def test_the_doctor_before_and_while_a_service_runs(runtime):
    def lines() -> dict[str, str]:
        """By the name of what was looked at."""
        done = subprocess.run([*COMMAND, "doctor"], check=True, capture_output=True, text=True)
        return {row[10:26].strip(): row for row in done.stdout.splitlines() if row[:1].isalpha()}

    monado = runtime(WOBBLING, UNSEEN)
    down = lines()
    assert down["OpenXR"].startswith("optional") and "service does not answer" in down["OpenXR"]
    monado.start()
    up = lines()
    assert up["OpenXR"].startswith("ok") and "Monado" in up["OpenXR"] and "Simulated HMD" in up["OpenXR"]


def test_the_connected_headset_becomes_a_file(monado, tmp_path):
    out = tmp_path / "simulated.toml"
    subprocess.run([*COMMAND, "headset", "from-openxr", "--out", str(out)], check=True)
    found = load_headset(str(out))
    # Monado's simulated HMD: two eyes that look straight ahead.
    assert "Monado" in found.source and min(found.eye_size_px) > 100 and found.refresh_hz > 10
    assert max(map(abs, found.cants_deg)) < 1 and found.overlap_deg > 30
    # It has a mask too: a triangle in each corner, an eighth of the view along each side.
    assert all(0.02 < eye.hidden_share < 0.05 for eye in found.eyes)


# --- record -------------------------------------------------------------------------------------


def places_in(path) -> np.ndarray:
    """Which of PLACES each pose is that has reached the disk; exactly one.

    A trace's reader would take the first of them for a tracker that had not begun.
    """
    meant = np.array([np.concatenate([pose.position_m, pose.orientation_xyzw]) for pose in PLACES])
    lines = [line for line in path.read_text().splitlines() if line[:1].isdigit()] if path.is_file() else []
    found = np.array([line.split(",")[1:8] for line in lines], float).reshape(-1, 7)
    near = np.abs(found[:, None] - meant[None]).max(axis=2) < 2 * FLOAT32
    assert (near.sum(axis=1) == 1).all()
    return near[:, 1].astype(int)


@contextlib.contextmanager
def meanwhile(path, do: Callable[[], None], seen: Callable[[], bool] = lambda: False) -> Iterator[None]:
    """Do it as soon as ten poses are on the disk; press Ctrl-C ten after what follows was seen."""
    over = threading.Event()

    def wait(there: Callable[[], bool]) -> None:
        while not there() and not over.is_set():
            time.sleep(0.02)

    def work() -> None:
        wait(lambda: len(places_in(path)) >= 10)
        do()
        wait(seen)
        count = len(places_in(path))
        wait(lambda: len(places_in(path)) >= count + 10)
        if not over.is_set():
            signal.raise_signal(signal.SIGINT)

    thread = threading.Thread(target=work)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


def recording(out: Path, said: list[str], reconnect_s: float, rate_hz: float = 20.0) -> None:
    record(RecordOptions(source="openxr", out=out, rate_hz=rate_hz, reconnect_s=reconnect_s), said.append)


def test_poses_are_the_runtime_s(remote_head, tmp_path):
    out, said = tmp_path / "head.csv", []
    remote_head.put(PLACES[0])
    with meanwhile(out, lambda: remote_head.put(PLACES[1]), lambda: places_in(out)[-1] == 1):
        recording(out, said, 1.0, rate_hz=50.0)
    places = places_in(out)
    assert (np.diff(places) >= 0).all() and (places[0], places[-1]) == (0, 1)
    track = load_trace(out).track
    # Monado's screen has 20 Hz. A busy machine samples late, after which the next one has its whole
    # period; now and then it is in time.
    assert track.duration_ns >= (len(track) - 2) * 49_000_000 and np.diff(track.time_ns).min() < 75_000_000
    assert "# rate: 20 Hz" in out.read_text().splitlines()
    assert "Monado" in track.origin and "headset" in track.origin
    assert "at 20 Hz, not at 50" in said[0]
    assert said[1].startswith("recording ") and said[-1].startswith(f"{out}: {len(places)} poses, ")


@pytest.mark.parametrize("returns", [True, False])
def test_a_runtime_that_dies_leaves_what_was_recorded(monado, tmp_path, returns):
    """One that comes back goes on in the same file, with a gap."""
    out, said, began = tmp_path / "head.csv", [], time.monotonic()

    def put() -> None:
        with RemoteHead() as head:
            head.put(PLACES[0])

    def fails() -> None:
        monado.kill()
        if returns:
            monado.start()
            put()

    put()
    ends = contextlib.nullcontext() if returns else pytest.raises(Lost, match="has not come back within 1 s")
    with meanwhile(out, fails, lambda: "it is back" in said), ends:
        recording(out, said, LONG_S if returns else 1.0)
    track = load_trace(out).track
    assert len(track) >= 10 and track.duration_ns < 1e9 * (time.monotonic() - began)
    assert not returns or track.broken[9:].any()
    assert "waiting up to" in said[1]
