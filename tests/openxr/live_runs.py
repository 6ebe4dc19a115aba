"""`hmdwarp live` beside Monado.

As a program of its own, as users start it, or in this process, with every refresh at hand.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import display.programs

import hmdwarp.run.live_run as driver
from hmdwarp.pipeline import Refresh
from hmdwarp.run import LiveOptions, LiveResult

SMALL = (96, 120)
LONG_S = 600.0  # against hanging; a machine under load is slow, and may stand still


def quick(**options: object) -> LiveOptions:
    """Options of a run that costs little."""
    usual = {"source": "openxr", "scene": "planes", "size": SMALL, "latency_ms": 0.0}
    return LiveOptions(**{**usual, "warp": "forward", "fill": "none", "guard": 1.0, "predict": "none", **options})


class Watched:
    """A display that remembers what was shown.

    display: the real one, which does everything. before: called with each refresh that is about to
    be shown.
    """

    def __init__(self, display: object, before: Callable[[Refresh], None]) -> None:
        self.display, self._before = display, before
        self.shown: list[Refresh | None] = []

    def __getattr__(self, name: str) -> object:
        return getattr(self.display, name)

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


class Program(display.programs.Program):
    """A run as a program of its own, which records its head."""

    def __init__(self, folder: Path, *options: str) -> None:
        usual = ("--source", "openxr", "--scene", "planes", "--size", "x".join(map(str, SMALL)), "--latency", "60")
        super().__init__(folder, *usual, "--fill", "none", "--samples", "1", "--record", "head.csv", *options)
