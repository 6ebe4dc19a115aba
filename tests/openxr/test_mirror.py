"""The window beside the headset.

GLX's context draws for the runtime, the left eye is seen, the keys do what they say.
"""

from __future__ import annotations

import subprocess
import time

import numpy as np
import pytest

from hmdwarp.colour import picture_from_linear
from hmdwarp.display import Closed, Command, DisplayOptions
from hmdwarp.display.openxr import OpenXrDisplay
from hmdwarp.gpu import download, flip_rows

from .live_runs import Here, Program, quick
from .monado import UNSEEN, WOBBLING

WINDOW = 480
SIZE = (120, 120)  # of the window's shape, in whole pixels of it


def press(*keys: str) -> None:
    """In the window that has the keyboard, as a user does."""
    subprocess.run(["xdotool", "key", *keys], check=True)


def until(display, seen) -> None:
    """Frames, until something was seen."""
    for _ in range(20_000):
        if display.wait() is not None:
            display.show(None, "a text")
        if seen():
            return
    pytest.fail("not seen within 20,000 refreshes")


def test_the_left_eye_is_on_the_screen(runtime, screen, monkeypatch):
    runtime(WOBBLING, UNSEEN).start()
    here, found = Here(monkeypatch), []

    def after(number: int) -> None:
        left, right = (picture_from_linear(download(eye.panel.texture))[..., :3] for eye in here.watched.shown[-1].eyes)
        here.watched.gpu.gl.finish()
        time.sleep(0.02)  # the X server's turn
        on_screen = screen.picture()[:WINDOW, :WINDOW].astype(float)
        # Scaled up bilinearly by four: the mean of a block is its pixel's, but for a part of its
        # neighbours'.
        blocks = on_screen.reshape(SIZE[1], 4, SIZE[0], 4, 3).mean((1, 3))
        found.append([np.abs(blocks - picture).mean() for picture in (left, right, flip_rows(left))])

    here.run(quick(pictures=6, size=SIZE, scene="spheres", depth_layer=False), after)
    assert here.watched.about["graphics"] == "GLX"
    this, other_eye, upside_down = min(found)  # the window leaves out pictures that come too fast, so not each is there
    assert this < 6
    assert this < 0.7 * other_eye and this < 0.3 * upside_down


def test_keys_are_the_controls(runtime, screen):
    runtime(WOBBLING, UNSEEN).start()
    display, asked = OpenXrDisplay(DisplayOptions(size=SIZE)), []
    try:
        press(
            "t", "shift+f", "bracketleft", "v", "r"
        )  # one view and the runtime's own recentring: the last two are nothing here

        def all_heard() -> bool:
            asked.extend(display.commands())
            return len(asked) >= 3

        until(display, all_heard)
        assert asked == [Command("warp"), Command("fill", back=True), Command("latency", back=True)]
        before = screen.picture()[:WINDOW, :WINDOW]
        press("h")
        until(display, lambda: (screen.picture()[:WINDOW, :WINDOW] != before).mean() > 0.05)
        press("Escape")  # closes the help
        until(display, lambda: (screen.picture()[:WINDOW, :WINDOW] != before).mean() < 0.05)
        press("Escape")
        with pytest.raises(Closed, match="window was closed"):
            until(display, lambda: False)
    finally:
        display.close()


def test_a_screen_that_is_gone_ends_it_with_everything_written(runtime, screen, tmp_path):
    runtime(WOBBLING, UNSEEN).start()
    with Program(tmp_path) as program:
        program.until_recorded(5)
        screen.kill()
        assert program.status() == 0
        assert "the connection to the screen broke" in program.said
        assert program.recorded() >= 5


def test_a_window_closed_while_the_runtime_is_away_ends_it(runtime, screen, tmp_path):
    monado = runtime(WOBBLING, UNSEEN)
    monado.start()
    with Program(tmp_path, "--reconnect", "60") as program:
        program.until_recorded(5)
        monado.kill()
        program.until_said("waiting up to 60 s")
        press("Escape")
        assert program.status() == 0
        assert "the window was closed" in program.said
