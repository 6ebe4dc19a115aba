"""The window beside the headset.

GLX's context draws for the runtime, the left eye is seen, the keys do what they say.
"""

from __future__ import annotations

import signal
import time

import numpy as np
import pytest

from hmdwarp.base import picture_from_linear
from hmdwarp.display import Closed, Command, DisplayOptions
from hmdwarp.display.openxr import OpenXrDisplay
from hmdwarp.gpu import download, flip_rows

from .live_runs import Here, Program, quick
from .monado import UNSEEN, WOBBLING

WINDOW = 480
SIZE = (120, 120)  # of the window's shape, in whole pixels of it


def test_the_left_eye_is_on_the_screen(wobbling, screen, monkeypatch):
    here, found = Here(monkeypatch), []

    def after(number: int) -> None:
        left, right = (picture_from_linear(download(eye.panel.texture))[..., :3] for eye in here.shown[-1].eyes)
        here.display.gpu.gl.finish()
        time.sleep(0.02)  # the X server's turn
        on_screen = screen.picture()[:WINDOW, :WINDOW].astype(float)
        # Scaled up bilinearly by four: the mean of a block is its pixel's, but for a part of its
        # neighbours'.
        blocks = on_screen.reshape(SIZE[1], 4, SIZE[0], 4, 3).mean((1, 3))
        found.append([np.abs(blocks - picture).mean() for picture in (left, right, flip_rows(left))])

    here.run(quick(pictures=6, size=SIZE, scene="spheres", depth_layer=False), after)
    assert here.display.about["graphics"] == "GLX"
    this, other_eye, upside_down = min(found)  # the window leaves out pictures that come too fast, so not each is there
    assert this < 6
    assert this < 0.7 * other_eye and this < 0.3 * upside_down


def test_keys_are_the_controls(wobbling, screen):
    display, asked = OpenXrDisplay(DisplayOptions(size=SIZE)), []

    def until(seen) -> None:
        for _ in range(20_000):
            if display.wait() is not None:
                display.show(None, "a text")
            if seen():
                return
        pytest.fail("not seen within 20,000 refreshes")

    def all_heard() -> bool:
        asked.extend(display.commands())
        return len(asked) >= 3

    def changed() -> float:
        return (screen.picture()[:WINDOW, :WINDOW] != before).mean()

    try:
        # One view and the runtime's own recentring: the last two are nothing here.
        screen.do("key", "t", "shift+f", "bracketleft", "v", "r")
        until(all_heard)
        assert asked == [Command("warp"), Command("fill", back=True), Command("latency", back=True)]
        before = screen.picture()[:WINDOW, :WINDOW]
        screen.do("key", "h")
        until(lambda: changed() > 0.05)
        screen.do("key", "Escape")  # closes the help
        until(lambda: changed() < 0.05)
        screen.do("key", "Escape")
        with pytest.raises(Closed, match="window was closed"):
            until(lambda: False)
    finally:
        display.close()


def test_a_window_that_is_closed_while_the_runtime_is_away_ends_it(wobbling, screen, tmp_path):
    with Program(tmp_path, "--reconnect", "60") as program:
        program.until_recorded(5)
        wobbling.kill()
        program.until_told("waiting up to 60 s")
        screen.do("key", "Escape")
        status, told = program.ended()
        assert status == 0 and program.recorded() >= 5 and "the window was closed" in told


def test_the_headset_is_taken_where_there_is_one_and_else_the_window(runtime, screen, tmp_path):
    monado = runtime(WOBBLING, UNSEEN)
    with Program(tmp_path, "--source", "auto", "--no-panel") as program:
        program.until_told("no headset: the OpenXR runtime's service does not answer")
        program.until_recorded(5)
        program.send(signal.SIGINT)
        assert program.ended()[0] == 0
    monado.start()
    with Program(tmp_path, "--source", "auto", "--pictures", "3", "--force") as program:
        status, told = program.ended()
    assert status == 0 and "no headset" not in told
    assert "Monado" in program.recording.read_text(encoding="utf-8")
