"""The harness itself: the service comes and goes, what is on the screen is seen."""

from __future__ import annotations

import subprocess
import sys

import numpy as np

from .monado import ON_SCREEN, WOBBLING


def test_the_service_comes_and_goes(runtime):
    monado = runtime(WOBBLING)
    for _ in range(2):
        monado.start()
        monado.pause()
        monado.resume()
        monado.kill()
    monado.kill()
    assert "monado" in monado.log.read_text(errors="replace").lower()


def test_the_screen_shows_the_picture(screen):
    """A window of one colour, all over the screen."""
    code = (
        "import glfw, moderngl, time; glfw.init(); glfw.window_hint(glfw.DECORATED, 0); w = glfw.create_window(2000, "
        "1200, '', None, None);"
        "glfw.set_window_pos(w, 0, 0); glfw.make_context_current(w); c = moderngl.create_context();"
        "[(c.clear(1.0, 0.5, 0.25), glfw.swap_buffers(w), glfw.poll_events(), time.sleep(0.05)) for _ in range(4)];"
        "c.finish(); print('there', flush=True); time.sleep(60)"
    )
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as window:
        assert window.stdout.readline() == "there\n"
        try:
            picture = screen.picture()
        finally:
            window.kill()
    assert picture.shape == (1200, 2000, 3)
    # 0.5 * 255 and 0.25 * 255 are rounded either way.
    assert np.abs(picture.astype(int) - [255, 127.5, 63.75]).max() <= 1


def test_the_compositor_starts_on_a_screen(screen, runtime):
    runtime(WOBBLING, ON_SCREEN).start()
