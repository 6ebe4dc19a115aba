"""The desktop window as a display.

Pictures in it, a head moved by mouse and keys, commands by keys and control panel.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import ExitStack

from ...gpu import Gpu
from ...headsets import load_headset
from ...pipeline import Refresh
from ...poses import LoopedSource, PoseSource, Walker
from .. import Command, DisplayOptions, Label, Tick
from ..controls import Status, help_closes
from ..present import Notice, Presenter
from .control_panel import PANEL_REMEDY, WIDTH, installed
from .pacing import Pacer
from .window import Window
from .window_system import Rectangle, Size, WindowView, start, viewports

TITLE, NO_PANEL = "hmdwarp", f"no control panel: {PANEL_REMEDY}"
_MINIMISED_S = 0.1
TITLE_NS = 250_000_000  # a title that changes more often is unreadable, and each change costs a round trip
REMARK_NS = 4_000_000_000  # how long a remark stays
_CHECK_NS = 1_000_000_000  # between two checks of the rate of the screen that the window is on


class DesktopDisplay(WindowView):
    """A display.Display in a window, on time.monotonic_ns. Errors: MachineError; InputError."""

    name = "desktop"

    def __init__(self, options: DisplayOptions) -> None:
        super().__init__(options.view, options.emulated or load_headset(options.headset), options.size)
        with ExitStack() as closers:
            self._open(options, closers)
            self._closers = closers.pop_all()

    def _open(self, options: DisplayOptions, closers: ExitStack) -> None:
        glfw = start()  # before the module that imports glfw: it chooses the library of X11 or Wayland
        from .window_input import Keys, WalkerSource, WindowInput

        has_panel = options.control_panel and any(one.name == "panel" and one.of_display for one in options.controls)
        column, size = WIDTH if has_panel and installed() else 0, self.total_size
        self._window = Window(glfw, TITLE, size, column, full_screen=options.full_screen, vsync=options.vsync)
        closers.callback(self._window.close)
        self.gpu = Gpu(self._window.gl)
        closers.callback(self.gpu.close)
        self._presenter = Presenter(self.gpu)
        closers.callback(self._presenter.close)
        self._keys = keys = Keys(options.controls)
        self._pacer = Pacer(self._window.rate_hz, options.vsync)
        self._status = Status()
        self._titled_ns = self._begun_ns = self._checked_ns = 0
        self._labels: list[tuple[Rectangle, Notice]] = []  # the label's place over each viewport
        self._walker = Walker(self.now_ns())
        self._input = WindowInput(self._window, self._walker, self.now_ns, keys, self._obey)
        self.source: PoseSource = WalkerSource(self._walker, self._input.read)
        if options.trace is not None:
            self.source = LoopedSource(options.trace, self.now_ns)
        lacks_panel = has_panel and not self._input.open_panel()
        self._say("\n".join([*keys.first_words(options.trace is None), *([NO_PANEL] if lacks_panel else [])]))
        closers.callback(self._input.close)
        self.about = {"display": "window", "renderer": self.gpu.renderer, **options.about_trace()}

    def _say(self, text: str) -> None:
        self._remark, self._until_ns = text, self.now_ns() + REMARK_NS

    def _states(self) -> dict[str, object]:
        """Return what each switch of the window itself is."""
        panel = self._input.panel is not None and self._input.panel.on
        return {"full_screen": self._window.fills_screen, "panel": panel, "help": self._input.help}

    def _obey(self, name: str, value: object) -> None:
        """Do what a control of the window itself requests; None is for the other state."""
        window, on = self._window, bool(value) if value is not None else not self._states().get(name)
        if name == "recentre":
            self._walker.recentre(self.now_ns())
        elif name == "full_screen":
            window.fill_screen(on)
            self._pacer.pause()
        elif name == "help":
            self._input.help = on
        elif name == "quit":
            window.end()
        elif self._input.panel is not None:
            self._input.panel.on = on
        elif not self._input.open_panel():
            self._say(NO_PANEL)

    @property
    def rate_hz(self) -> float:
        """Refresh rate of the window's screen; 60 where unknown."""
        return self._pacer.rate_hz

    def now_ns(self) -> int:
        return time.monotonic_ns()

    def restart(self) -> None:
        if isinstance(self.source, LoopedSource):
            self.source.restart()
        else:
            self._input.look()

    def wait(self) -> Tick | None:
        self._input.read()
        self._window.check_open()
        if self._window.hidden:
            self._window.wait_events(_MINIMISED_S)
            self._pacer.pause()
            return None
        now = self.now_ns()
        if now - self._checked_ns >= _CHECK_NS:  # by now it may be on another screen
            self._checked_ns = now
            if (rate_hz := self._window.rate_hz) != self._pacer.rate_hz:
                self._pacer.set(rate_hz, self._window.vsync)
        due = self._pacer.due(now)
        if due > now:  # even a sleep of zero takes 60 us
            time.sleep((due - now) * 1e-9)
        self._begun_ns = self.now_ns()
        return Tick(self._pacer.expect(self._begun_ns), self._pacer.period_ns, missed=self._pacer.missed())

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        size, panel = self._window.framebuffer_size, self._input.panel
        # The panel covers pictures that it would leave less than half.
        column = panel.column if panel is not None else 0
        self._draw(refresh, (size[0] - column, size[1]) if 2 * column <= size[0] else size, label)
        self._input.takes_text = not isinstance(label, str) and label.takes_text
        self._input.point(self._uv_at if not isinstance(label, str) and label.pointed else None)
        if panel is not None:
            self._input.commands += panel.draw(self._status, size)
        handed_over_ns = self.now_ns()
        self._window.swap()
        self._pacer.swapped(self._begun_ns, self.now_ns())
        if self.now_ns() - self._titled_ns >= TITLE_NS and self._status.values:
            self._titled_ns = self.now_ns()
            self._window.title(self._status.title())
        return handed_over_ns

    def _draw(self, refresh: Refresh | None, area: Size, label: Label) -> None:
        """Draw the eyes' pictures, black for none, each with the label."""
        screen, presenter = self.gpu.gl.screen, self._presenter
        screen.scissor = None  # type: ignore[assignment]  # moderngl annotates the getter alone
        screen.clear(0.0, 0.0, 0.0, 1.0)
        # A remark is hidden beside a text panel.
        remark = self._remark if self.now_ns() < self._until_ns else ""
        notice = presenter.notice("\n".join(filter(None, (label, remark))) if isinstance(label, str) else label)
        if help_closes(self._keys.controls, has_text_panel=not isinstance(label, str)):
            self._input.help = False
        # The help covers the first eye alone: the other one shows the effect of the keys.
        notices = (presenter.notice(self._keys.help_text()) if self._input.help else notice, notice)
        pictures = (None,) * self.count if refresh is None else tuple(eye.panel for eye in refresh.eyes)
        places = viewports(area, len(pictures), self.aspect)
        for picture, over, place in zip(pictures, notices, places, strict=False):
            presenter.show(picture, screen, place, hardware_srgb=False, notice=over)
        self._labels = [
            (place, over) for place, over in zip(places, notices, strict=False) if over is not None and over is notice
        ]

    def _uv_at(self, x: float, y: float) -> tuple[float, float] | None:
        """Return (u, v) on the label of a position as glfw has it; None outside it."""
        x, y = self._window.pixel_of(x, y)
        for (left, low, w, h), notice in self._labels:
            if 0 <= x - left < w and 0 <= y - low < h:
                u, v, one = notice.uv_from_pixel((w, h), None) @ (x - left, y - low, 1.0)
                return (u / one, v / one) if 0 <= u / one <= 1 and 0 <= v / one <= 1 else None
        return None

    def commands(self) -> Sequence[Command]:
        return self._input.take()

    def show_status(self, status: Status) -> None:
        self._status = self._keys.status = status
        status.values.update(self._states())

    def reopen(self) -> bool:
        return False  # a window is closed, never lost

    def close(self) -> None:
        self._closers.close()
