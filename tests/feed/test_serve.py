"""A server and its client in two processes: what crosses the feed is what would be drawn here."""

import os
import queue
import subprocess
import sys
import threading

import numpy as np
import pytest
from replays import small

pytest.importorskip("zmq", reason="pyzmq is not installed: pip install 'hmdwarp[feed]'")

from hmdwarp.errors import InputError
from hmdwarp.feed.listener import Listener
from hmdwarp.gpu import download
from hmdwarp.run import replay, set_up_replay


class Serving:
    """`hmdwarp serve` in a process of its own, at a port that was free."""

    def __init__(self, *options: str) -> None:
        command = [sys.executable, "-m", "hmdwarp", "serve", "--scene", "planes", "--listen", "127.0.0.1:*", *options]
        self.process = subprocess.Popen(
            command, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL, text=True, env=os.environ
        )
        self.lines: queue.Queue[str] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()
        self.address = self.line("listening at").split()[2].rstrip(":")

    def _read(self) -> None:
        assert self.process.stderr is not None
        for line in self.process.stderr:
            self.lines.put(line)

    def line(self, start: str) -> str:
        """Wait for a line of the log; the limit is a fail-safe."""
        while True:
            line = self.lines.get(timeout=300)
            if start in line:
                return line

    def __enter__(self) -> "Serving":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        self.process.wait()
        self._reader.join()
        assert self.process.stderr is not None
        self.process.stderr.close()


@pytest.fixture(scope="module")
def serving():
    with Serving() as one:
        yield one


def pictures(options) -> tuple[list, list[tuple[int, int]], list[str]]:
    """Return per refresh (instant shown, age, both eyes), and the delays."""
    found = []
    with set_up_replay(options) as setup:
        for number, instant_ns in setup.schedule.numbered():
            setup.loop.draw(instant_ns)
            refresh = setup.loop.show(instant_ns) if number >= 0 else None
            if refresh is not None:
                eyes = [download(eye.shown.texture) for eye in refresh.eyes]
                found.append((refresh.shown_ns, refresh.age_ns, eyes))
        return found, list(setup.remote.delays_ns) if setup.remote is not None else [], list(setup.notes)


def test_what_is_shown_equals_an_offline_replay_of_the_same_ages_bit_for_bit(serving, tmp_path):
    asked = {"start_s": 0.4, "seconds": 0.4, "warp": "forward", "fill": "none", "guard": 1.25}
    done = replay(small(tmp_path / "out", connect=serving.address, **asked))
    start = next(note for note in done.summary["notes"] if "--start" in note).split("--start ")[1].split()[0]
    assert float(start) == pytest.approx(0.4, abs=1e-9)
    online = {
        row["frame"]: (row["time_ms"], row["age_ms"]) for row in done.rows if row["eye"] == 0
    }
    assert online


def test_every_picture_is_the_one_drawn_here(serving, tmp_path):
    asked = {"start_s": 0.4, "seconds": 0.4, "warp": "forward", "fill": "none", "guard": 1.25}
    online, delays, _ = pictures(small(connect=serving.address, **asked))
    path = tmp_path / "delays.csv"
    path.write_text("".join(f"{delay / 1e6!r}\n" for _, delay in delays))
    from hmdwarp.link.delays.trace import DelayTrace
    from hmdwarp.link import LinkOptions

    network = LinkOptions(delay=DelayTrace.parse(str(path)))
    offline, _, _ = pictures(small(network=network, **asked))
    print(len(online), len(offline), len(delays))
    theirs = {shown: (age, eyes) for shown, age, eyes in offline}
    for shown, age, eyes in online:
        assert theirs[shown][0] == age
        for ours, other in zip(eyes, theirs[shown][1], strict=True):
            np.testing.assert_array_equal(ours, other)
