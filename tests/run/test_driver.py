"""A stretch of refreshes by somebody else's rules.

The server draws ahead of the pictures, and a plate outlasts what the tracking does.
"""

from __future__ import annotations

import attrs
import numpy as np
import pytest

from hmdwarp.display import Lost, Tick
from hmdwarp.run import Driver, Ending, FrameHandler, LiveLog, LiveOptions, PipelineHost

from .offscreen import PERIOD_NS, SIZE, OffscreenDisplay

LATENCY_MS = 60.0


@attrs.frozen
class ATextPanel:
    """Something that lies over the picture."""

    def ink(self):
        return np.full((8, 8), 255, np.uint8)


class Led(FrameHandler):
    """So many refreshes without pictures, then so many with."""

    ahead = True

    def __init__(self, before: int, pictures: int, label="") -> None:
        self.pictures, self._label = False, label
        self._before, self._left = before, before + pictures
        self.heads, self.why = [], []

    def over(self) -> bool:
        return self._left == 0

    def label(self):
        return "" if self.pictures else self._label

    def handle(self, commands) -> bool:
        self._left -= 1
        self._before -= 1
        self.pictures = self._before <= 0
        return False

    def arrived(self, refresh) -> None:
        self.heads.append(refresh.head)

    def on_display_lost(self, why: str) -> None:
        self.why.append(why)


@pytest.fixture
def led(gpu):
    """Runs a watch on a display of its own; returns the display and the log."""

    def runs(watch: FrameHandler, log: bool = True, **more):
        options = LiveOptions(
            scene="planes", headset="rift-dk1", latency_ms=LATENCY_MS, warp="none", fill="none", size=SIZE,
            reconnect_s=0.05,
        )  # fmt: skip
        with OffscreenDisplay(gpu=gpu, keeps=True, **more) as display, LiveLog(options) as made:
            host = PipelineHost(display, options)
            made.begin(display, host)
            Driver(display, host, Ending(None, None), display.said.append).run(watch, made if log else None)
            made.leave()
            host.close()
        return display, made

    return runs


def test_frames_drawn_ahead_are_there_at_the_first_picture(led):
    """Longer ahead than frames are under way.

    No picture is black, and none is younger than the latency.
    """
    ahead = round(LATENCY_MS * 1e6) // PERIOD_NS + 1
    display, log = led(Led(ahead, 5))
    shown = [picture.any() for picture in display.pictures]
    assert shown == [False] * ahead + [True] * 5
    assert log.count == 5
    assert log.result().summary["live"]["waiting"] == 0
    assert log.result().summary["live"]["age_ms"]["median"] >= LATENCY_MS


def test_a_frame_handler_gets_every_frame(led):
    watch = Led(10, 5)
    led(watch)
    assert 5 < len(watch.heads) <= 15
    times = [head.time_ns for head in watch.heads]
    assert times == sorted(set(times))


def test_a_plate_outlasts_the_tracking_and_a_frame_handler_learns_of_a_lost_display(led):
    lost = {2: Tick(0, 0, notice="tracking lost"), 12: Tick(0, 0, notice="tracking lost"), 14: Lost("it went away")}
    watch = Led(10, 6, ATextPanel())
    display, _ = led(watch, events=lost)
    assert (display.labels[2], display.labels[12]) == (ATextPanel(), "tracking lost")
    assert watch.why == ["it went away"] and display.said[-1] == "it is back"
