"""The same window under Wayland.

Weston, drawn into a virtual X screen, so that xdotool's mouse and keyboard reach it.
"""

from __future__ import annotations

import needs
import numpy as np
import pytest

from .programs import Live, Process
from .virtual_screen import VirtualScreen

pytestmark = [needs.programs("Xvfb", "xdotool", "weston"), pytest.mark.slow]  # programs of their own: 10 s

NAME = "hmdwarp-test"


def middle(picture: np.ndarray) -> np.ndarray:
    """Where the flat view is, without Weston's own frame."""
    return picture[100:600, 400:700].astype(int)


@pytest.mark.parametrize("ends", ["by Escape", "with the compositor"])
def test_keys_and_mouse_reach_it_and_either_ends_it(tmp_path, ends):
    def apart(picture: np.ndarray) -> float:
        return np.abs(middle(picture) - first).mean()

    def shows(holds, what: str) -> np.ndarray:
        return program.until(lambda: [picture] if holds(picture := screen.picture()) else None, what)[0]

    for name in ("screen", "runtime"):
        (tmp_path / name).mkdir(mode=0o700)
    # A compositor with one window to a screen (its kiosk shell).
    command = ["weston", "--backend=x11-backend.so", "--use-pixman", "--shell=kiosk-shell.so", f"--socket={NAME}"]
    command += ["--width=1100", "--height=700", "--idle-time=0"]
    with VirtualScreen(tmp_path / "screen") as screen:
        known = {**screen.environment, "XDG_RUNTIME_DIR": str(tmp_path / "runtime")}
        with Process(tmp_path / "weston.txt", *command, env=known) as weston:
            weston.until((tmp_path / "runtime" / NAME).exists, "Weston's socket")
            how = {"DISPLAY": "", "XDG_RUNTIME_DIR": known["XDG_RUNTIME_DIR"], "WAYLAND_DISPLAY": NAME}
            program = Live(screen, tmp_path, "--view", "flat", "--out", "out", **how)
            try:
                shows(lambda p: middle(p).min(axis=-1).mean() > 60, "a flat view")
                if ends == "with the compositor":
                    weston.kill()
                else:
                    screen.do("sleep", 5)  # until the first words are gone
                    first = middle(screen.picture())
                    screen.do("mousemove", 500, 300, "click", 1, "sleep", 0.5)
                    screen.do("keydown", "w")
                    shows(lambda p: apart(p) > 6, "another place")
                    screen.do("keyup", "w")
                    screen.do("key", "r", "sleep", 1)
                    shows(lambda p: apart(p) < 6, "the first place again")
                    screen.do("mousemove_relative", 100, 0)
                    shows(lambda p: apart(p) > 6, "another direction")
                    screen.do("key", "Escape", "sleep", 0.5, "key", "Escape")
                status, told = program.ended()
            finally:
                program.kill()
    assert status == 0 and "the window was closed" in told and "Traceback" not in told
    assert (tmp_path / "out" / "summary.json").is_file()
