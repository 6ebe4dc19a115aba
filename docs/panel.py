"""Draw docs/live.png: hmdwarp live on a virtual screen of 1280x800. Needs Xvfb and xdotool.

By hand: .venv/bin/python docs/panel.py
"""

from __future__ import annotations

import os
import shlex
import signal
import struct
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from PIL import Image

SCREEN = (1280, 800)
RUN = shlex.split("--source desktop --full-screen --scene room --size 320x400 --latency 200 --fill pyramid")
WALK_S = 20.0  # the plots hold the last 240 refreshes


def panel_picture(path: Path) -> None:
    """Walk through a scene for WALK_S and save the screen."""
    width, height = SCREEN
    with tempfile.TemporaryDirectory() as folder:
        read, write = os.pipe()
        options = f"-displayfd {write} -screen 0 {width}x{height}x24 -nolisten tcp -fbdir"
        screen = ["Xvfb", *shlex.split(options), folder]
        server = subprocess.Popen(screen, pass_fds=[write], stderr=subprocess.DEVNULL)
        os.close(write)
        try:
            with os.fdopen(read) as numbers:
                display = f":{numbers.readline().strip()}"
            picture = _walked(display, Path(folder) / "Xvfb_screen0")
        finally:
            server.terminate()
            server.wait()
    Image.fromarray(picture).save(path, optimize=True)


def _walked(display: str, kept: Path) -> np.ndarray:
    """Return the screen after walking from side to side for WALK_S. kept: Xvfb's screen file."""
    environment = {**os.environ, "DISPLAY": display}
    environment.pop("WAYLAND_DISPLAY", None)
    live = subprocess.Popen([sys.executable, "-m", "hmdwarp", "live", *RUN, "--quiet"], env=environment)
    try:
        until = time.monotonic() + WALK_S
        while time.monotonic() < until:
            for key in "da":
                subprocess.run(["xdotool", "keydown", key, "sleep", "1.2", "keyup", key], env=environment, check=True)
        subprocess.run(["xdotool", "keydown", "d", "sleep", "0.5"], env=environment, check=True)
        if live.poll() is not None:
            raise SystemExit(f"hmdwarp live ended with {live.returncode}")
        live.send_signal(signal.SIGSTOP)  # or its next picture would be half there
        return read_screen(kept)
    finally:
        live.kill()
        live.wait()


def read_screen(path: Path) -> np.ndarray:
    """Return (h, w, 3) uint8 from the file that Xvfb keeps its screen in. Source: X11/XWDFile.h."""
    data = path.read_bytes()
    head = struct.unpack(">25I", data[:100])
    header, width, height, stride, colours = head[0], head[4], head[5], head[12], head[19]
    rows = np.frombuffer(data, np.uint8, stride * height, header + 12 * colours).reshape(height, stride // 4, 4)
    return np.ascontiguousarray(rows[:, :width, [2, 1, 0]])  # little endian: blue comes first


if __name__ == "__main__":
    panel_picture(Path(__file__).with_name("live.png"))
