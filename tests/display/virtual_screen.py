"""A virtual screen (Xvfb) with a real mouse and keyboard (xdotool), and what is to be seen on it.

Needs Xvfb and xdotool, nothing else: the screen's memory is a file that Xvfb keeps in X's own
picture format (XWD), which is read here.
"""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import needs
import numpy as np

PATIENCE_S = 600.0  # against hanging alone


needs_a_screen = needs.programs("Xvfb", "xdotool")


class VirtualScreen:
    """Use as a context manager.

    display: for DISPLAY. folder: an empty one for the screen's memory.
    """

    def __init__(self, folder: Path, size: tuple[int, int] = (1280, 800)) -> None:
        self._folder, self.size = folder, size

    def __enter__(self) -> VirtualScreen:
        read, write = os.pipe()
        mode = f"{self.size[0]}x{self.size[1]}x24"
        # A key that a busy machine keeps down for 0.7 s would be typed twice.
        how = ["-nolisten", "tcp", "-noreset", "-ardelay", "3000", "-fbdir", str(self._folder)]
        command = ["Xvfb", "-displayfd", str(write), "-screen", "0", mode, *how]
        self._server = subprocess.Popen(command, pass_fds=[write], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write)
        with os.fdopen(read) as told:
            number = told.readline().strip()
        assert number, "Xvfb did not start"
        self.display = f":{number}"
        return self

    @property
    def environment(self) -> dict[str, str]:
        """For programs that are to be on this screen."""
        apart = ("WAYLAND_DISPLAY", "XDG_SESSION_TYPE")
        kept = {name: value for name, value in os.environ.items() if name not in apart}
        return {**kept, "DISPLAY": self.display}

    def do(self, *arguments: object) -> str:
        """xdotool with these arguments, as one who sits there: what it printed."""
        how = {"capture_output": True, "text": True, "env": self.environment, "timeout": PATIENCE_S}
        done = subprocess.run(["xdotool", *map(str, arguments)], check=False, **how)
        return done.stdout.strip()

    def geometry(self, window: str) -> tuple[int, int, int, int]:
        """x, y, w, h of a window."""
        lines = dict(line.split("=") for line in self.do("getwindowgeometry", "--shell", window).splitlines())
        return tuple(int(lines[name]) for name in ("X", "Y", "WIDTH", "HEIGHT"))

    def picture(self) -> np.ndarray:
        """(h, w, 3) bytes, top row first, of the whole screen as it is now.

        Source: XWDFile.h, version 7: 25 words of the header, big endian, then the window's name,
        the colours of 12 bytes each, the pixels.
        """
        data = (self._folder / "Xvfb_screen0").read_bytes()
        header = np.frombuffer(data, ">u4", 25)
        width, height, blue_first, line, colours = (int(header[k]) for k in (4, 5, 7, 12, 19))
        start = int(header[0]) + 12 * colours
        rows = np.frombuffer(data, np.uint8, line * height, start).reshape(height, line)
        pixels = rows[:, : 4 * width].reshape(height, width, 4)
        return pixels[..., 2::-1] if blue_first == 0 else pixels[..., 1:]

    def __exit__(self, *_: object) -> None:
        self._server.terminate()
        self._server.wait(PATIENCE_S)


def until(holds: Callable[[], object], what: str, found_instead: Callable[[], str] = lambda: "it is not so"):
    """Waits for it; what it gave.

    found_instead: asked at the end of its patience, for the message.
    """
    end = time.monotonic() + PATIENCE_S
    while time.monotonic() < end:
        found = holds()
        if found:
            return found
        time.sleep(0.05)
    raise AssertionError(f"not within {PATIENCE_S:g} s: {what}; {found_instead()}")
