"""`hmdwarp live` beside Monado.

As a program of its own, as users start it, or in this process, with every refresh at hand.
"""

from __future__ import annotations

import json
import re
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import hmdwarp.run.live_run as driver
from hmdwarp.display import Tick
from hmdwarp.pipeline import Refresh
from hmdwarp.report import validate_summary
from hmdwarp.run import LiveOptions, LiveResult

SMALL = (96, 120)
LONG_S = 600.0  # against hanging; a machine under load is slow, and may stand still


def quick(**options: object) -> LiveOptions:
    """Options of a run that costs little."""
    usual = {"source": "openxr", "scene": "planes", "size": SMALL, "latency_ms": 0.0}
    return LiveOptions(**{**usual, "warp": "forward", "fill": "none", "guard": 1.0, "predict": "none", **options})


class Watched:
    """A display that remembers its ticks and what was shown for them.

    display: the real one, which does everything.

    before: called with each refresh that is about to be shown.
    """

    def __init__(self, display: object, before: Callable[[Refresh], None]) -> None:
        self.display, self._before = display, before
        self.ticks: list[Tick] = []
        self.shown: list[Refresh | None] = []

    def __getattr__(self, name: str) -> object:
        return getattr(self.display, name)

    def wait(self) -> Tick | None:
        """As Display.wait."""
        tick = self.display.wait()
        if tick is not None:
            self.ticks.append(tick)
        return tick

    def show(self, refresh: Refresh | None, label: str = "") -> int:
        """As Display.show."""
        if refresh is not None:
            self._before(refresh)
        self.shown.append(refresh)
        return self.display.show(refresh, label)


class Here:
    """A run in this process.

    said: the sentences it told. watched: its display, once it is open. before: as Watched.
    """

    def __init__(self, monkeypatch, before: Callable[[Refresh], None] = lambda refresh: None) -> None:
        self.said: list[str] = []
        self.watched: Watched | None = None
        opened = driver.open_display

        def watch(*arguments: object) -> Watched:
            self.watched = Watched(opened(*arguments), before)
            return self.watched

        monkeypatch.setattr(driver, "open_display", watch)

    def run(
        self,
        options: LiveOptions,
        after: Callable[[int], None] = lambda number: None,
        said: Callable[[str], None] = lambda text: None,
    ) -> LiveResult:
        """As live.run.live; said(text) is called with each sentence too."""

        def say(text: str) -> None:
            self.said.append(text)
            said(text)

        return driver.live(options, say, after)

    def head(self):
        """Where the runtime says the head is just now."""
        return self.watched.source.head_at(self.watched.now_ns()).pose


class Program:
    """A run as a program of its own.

    Use as a context manager. recording: the head's trace it writes.
    """

    def __init__(self, folder: Path, *options: str) -> None:
        self.recording = folder / "head.csv"
        size = f"{SMALL[0]}x{SMALL[1]}"
        command = [sys.executable, "-m", "hmdwarp", "live", "--source", "openxr", "--scene", "planes", "--size", size]
        command += ["--latency", "60", "--fill", "none", "--samples", "1", "--record", str(self.recording), *options]
        self._process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
            errors="replace",
        )  # fmt: skip
        self._lines: list[str] = []
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        self._lines.extend(self._process.stdout)

    @property
    def said(self) -> str:
        """All it has said so far; Monado's own noise is among it."""
        return "".join(self._lines)

    def recorded(self) -> int:
        """How many poses have reached the disk."""
        if not self.recording.is_file():
            return 0
        return sum(line[:1].isdigit() for line in self.recording.read_text(encoding="utf-8").splitlines())

    def until_recorded(self, count: int) -> None:
        """Wait for that many."""
        self._until(lambda: self.recorded() >= count, f"{count} poses")

    def until_said(self, pattern: str) -> None:
        """Wait for something said."""
        self._until(lambda: re.search(pattern, self.said) is not None, f"'{pattern}'")

    def _until(self, there: Callable[[], bool], what: str) -> None:
        until = time.monotonic() + LONG_S
        while not there():
            assert self._process.poll() is None, (
                f"it ended with {self._process.returncode} before {what}, and said:\n{self.said}"
            )
            assert time.monotonic() < until, f"no {what} within {LONG_S:g} s; it said:\n{self.said}"
            time.sleep(0.05)

    def send(self, number: signal.Signals) -> None:
        """A signal."""
        self._process.send_signal(number)

    def status(self) -> int:
        """How it ended, below 0 for a signal; waits for that."""
        status = self._process.wait(LONG_S)
        self._reader.join()
        return status

    def __enter__(self) -> Program:
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self.status()
        self._process.stdout.close()


def many_frames(here: Here, out: Path, count: int, graphics: str) -> None:
    """Run so many, and check what came of them. graphics: how they are to be drawn."""
    ages, heads = [], []

    def after(_: int) -> None:
        refresh = here.watched.shown.pop()
        ages.append(refresh.age_ns)
        heads.append(refresh.head.time_ns)

    summary = here.run(quick(pictures=count, latency_ms=175.0, out=out), after).summary
    validate_summary(json.loads((out / "summary.json").read_text(encoding="utf-8")))
    assert here.watched.about["graphics"] == graphics
    assert summary["frames"] == len(ages) == count
    assert min(ages) >= 175e6
    assert len(set(heads)) == count and heads == sorted(heads)
