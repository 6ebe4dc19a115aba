"""Programs of their own that tests lead: hmdwarp live as users start it, windows, services."""

from __future__ import annotations

import json
import os
import re
import select
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from .virtual_screen import PATIENCE_S, VirtualScreen, until

ROOT = Path(__file__).resolve().parents[2]
PATHS = os.pathsep.join([str(ROOT), str(ROOT / "tests")])
SMALL = (
    "--headset", "rift-dk1", "--size", "96x120", "--scene", "spheres", "--latency", "50", "--warp", "forward",
    "--no-panel", "--samples", "1",
)  # fmt: skip


class Process:
    """A program that prints into a file. As a context manager it is killed at the end, if it has
    not ended by itself.
    """

    def __init__(self, told: Path, *command: str, **how: Any) -> None:
        self._told = told
        with told.open("w") as out:
            how = {"stdin": subprocess.DEVNULL, **how}
            self._process = subprocess.Popen(command, stdout=out, stderr=subprocess.STDOUT, **how)

    @property
    def pid(self) -> int:
        return self._process.pid

    @property
    def told(self) -> str:
        """All it has printed so far."""
        return self._told.read_text(encoding="utf-8", errors="replace")

    def until(self, holds: Callable[[], Any], what: str) -> Any:
        """Wait for it while the program runs; return what it gave."""

        def look() -> Any:
            assert self._process.poll() is None, f"it ended before {what}:\n{self.told}"
            return holds()

        return until(look, what)

    def until_told(self, pattern: str) -> None:
        self.until(lambda: re.search(pattern, self.told), f"'{pattern}'")

    def send(self, number: signal.Signals) -> None:
        self._process.send_signal(number)

    def ended(self) -> tuple[int, str]:
        """Its exit status, once it has ended by itself, and what it printed."""
        return self._process.wait(PATIENCE_S), self.told

    def kill(self) -> None:
        self._process.kill()
        self._process.wait(PATIENCE_S)

    def __enter__(self):
        return self

    def __exit__(self, *_: object) -> None:
        self.kill()


class Program(Process):
    """hmdwarp live. recording: where it writes the head's trace, if it does."""

    def __init__(self, folder: Path, *options: str, environment: dict[str, str] | None = None) -> None:
        self.recording = folder / "head.csv"
        command = (sys.executable, "-m", "hmdwarp", "live", *options)
        super().__init__(folder / "told.txt", *command, env=environment, cwd=folder)

    def recorded(self) -> int:
        """How many poses have reached the disk."""
        text = self.recording.read_text(encoding="utf-8") if self.recording.is_file() else ""
        return sum(line[:1].isdigit() for line in text.splitlines())

    def until_recorded(self, count: int) -> None:
        self.until(lambda: self.recorded() >= count, f"{count} poses")


class Live(Program):
    """One with a window on that screen; as a context manager it waits until pictures are shown."""

    def __init__(self, screen: VirtualScreen, folder: Path, *options: str, **changed: str) -> None:
        self.screen = screen
        environment = {**screen.environment, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "error", **changed}
        super().__init__(folder, "--source", "desktop", *SMALL, *options, environment=environment)

    def __enter__(self):
        self.until(lambda: self.window, "a window")
        self.until(lambda: re.search(r"[1-9]\d* fps", self.title), "a title with the rate")
        return self

    @property
    def window(self) -> str:
        """xdotool's name of it."""
        return self.screen.do("search", "--name", "^hmdwarp").partition("\n")[0]

    @property
    def title(self) -> str:
        return self.screen.do("getwindowname", self.window)

    @property
    def geometry(self) -> tuple[int, int, int, int]:
        """x, y, w, h on the screen."""
        return self.screen.geometry(self.window)

    def press(self, *keys: str) -> None:
        """Each key once."""
        for key in keys:
            self.screen.do("key", key)

    def titled(self, *parts: str) -> None:
        """Wait until all of these are in the title."""
        self.until(lambda: (title := self.title) and all(part in title for part in parts), f"{parts} in the title")

    def picture(self) -> np.ndarray:
        """(h, w, 3) bytes of the window."""
        x, y, w, h = self.geometry
        return self.screen.picture()[y : y + h, x : x + w]

    def shows(self, holds: Callable[[np.ndarray], Any], what: str) -> np.ndarray:
        """Wait for a picture of which that holds, and return it."""
        return self.until(lambda: [picture] if holds(picture := self.picture()) else None, what)[0]


def tell(**known: object) -> None:
    """What a led program tells."""
    print(json.dumps(known), flush=True)


def lines_now(wait_s: float = 0.0) -> list[str]:
    """The lines that a led program has been sent by now."""
    return os.read(0, 1 << 12).decode().split() if select.select([0], [], [], wait_s)[0] else []


class Led(Process):
    """A module of this folder on that screen, led line by line through its standard input.

    It tells JSON, a line each, and answers a line with one that has it as "line".
    """

    def __init__(self, screen: VirtualScreen, folder: Path, module: str) -> None:
        self.screen, self._heard = screen, 0
        command = (sys.executable, "-W", "error", "-m", f"display.{module}")
        environment = {**screen.environment, "PYTHONPATH": PATHS}
        super().__init__(folder / f"{module}.jsonl", *command, stdin=subprocess.PIPE, text=True, env=environment)

    @property
    def events(self) -> list[dict[str, Any]]:
        """All that it has told, oldest first."""
        assert self._process.poll() is None and "Traceback" not in self.told, self.told
        return [json.loads(line) for line in self.told.splitlines(keepends=True) if line.endswith("\n")]

    def say(self, line: str) -> dict[str, Any]:
        """Wait until that is done; return the answer."""

        def answers() -> list[dict[str, Any]]:
            return [event for event in self.events if event.get("line") == line]

        before = len(answers())
        self._process.stdin.write(f"{line}\n")
        self._process.stdin.flush()
        return until(lambda: answers()[before:], line)[0]

    def heard(self, key: str) -> list[dict[str, Any]]:
        """All it told that has that key, since this was asked last."""
        events = self.events
        found, self._heard = events[self._heard :], len(events)
        return [event for event in found if key in event]

    def __enter__(self):
        self.until(lambda: self.told.endswith("\n"), "a first line")
        return self

    def __exit__(self, kind: object, *_: object) -> None:
        """Have it end, and see that it does well."""
        try:
            if kind is None:
                self._process.communicate("end\n", PATIENCE_S)
                assert self._process.returncode == 0, self.told
        finally:
            self.kill()
            self._process.stdin.close()
