"""The desktop window as a display.

Pictures in it, a head moved by mouse and keys, commands by keys and control panel.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack

from ...gpu.context import Gpu
from ...gpu.textures import Canvas
from ...headsets import load_headset
from ...pipeline.loop import Refresh
from ...poses import PoseSource
from ...poses.synth import Walker
from ...poses.track import LoopedSource
from .. import Closed, Command, DisplayOptions, Label, Tick
from ..controls import Control, Status, help_closes
from ..present import Notice, Presenter
from .control_panel import PANEL_REMEDY, WIDTH, installed
from .pacing import Pacer, ScreenMonitor
from .window import Window
from .window_system import Rectangle, Size, SwitchableView, WindowView, picture_area, start, viewports

TITLE, NO_PANEL = "hmdwarp", f"no control panel: {PANEL_REMEDY}"
MINIMISED_S = 0.1
TITLE_NS = 250_000_000  # a title that changes more often is unreadable, and each change costs a round trip
REMARK_NS = 4_000_000_000  # how long a remark stays


class Painter:
    """Pictures and text of one window. help_text: explains the keys of the controls."""

    def __init__(
        self, gpu: Gpu, presenter: Presenter, now_ns: Callable[[], int], controls: tuple[Control, ...],
        help_text: Callable[[], str],
    ) -> None:  # fmt: skip
        self._screen, self._presenter, self._now_ns = gpu.gl.screen, presenter, now_ns
        self._controls, self._help_text = controls, help_text
        self.help = False  # whether the help covers the picture, in place of any other text
        self._labels: list[tuple[Rectangle, Notice]] = []  # the label's place over each viewport
        self._remark, self._until_ns = "", 0

    def say(self, text: str) -> None:
        self._remark, self._until_ns = text, self._now_ns() + REMARK_NS

    def close_help(self) -> bool:
        """Close the help; return whether it was open."""
        was, self.help = self.help, False
        return was

    def draw(self, canvases: Sequence[Canvas], view: WindowView, size: Size, column: int, label: Label) -> None:
        """Draw into the window's framebuffer, (w, h) pixels.

        canvases: the eyes' pictures, none for black. column: width of the control panel at the
        right. label: over each picture; remarks are hidden beside a text panel.
        """
        self._screen.scissor = None  # type: ignore[assignment]  # moderngl annotates the getter alone
        self._screen.clear(0.0, 0.0, 0.0, 1.0)
        remark = self._remark if self._now_ns() < self._until_ns else ""
        notice = self._presenter.notice("\n".join(filter(None, (label, remark))) if isinstance(label, str) else label)
        self.help = self.help and not help_closes(self._controls, has_text_panel=not isinstance(label, str))
        # The help covers the first eye alone: the other one shows the effect of the keys.
        notices = (self._presenter.notice(self._help_text()) if self.help else notice, notice)
        pictures = canvases or (None,) * view.count
        places = viewports(picture_area(size, column), len(pictures), view.aspect)
        for picture, over, place in zip(pictures, notices, places, strict=False):
            self._presenter.show(picture, self._screen, place, hardware_srgb=False, notice=over)
        self._labels = [
            (place, over) for place, over in zip(places, notices, strict=False) if over is not None and over is notice
        ]

    def uv_at(self, x: float, y: float) -> tuple[float, float] | None:
        """Return (u, v) on the label of a framebuffer pixel; None outside it.

        x, y: from the bottom left, like (u, v).
        """
        for (left, low, w, h), notice in self._labels:
            if 0 <= x - left < w and 0 <= y - low < h:
                u, v, one = notice.uv_from_pixel((w, h), None) @ (x - left, y - low, 1.0)
                return (u / one, v / one) if 0 <= u / one <= 1 and 0 <= v / one <= 1 else None
        return None


class DesktopDisplay(SwitchableView):
    """A display.Display in a window, on time.monotonic_ns. Errors: MachineError; InputError."""

    name = "desktop"

    def __init__(self, options: DisplayOptions) -> None:
        super().__init__(options.emulated or load_headset(options.headset), options.size, options.view)
        with ExitStack() as closers:
            self._open(options, closers)
            self._closers = closers.pop_all()

    def _open(self, options: DisplayOptions, closers: ExitStack) -> None:
        glfw = start()  # before the module that imports glfw: it chooses the library of X11 or Wayland
        from .window_input import Keys, WalkerSource, WindowInput

        has_panel = options.control_panel and any(one.name == "panel" and one.of_display for one in options.controls)
        column, size = WIDTH if has_panel and installed() else 0, self._view.total_size
        self._window = Window(glfw, TITLE, size, column, full_screen=options.full_screen, vsync=options.vsync)
        closers.callback(self._window.close)
        self.gpu = Gpu(self._window.gl)
        closers.callback(self.gpu.close)
        presenter = Presenter(self.gpu)
        closers.callback(presenter.close)
        self._keys = keys = Keys(options.controls)
        self._painter = Painter(self.gpu, presenter, self.now_ns, keys.controls, keys.help_text)
        self._pacer = Pacer(self._window.rate_hz, options.vsync)
        self._status, self._titled_ns, self._begun_ns = Status(), 0, 0
        walker = Walker(self.now_ns())
        self._input = WindowInput(self._window, walker, self.now_ns, keys, self._own_controls(walker))
        self._input.close_help = self._painter.close_help
        self.source: PoseSource = WalkerSource(walker, self._input.read)
        if options.trace is not None:
            self.source = LoopedSource(options.trace, self.now_ns)
        lacks_panel = has_panel and not self._input.open_panel()
        self._painter.say("\n".join([*keys.first_words(options.trace is None), *([NO_PANEL] if lacks_panel else [])]))
        closers.callback(self._input.close)
        self._screens = ScreenMonitor(glfw, self._window, self._pacer)
        about = {"window": self._window.system_text, "screen": self._window.screen_text()}
        self.about = {**about, "renderer": self.gpu.renderer, **options.about_trace()}

    def _own_controls(self, walker: Walker) -> dict[str, Callable[[object], None]]:
        """Return what each control of the window does; a value of None is for the other state."""
        window, painter = self._window, self._painter

        def full_screen(value: object) -> None:
            window.fill_screen(not window.fills_screen if value is None else bool(value))
            self._pacer.pause()

        def vsync(value: object) -> None:
            window.wait_for_screen(not window.vsync if value is None else bool(value))
            self._pacer.set(window.rate_hz, window.vsync)

        def panel(value: object) -> None:
            if self._input.panel is not None:
                self._input.panel.on = not self._input.panel.on if value is None else bool(value)
            elif not self._input.open_panel():
                painter.say(NO_PANEL)

        return {
            "recentre": lambda _: walker.recentre(self.now_ns()),
            "full_screen": full_screen,
            "vsync": vsync,
            "panel": panel,
            "help": lambda value: setattr(painter, "help", not painter.help if value is None else bool(value)),
            "quit": lambda _: window.end(),
        }

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
        if reason := self._window.over():
            raise Closed(reason)
        self._input.handle_own()
        if self._window.hidden:
            self._window.wait_events(MINIMISED_S)
            self._pacer.pause()
            return None
        self._screens.update(self.now_ns())
        now = self.now_ns()
        due = self._pacer.due(now)
        if due > now:  # even a sleep of zero takes 60 us
            time.sleep((due - now) * 1e-9)
        self._begun_ns = self.now_ns()
        return Tick(self._pacer.expect(self._begun_ns), self._pacer.period_ns, missed=self._pacer.missed())

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        canvases = () if refresh is None else tuple(eye.panel for eye in refresh.eyes)
        size, panel = self._window.framebuffer_size, self._input.panel
        self._painter.draw(canvases, self._view, size, panel.column if panel else 0, label)
        self._input.takes_text = not isinstance(label, str) and label.takes_text
        pointed = not isinstance(label, str) and label.pointed
        self._input.point((lambda x, y: self._painter.uv_at(*self._window.pixel_of(x, y))) if pointed else None)
        if panel is not None:
            self._input.commands += panel.draw(self._status, size)
        handed_over_ns = self.now_ns()
        self._window.swap()
        self._pacer.swapped(self._begun_ns, self.now_ns())
        if self.now_ns() - self._titled_ns >= TITLE_NS and self._status.values:
            self._titled_ns = self.now_ns()
            self._window.title(self._status.title())
        return handed_over_ns

    def commands(self) -> Sequence[Command]:
        return self._input.take()

    def show_status(self, status: Status) -> None:
        self._status, self._keys.status, panel = status, status, self._input.panel
        status.values.update(full_screen=self._window.fills_screen, vsync=self._window.vsync)
        status.values.update(panel=panel is not None and panel.on, help=self._painter.help)

    def reopen(self) -> bool:
        return False  # a window is closed, never lost

    def close(self) -> None:
        self._closers.close()
