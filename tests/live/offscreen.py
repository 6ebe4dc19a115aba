"""A display without a window: pictures go into framebuffers of an EGL context, the head comes from a track, time from a count.

Everything a run does is done, by the code that does it; only nobody looks. Its clock goes on by one refresh a tick, so two runs are equal.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import attrs
import numpy as np

from hmdwarp.display import Closed, Command, Lost, Tick
from hmdwarp.display.desktop.views import shown
from hmdwarp.display.present import Presenter
from hmdwarp.gpu.context import Gpu
from hmdwarp.headsets import load_headset
from hmdwarp.live import LiveOptions, run
from hmdwarp.poses import PoseSample, PoseTrack, RecordedSource
from hmdwarp.poses.synth import synthesise

SIZE, RATE_HZ, PERIOD_NS = (96, 120), 100.0, 10_000_000
READ_NS, SUBMITTED_NS = 1_000_000, 3_000_000  # after a tick's beginning: when the head is read, and when its picture is handed over


class LiveHead(RecordedSource):
    """A track, read as a live source is: whoever asks is told when."""

    def __init__(self, track: PoseTrack, now_ns: Callable[[], int]) -> None:
        super().__init__(track)
        self._now_ns = now_ns
        self.started = 0

    def start(self) -> None:
        self.started += 1

    def head_at(self, time_ns: int) -> PoseSample:
        return attrs.evolve(super().head_at(time_ns), read_ns=self._now_ns() + READ_NS)


class OffscreenDisplay:
    """As display.Display, a window's kind: the lens is ours.

    track: whose head, from its first instant on. gpu: None for one of its own. events: what happens at the n-th wait (counted from 0): an
    exception is raised (Closed, Lost, ..), a Tick is handed out with this display's times, None is "nothing to do just now".
    commands after the n-th: `asked`. back_after: how often reopen() says no after a Lost. keeps: the shown bytes, in `pictures`.
    """

    def __init__(
        self,
        track: PoseTrack | None = None,
        *,
        gpu: Gpu | None = None,
        headset: str = "rift-dk1",
        size: tuple[int, int] | None = SIZE,
        view: str = "both",
        rate_hz: float = RATE_HZ,
        name: str = "desktop",
        distorts: str = "",
        takes_depth: str = "",
        events: dict[int, BaseException | Tick | None] | None = None,
        asked: dict[int, Sequence[Command]] | None = None,
        back_after: int = 0,
        keeps: bool = False,
    ) -> None:
        self.name, self.distorts, self.takes_depth, self.rate_hz = name, distorts, takes_depth, rate_hz
        self.about = {"display": "offscreen", "track": "look-around"}
        self._owns, self.gpu = gpu is None, gpu if gpu is not None else Gpu()
        self._presenter = Presenter(self.gpu)
        track = track if track is not None else synthesise("look-around", seed=1, seconds=4)
        self._period_ns = round(1e9 / rate_hz)
        self._at_ns = int(track.time_ns[0])
        self.source = LiveHead(track, self.now_ns)
        self._model, self._size_asked = load_headset(headset), size
        self._target = self._texture = None
        self.look(view)
        self._events, self._asked, self._back_after, self._keeps = events or {}, asked or {}, back_after, keeps
        self._number = -1
        self.lost = self.closed = 0
        self.labels: list[str] = []
        self.said: list[str] = []
        self.pictures: list[np.ndarray] = []
        self.statuses: list[object] = []
        self.views: list[str] = [view]

    def now_ns(self) -> int:
        return self._at_ns

    def look(self, view: str) -> None:
        """As the window's."""
        made = shown(view, self._model, self._size_asked)
        self.eyes, self.size, self.headset, self._count = made.eyes, made.size, None if self.distorts else made.headset, made.count
        if hasattr(self, "views"):
            self.views.append(view)

    def wait(self) -> Tick | None:
        self._number += 1
        self._at_ns += self._period_ns
        event = self._events.get(self._number, Tick(0, 0))
        if isinstance(event, BaseException):
            self.lost += isinstance(event, Lost)
            raise event
        if event is None:
            return None
        return attrs.evolve(event, shown_ns=self._at_ns + 2 * self._period_ns, period_ns=self._period_ns)

    def show(self, refresh, label: str = "") -> int:
        self.labels.append(label)
        size = refresh.eyes[0].panel.size if refresh is not None else self.size
        into, notice = self._framebuffer((size[0] * self._count, size[1])), self._presenter.notice(label)
        for eye in range(self._count):
            panel = refresh.eyes[eye].panel if refresh is not None else None
            self._presenter.show(panel, into, (eye * size[0], 0, *size), hardware_srgb=False, notice=notice)
        if self._keeps:
            w, h = into.size
            self.pictures.append(np.frombuffer(into.read(components=3), np.uint8).reshape(h, w, 3))
        return self._at_ns + SUBMITTED_NS

    def _framebuffer(self, size: tuple[int, int]):
        if self._target is None or self._target.size != size:
            self._free_target()
            self._texture = self.gpu.gl.texture(size, 4)
            self._target = self.gpu.gl.framebuffer([self._texture])
        return self._target

    def _free_target(self) -> None:
        for thing in filter(None, (self._target, self._texture)):
            thing.release()
        self._target = self._texture = None

    def commands(self) -> Sequence[Command]:
        return self._asked.pop(self._number, ())

    def tell(self, status) -> None:
        self.statuses.append(status)

    def reopen(self) -> bool:
        self._back_after -= 1
        return self._back_after < 0

    def close(self) -> None:
        self.closed += 1
        if self.closed == 1:
            self._presenter.close()
            self._free_target()
            if self._owns:
                self.gpu.close()

    def __enter__(self) -> OffscreenDisplay:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def closed_at(number: int, why: str = "the window was closed") -> dict[int, BaseException]:
    """Events that end a run at its n-th wait."""
    return {number: Closed(why)}


def run_on(monkeypatch, display: OffscreenDisplay, options: LiveOptions, **more):
    """hmdwarp.live.run.live on this display; what it says is collected in display.said."""
    monkeypatch.setattr(run, "open_display", lambda *_: display)
    try:
        return run.live(options, display.said.append, **more)
    finally:
        if not display.closed:  # the run was refused before it opened one
            display.close()
