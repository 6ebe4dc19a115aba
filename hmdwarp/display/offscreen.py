"""A display without a screen: framebuffers, and a recording as head.

The code is that of any run, but nothing is visible. Its clock is simulated and advances by one
refresh for each picture, so that two runs are identical whatever the load of the machine; beside a
real network it is the machine's, and a refresh lasts as long as on a screen.
"""

from __future__ import annotations

import time
from collections.abc import Sequence

import moderngl

from ..base import InputError
from ..gpu import Gpu
from ..headsets import load_headset
from ..pipeline import Refresh
from ..poses import LoopedSource
from . import Command, DisplayOptions, Label, Status, Tick
from .desktop.window_system import WindowView
from .present import Presenter

AHEAD = 2  # refreshes from a tick to its display time, as in a headset


class OffscreenDisplay(WindowView):
    """A display.Display like a window's: hmdwarp corrects the lens.

    real_time: the clock is time.monotonic_ns; otherwise it stands still between pictures.
    gpu: None to create one.
    Errors: InputError without a trace, or for an unknown headset; MachineError without OpenGL.
    """

    name = "offscreen"

    def __init__(self, options: DisplayOptions, gpu: Gpu | None = None, *, real_time: bool = False) -> None:
        if options.trace is None:
            raise InputError("an offscreen display has no head to follow: name a recorded one by --trace")
        headset = options.emulated or load_headset(options.headset)
        super().__init__(options.view, headset, options.size)
        self.rate_hz = options.rate_hz or headset.refresh_hz
        self._period_ns, self._real_time = round(1e9 / self.rate_hz), real_time
        # When the refresh begins; on a simulated clock that is now.
        self._at_ns = time.monotonic_ns() if real_time else 0
        self.source = LoopedSource(options.trace, self.now_ns)
        self._owns, self.gpu = gpu is None, gpu if gpu is not None else Gpu()
        self._presenter = Presenter(self.gpu)
        self._target: moderngl.Framebuffer | None = None
        self._closed = False
        self.about = {"display": "offscreen", **options.about_trace(), "renderer": self.gpu.renderer}

    def now_ns(self) -> int:
        return time.monotonic_ns() if self._real_time else self._at_ns

    def restart(self) -> None:
        self.source.restart()

    def wait(self) -> Tick | None:
        self._at_ns += self._period_ns
        missed = max(0, (self.now_ns() - self._at_ns) // self._period_ns)
        self._at_ns += missed * self._period_ns
        time.sleep(max(0, self._at_ns - self.now_ns()) * 1e-9)
        return Tick(self._at_ns + AHEAD * self._period_ns, self._period_ns, missed=missed)

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        w, h = refresh.eyes[0].panel.size if refresh is not None else self.size
        count = self.count
        if self._target is None or self._target.size != (w * count, h):
            self._free_target()
            self._target = self.gpu.gl.framebuffer([self.gpu.gl.texture((w * count, h), 4)])
        into, notice = self._target, self._presenter.notice(label)
        for eye in range(count):
            panel = refresh.eyes[eye].panel if refresh is not None else None
            self._presenter.show(panel, into, (eye * w, 0, w, h), hardware_srgb=False, notice=notice)
        return self.now_ns()

    def _free_target(self) -> None:
        for made in () if self._target is None else (self._target, *self._target.color_attachments):
            made.release()
        self._target = None

    def commands(self) -> Sequence[Command]:
        return ()

    def show_status(self, status: Status) -> None:
        """Do nothing: it has no user."""

    def reopen(self) -> bool:
        return False

    def close(self) -> None:
        if not self._closed:
            self._closed = True
            self._presenter.close()
            self._free_target()
            if self._owns:
                self.gpu.close()
