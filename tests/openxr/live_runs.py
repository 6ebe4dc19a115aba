"""`hmdwarp live` beside Monado.

As a program of its own, as users start it, or in this process, with every refresh at hand.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import display.programs

import hmdwarp.run.live_run as driver
from hmdwarp.display import Display
from hmdwarp.pipeline import Refresh
from hmdwarp.run import LiveOptions, LiveResult

SMALL = (96, 120)
LONG_S = 600.0  # against hanging; a machine under load is slow, and may stand still


def quick(**options: object) -> LiveOptions:
    """Options of a run that costs little."""
    usual = {"source": "openxr", "scene": "planes", "size": SMALL, "latency_ms": 0.0, "hang_s": LONG_S}
    return LiveOptions(**{**usual, "warp": "forward", "fill": "none", "guard": 1.0, "predict": "none", **options})


class Here:
    """A run in this process.

    said: the sentences it told. display: once it is open. shown: what it was given. before: called
    with each refresh that is about to be shown.
    """

    def __init__(self, monkeypatch, before: Callable[[Refresh], None] = lambda refresh: None) -> None:
        self.said: list[str] = []
        self.shown: list[Refresh | None] = []
        self.display: Display | None = None
        opened = driver.open_display

        def watch(*arguments: object) -> Display:
            self.display = opened(*arguments)
            show = self.display.show

            def noted(refresh: Refresh | None, label: str = "") -> int:
                if refresh is not None:
                    before(refresh)
                self.shown.append(refresh)
                return show(refresh, label)

            self.display.show = noted
            return self.display

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


class Program(display.programs.Program):
    """A run as a program of its own, which records its head."""

    def __init__(self, folder: Path, *options: str) -> None:
        usual = ("--source", "openxr", "--scene", "planes", "--size", "x".join(map(str, SMALL)), "--latency", "60")
        super().__init__(folder, *usual, "--fill", "none", "--samples", "1", "--record", "head.csv", *options)
