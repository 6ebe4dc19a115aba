"""The display without a screen, with what tests want of one.

Things happen at the n-th wait, and what was shown is kept.

The head is read and the picture handed over at instants of their own within a refresh, as beside a
real screen.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from unittest.mock import patch

import attrs
import numpy as np

from hmdwarp.display import Closed, Command, DisplayOptions, Label, Tick, offscreen
from hmdwarp.gpu import Gpu
from hmdwarp.poses import LoopedSource, PoseSample, PoseTrack, synthesise
from hmdwarp.run import LiveOptions
from hmdwarp.run import live_run as run

SIZE, RATE_HZ, PERIOD_NS = (96, 120), 100.0, 10_000_000
READ_NS, SUBMITTED_NS = 1_000_000, 3_000_000  # after a tick's beginning: of the head, of handing its picture over


class LiveHead(LoopedSource):
    """Whoever asks has read it a little later than the refresh began."""

    def head_at(self, time_ns: int) -> PoseSample:
        sample = super().head_at(time_ns)
        return attrs.evolve(sample, read_ns=sample.read_ns + READ_NS)


class OffscreenDisplay(offscreen.OffscreenDisplay):
    """track: whose head.

    gpu: None for one of its own. events: what happens at the n-th wait (counted from 0): an
    exception is raised (Closed, Lost, ..), a Tick is handed out with this display's times, None is
    "nothing to do just now". asked: commands after the n-th. back_after: how often reopen() says no
    after a Lost. keeps: the shown bytes, in `pictures`.
    """

    def __init__(
        self,
        track: PoseTrack | None = None,
        *,
        gpu: Gpu | None = None,
        size: tuple[int, int] | None = SIZE,
        view: str = "both",
        events: dict[int, BaseException | Tick | None] | None = None,
        asked: dict[int, Sequence[Command]] | None = None,
        back_after: int = 0,
        keeps: bool = False,
        rate_hz: float = RATE_HZ,
    ) -> None:
        track = track if track is not None else synthesise("look-around", seed=1, seconds=4)
        super().__init__(DisplayOptions("rift-dk1", size=size, view=view, trace=track, rate_hz=rate_hz), gpu)
        self.source = LiveHead(track, self.now_ns)
        self._events, self._asked, self._back_after, self._keeps = events or {}, asked or {}, back_after, keeps
        self._number = -1
        self.closed = 0
        self.labels: list[Label] = []
        self.said: list[str] = []
        self.pictures: list[np.ndarray] = []
        self.statuses: list[object] = []

    def wait(self) -> Tick | None:
        self._number += 1
        tick = super().wait()
        event = self._events.get(self._number, tick)
        if isinstance(event, BaseException):
            raise event
        return event and attrs.evolve(event, shown_ns=tick.shown_ns, period_ns=tick.period_ns)

    def show(self, refresh, label: Label = "") -> int:
        self.labels.append(label)
        shown_ns = super().show(refresh, label)
        if self._keeps:
            w, h = self._target.size
            self.pictures.append(np.frombuffer(self._target.read(components=3), np.uint8).reshape(h, w, 3))
        return shown_ns + SUBMITTED_NS

    def commands(self) -> Sequence[Command]:
        return self._asked.pop(self._number, ())

    def show_status(self, status) -> None:
        self.statuses.append(status)

    def reopen(self) -> bool:
        self._back_after -= 1
        return self._back_after < 0

    def close(self) -> None:
        self.closed += 1
        super().close()

    def __enter__(self) -> OffscreenDisplay:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def closed_at(number: int, why: str = "the window was closed") -> dict[int, BaseException]:
    """Events that end a run at its n-th wait."""
    return {number: Closed(why)}


def run_on(monkeypatch, display: OffscreenDisplay, options: LiveOptions, page: bool = False, **more):
    """hmdwarp.run.live on this display; what it says is collected in display.said.

    page: whether report.html is drawn; its plots take longer than such a run.
    """
    monkeypatch.setattr(run, "open_display", lambda *_: display)
    try:
        with nullcontext() if page else patch("hmdwarp.run.live_log.render_live_report", lambda *_, **__: "no page"):
            return run.live(options, display.said.append, **more)
    finally:
        if not display.closed:  # the run was refused before it opened one
            display.close()
