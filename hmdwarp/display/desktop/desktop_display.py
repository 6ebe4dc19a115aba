"""The desktop window as a display.

Pictures in it, a head moved by mouse and keys, commands by keys and control panel.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from contextlib import ExitStack

from ...gpu.context import Gpu
from ...headsets import load_headset
from ...poses import PoseSource
from ...poses.synth import Walker
from ...poses.track import LoopedSource
from .. import Closed, Command, DisplayOptions, Label, Picture, Tick
from ..controls import Status
from .control_panel import WIDTH, installed
from .pacing import Pacer, ScreenMonitor
from .window import Window
from .window_system import SwitchableView, start

TITLE = "hmdwarp"
MINIMISED_S = 0.1
TITLE_NS = 250_000_000  # a title that changes more often is unreadable, and each change costs a round trip


class DesktopDisplay(SwitchableView):
    """A display.Display in a window. Its clock is time.monotonic_ns, for its head and its pictures.

    Errors: MachineError with the reason why there is no window; InputError for an unknown headset.
    """

    name = "desktop"

    def __init__(self, options: DisplayOptions) -> None:
        super().__init__(options.emulated or load_headset(options.headset), options.size, options.view)
        with ExitStack() as closers:
            self._open(options, closers)
            self._closers = closers.pop_all()

    def _open(self, options: DisplayOptions, closers: ExitStack) -> None:
        glfw = start()  # before the modules that import glfw: it chooses the library of X11 or Wayland
        from ..present import Presenter
        from .painter import Painter
        from .window_commands import NO_PANEL, WindowCommands
        from .window_input import Keys, WalkerSource

        has_panel = options.control_panel and any(one.name == "panel" and one.of_display for one in options.controls)
        self._window = Window(
            glfw,
            TITLE,
            self._view.total_size,
            WIDTH if has_panel and installed() else 0,
            full_screen=options.full_screen,
            vsync=options.vsync,
        )
        closers.callback(self._window.close)
        self.gpu = Gpu(self._window.gl)
        closers.callback(self.gpu.close)
        presenter = Presenter(self.gpu)
        closers.callback(presenter.close)
        self._keys = keys = Keys(options.controls)
        self._painter = Painter(self.gpu, presenter, self.now_ns, keys.controls, keys.help_text)
        self._pacer = Pacer(self._window.rate_hz, options.vsync)
        self._status, self._titled_ns = Status(), 0
        walker = Walker(self.now_ns())
        self._commands = WindowCommands(keys, self._window, walker, self._painter, self._pacer, self.now_ns)
        self.source: PoseSource = WalkerSource(walker, self._commands.read)
        if options.trace is not None:
            self.source = LoopedSource(options.trace, self.now_ns)
        lacks_panel = has_panel and not self._commands.open_panel()
        self._painter.say("\n".join([*keys.first_words(options.trace is None), *([NO_PANEL] if lacks_panel else [])]))
        closers.callback(self._commands.close)
        self._screens = ScreenMonitor(glfw, self._window, self._pacer)
        self._begun_ns = 0
        self.about = {
            "window": self._window.system_text,
            "screen": self._window.screen_text(),
            "renderer": self.gpu.renderer,
            **options.about_trace(),
        }

    @property
    def rate_hz(self) -> float:
        """Refresh rate of the window's screen; 60 where unknown."""
        return self._pacer.rate_hz

    def now_ns(self) -> int:
        """Return time.monotonic_ns."""
        return time.monotonic_ns()

    def restart(self) -> None:
        """Begin a recorded head anew, or let the mouse turn the head without a click."""
        if isinstance(self.source, LoopedSource):
            self.source.restart()
        else:
            self._commands.input.look()

    def wait(self) -> Tick | None:
        """Wait until it is time for the next picture; None while the window is minimised."""
        self._commands.read()
        reason = self._window.over()
        if reason:
            raise Closed(reason)
        self._commands.handle_keys()
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

    def show(self, refresh: Picture | None, label: Label = "") -> int:
        """Draw the eyes' pictures, the text over them and the control panel, and swap."""
        canvases = () if refresh is None else tuple(eye.panel for eye in refresh.eyes)
        size, panel = self._window.framebuffer_size, self._commands.panel
        self._painter.draw(canvases, self._view, size, panel.column if panel else 0, label)
        self._commands.input.takes_text = not isinstance(label, str) and label.takes_text
        pointed = not isinstance(label, str) and label.pointed
        self._commands.input.point(
            (lambda x, y: self._painter.uv_at(*self._window.pixel_of(x, y))) if pointed else None
        )
        if panel is not None:
            self._commands.pending += panel.draw(self._status, size)
        handed_over_ns = self.now_ns()
        self._window.swap()
        self._pacer.swapped(self._begun_ns, self.now_ns())
        if self.now_ns() - self._titled_ns >= TITLE_NS and self._status.values:
            self._titled_ns = self.now_ns()
            self._window.title(self._status.title())
        return handed_over_ns

    def commands(self) -> Sequence[Command]:
        """Return the commands that change the run; the window has handled its own."""
        return self._commands.take()

    def show_status(self, status: Status) -> None:
        """Show a Status in the title line and the control panel."""
        self._status, self._keys.status, panel = status, status, self._commands.panel
        status.values.update(
            full_screen=self._window.fills_screen,
            vsync=self._window.vsync,
            panel=panel is not None and panel.on,
            help=self._painter.help,
        )

    def reopen(self) -> bool:
        """Return False: a window is closed, never lost."""
        return False

    def close(self) -> None:
        """Release everything, in reverse order."""
        self._closers.close()
