"""An X server without a screen, and pictures of what is on it."""

from __future__ import annotations

import os
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray


class Screen:
    """Xvfb with a screen of (w, h) pixels and 24 bits.

    Use as a context manager. display: as DISPLAY has it, ":99".
    """

    def __init__(self, size: tuple[int, int] = (1280, 800)) -> None:
        self.size, self.display = size, ""

    def picture(self) -> NDArray[np.uint8]:
        """(h, w, 3) what is on the screen now, row 0 at the top.

        Xvfb keeps it in a file in the format of xwd, so no program is needed to take it.
        Source: X11/XWDFile.h: 25 big-endian words, a name, the colour map, the rows.
        """
        data = (Path(self._folder.name) / "Xvfb_screen0").read_bytes()
        words = np.frombuffer(data, ">u4", 25).tolist()
        head_size, width, height, order, bits, row_bytes, colours = (words[i] for i in (0, 4, 5, 7, 11, 12, 19))
        assert bits == 32, f"a screen of {bits} bits a pixel: expected 32"
        rows = np.frombuffer(data, np.uint8, height * row_bytes, head_size + 12 * colours).reshape(height, row_bytes)
        pixels = rows[:, : 4 * width].reshape(height, width, 4)
        return pixels[..., 1:] if order else pixels[..., 2::-1]  # xRGB, lowest byte last or first

    def kill(self) -> None:
        """It is gone, as when somebody logs out."""
        self._process.kill()
        self._process.wait()

    def __enter__(self) -> Screen:
        self._folder = tempfile.TemporaryDirectory(prefix="hmdwarp-screen-")
        screen = f"{self.size[0]}x{self.size[1]}x24"
        told, tells = os.pipe()
        with os.fdopen(told) as numbers:
            try:
                command = [
                    "Xvfb", "-displayfd", str(tells), "-screen", "0", screen, "-fbdir", self._folder.name,
                    "-nolisten", "tcp",
                ]  # fmt: skip
                silent = {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
                self._process = subprocess.Popen(command, pass_fds=[tells], **silent)
            finally:
                os.close(tells)
            number = numbers.readline().strip()
        if not number:
            self.__exit__()
            raise RuntimeError("Xvfb did not start")
        self.display = f":{number}"
        return self

    def __exit__(self, *_: object) -> None:
        self._process.terminate()
        self._process.wait()
        self._folder.cleanup()
