"""hmdwarp live in a window of a virtual screen, as a program of its own."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np

from .virtual_screen import PATIENCE_S, VirtualScreen, until

ROOT = Path(__file__).resolve().parents[2]
SMALL = (
    "--headset", "rift-dk1", "--size", "96x120", "--scene", "spheres", "--latency", "50", "--warp", "forward",
    "--no-panel", "--samples", "1",
)  # fmt: skip


class Live:
    """Use as a context manager; it waits until pictures are shown.

    Killed at the end, if it has not ended by itself.
    """

    def __init__(self, screen: VirtualScreen, folder: Path, *options: str) -> None:
        self.screen = screen
        self._told = folder / "told.txt"
        command = [sys.executable, "-m", "hmdwarp", "live", "--source", "desktop", *options]
        environment = {**screen.environment, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "error"}
        with self._told.open("w") as told:
            self._process = subprocess.Popen(
                command, stdout=told, stderr=subprocess.STDOUT, env=environment, cwd=folder
            )

    def __enter__(self) -> Live:
        until(lambda: self.window or self._over(), "a window")
        until(lambda: re.search(r"[1-9]\d* fps", self.title), "a title with the rate")
        return self

    def _over(self) -> None:
        assert self._process.poll() is None, self.told()

    @property
    def pid(self) -> int:
        """Its process."""
        return self._process.pid

    @property
    def running(self) -> bool:
        """Whether it has not ended."""
        return self._process.poll() is None

    @property
    def window(self) -> str:
        """xdotool's name of it."""
        return self.screen.do("search", "--name", "^hmdwarp").partition("\n")[0]

    @property
    def title(self) -> str:
        """What stands over it."""
        self._over()
        return self.screen.do("getwindowname", self.window)

    @property
    def geometry(self) -> tuple[int, int, int, int]:
        """x, y, w, h on the screen."""
        return self.screen.geometry(self.window)

    def press(self, *keys: str) -> None:
        """Each key once."""
        for key in keys:
            self.screen.do("key", key)

    def titled(self, *parts: str) -> str:
        """Waits until all of these are in the title."""
        return until(
            lambda: (title := self.title) and all(part in title for part in parts) and title,
            f"{parts} in {self.title!r}",
        )

    def picture(self) -> np.ndarray:
        """(h, w, 3) bytes of the window."""
        x, y, w, h = self.geometry
        return self.screen.picture()[y : y + h, x : x + w]

    def shows(self, holds, what: str) -> np.ndarray:
        """Waits for a picture of which that holds."""

        last = None

        def seen() -> bool:
            nonlocal last
            last = self.picture()
            return holds(last)

        until(seen, what)
        return last

    def told(self) -> str:
        """What it printed."""
        return self._told.read_text(encoding="utf-8")

    def ended(self) -> tuple[int, str]:
        """Its exit status, once it has ended by itself, and what it printed."""
        return self._process.wait(PATIENCE_S), self.told()

    def __exit__(self, *_: object) -> None:
        if self._process.poll() is None:
            self._process.kill()
            self._process.wait(PATIENCE_S)
