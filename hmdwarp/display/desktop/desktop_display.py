"""The desktop window as a display.

Pictures in it, a head moved by mouse and keys, commands by keys and control panel.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from statistics import median
from types import ModuleType

from ...gpu.context import Gpu
from ...headsets import load_headset
from ...poses import PoseSource
from ...poses.track import LoopedSource
from ...poses.walker import Walker
from .. import Closed, Command, DisplayOptions, Label, Picture, Tick
from ..controls import Status
from .control_panel import column_width
from .painter import NO_PANEL, Painter, StatusViews
from .window import Window
from .window_input import Keys, WindowInput
from .window_system import SwitchableView, start

TITLE = "hmdwarp"
MINIMISED_S = 0.1


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
        from .painter import NO_PANEL, Painter, StatusViews
        from .window_input import Keys

        has_panel = options.control_panel and any(
            control.name == "panel" and control.of_display for control in options.controls
        )
        self._window = Window(
            glfw,
            TITLE,
            self._view.total_size,
            column_width() if has_panel else 0,
            full_screen=options.full_screen,
            vsync=options.vsync,
        )
        closers.callback(self._window.close)
        self.gpu = Gpu(self._window.gl)
        closers.callback(self.gpu.close)
        presenter = Presenter(self.gpu)
        closers.callback(presenter.close)
        keys = Keys(options.controls)
        self._painter = Painter(self.gpu, presenter, self.now_ns, keys.controls, keys.help_text)
        self._pacer = Pacer(self._window.rate_hz, options.vsync)
        self._status = StatusViews(self._window, options.controls)
        walker = Walker(self.now_ns())
        self._commands = WindowCommands(
            keys, self._window, walker, self._painter, self._pacer, self._status, self.now_ns
        )
        self.source: PoseSource = self._source(options, walker)
        lacks_panel = has_panel and not self._commands.open_panel()
        self._painter.say("\n".join([*keys.first_words(options.trace is None), *([NO_PANEL] if lacks_panel else [])]))
        closers.callback(self._status.close)
        self._screens = ScreenMonitor(glfw, self._window, self._pacer)
        self._begun_ns = 0
        self.about = {
            "window": self._window.system_text,
            "screen": self._window.screen_text(),
            "renderer": self.gpu.renderer,
            **options.about_trace(),
        }

    def _source(self, options: DisplayOptions, walker: Walker) -> PoseSource:
        from .window_input import WalkerSource

        if options.trace is not None:
            return LoopedSource(options.trace, self.now_ns)
        return WalkerSource(walker, self._commands.read)

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
        self._painter.draw(canvases, self._view, self._window.framebuffer_size, self._status.column, label)
        self._commands.input.takes_text = not isinstance(label, str) and label.takes_text
        self._commands.input.point(self._uv_at if not isinstance(label, str) and label.pointed else None)
        self._commands.pending += self._status.draw_panel()
        handed_over_ns = self.now_ns()
        self._window.swap()
        self._pacer.swapped(self._begun_ns, self.now_ns())
        self._status.write_title(self.now_ns())
        return handed_over_ns

    def _uv_at(self, x: float, y: float) -> tuple[float, float] | None:
        """Return (u, v) on the text panel of a position in the window's own units."""
        return self._painter.uv_at(*self._window.pixel_of(x, y))

    def commands(self) -> Sequence[Command]:
        """Return the commands that change the run; the window has handled its own."""
        return self._commands.take()

    def show_status(self, status: Status) -> None:
        """Show a Status in the title line and the control panel."""
        self._status.update(status, shows_help=self._painter.help)

    def reopen(self) -> bool:
        """Return False: a window is closed, never lost."""
        return False

    def close(self) -> None:
        """Release everything, in reverse order."""
        self._closers.close()


class WindowCommands:
    """Collect commands, and handle those of controls that belong to the display."""

    def __init__(
        self,
        keys: Keys,
        window: Window,
        walker: Walker,
        painter: Painter,
        pacer: Pacer,
        views: StatusViews,
        now_ns: Callable[[], int],
    ) -> None:
        self._window, self._walker, self._painter, self._pacer = window, walker, painter, pacer
        self._views, self._now_ns = views, now_ns
        self.input = WindowInput(window.handle, walker, now_ns, keys)
        self.input.close_help = self._close_help
        self.pending: list[Command] = []  # for the run, oldest first
        handlers: dict[str, Callable[[object], None]] = {
            "recentre": self._recentre,
            "full_screen": self._full_screen,
            "vsync": self._vsync,
            "panel": self._control_panel,
            "help": self._help,
            "quit": self._quit,
        }
        self._handlers = {control.name: handlers[control.name] for control in keys.controls if control.of_display}

    def read(self) -> int:
        """Read mouse and keys, move the walker, and return the time."""
        self._window.poll_events()
        self.input.walk()
        return self._now_ns()

    def handle_keys(self) -> None:
        """Handle the window's own commands at once; keep the others for the run."""
        commands, self.input.commands = self.input.commands, []
        self.pending += self._others(commands)

    def take(self) -> list[Command]:
        """Return the commands for the run since the last call."""
        commands, self.pending = self.pending, []
        return self._others(commands)

    def _others(self, commands: Iterable[Command]) -> list[Command]:
        """Handle the window's own commands; return the others."""
        others = []
        for command in commands:
            handler = self._handlers.get(command.control)
            if handler is None:
                others.append(command)
            else:
                handler(command.value)
        return others

    # --- one method for each control of the window; value: None for the other state ---

    def _recentre(self, _: object) -> None:
        self._walker.recentre(self._now_ns())

    def _full_screen(self, value: object) -> None:
        self._window.fill_screen(not self._window.fills_screen if value is None else bool(value))
        self._pacer.pause()

    def _vsync(self, value: object) -> None:
        self._window.wait_for_screen(not self._window.vsync if value is None else bool(value))
        self._pacer.set(self._window.rate_hz, self._window.vsync)

    def _control_panel(self, value: object) -> None:
        panel = self._views.panel
        if panel is not None:
            panel.on = not panel.on if value is None else bool(value)
        elif not self.open_panel():
            self._painter.say(NO_PANEL)

    def _help(self, value: object) -> None:
        self._painter.help = not self._painter.help if value is None else bool(value)

    def _close_help(self) -> bool:
        was, self._painter.help = self._painter.help, False
        return was

    def _quit(self, _: object) -> None:
        self._window.end()

    def open_panel(self) -> bool:
        """Open the control panel; return whether its package is installed."""
        self.input.control_panel = self._views.open_panel()
        return self._views.panel is not None


UNKNOWN_HZ = 60.0
REMEMBERED = 16  # refreshes; a change of scene or size is forgotten after a quarter of a second
UNSYNCED = 8  # consecutive pictures faster than the screen, after which vsync counts as off
TOO_FAST = 0.7  # of a period


def known_rate(rate_hz: float) -> float:
    """Return a screen's reported rate; 60 where that is 0 or less."""
    return rate_hz if rate_hz > 0 else UNKNOWN_HZ


class Pacer:
    """Estimate display times from when pictures were begun and when their swaps returned.

    All times in ns on one clock. waits: whether the driver should wait for the screen (vsync).
    Where it does not (software drivers, a user's setting), `paced` turns true and the caller waits
    until `due` instead; otherwise a window would make pictures that are never visible.
    """

    def __init__(self, rate_hz: float, waits: bool) -> None:
        self._expected_ns = 0
        self._intervals: deque[int] = deque(maxlen=REMEMBERED)
        self._works: deque[int] = deque(maxlen=REMEMBERED)
        self.set(rate_hz, waits)

    def set(self, rate_hz: float, waits: bool) -> None:
        """Use another screen or setting. rate_hz: as known_rate returns it."""
        self.rate_hz = known_rate(rate_hz)
        self.period_ns = round(1e9 / self.rate_hz)
        self.waits = waits
        self.paced = False
        self._too_fast = 0
        self.pause()

    def pause(self) -> None:
        """Note a deliberate pause: no refresh was missed, and earlier durations are void."""
        self._last_ns: int | None = None
        self._missed = 0
        self._intervals.clear()
        self._works.clear()

    def swapped(self, begun_ns: int, back_ns: int) -> None:
        """Note the swap of a picture begun at `begun_ns`; the swap returned at `back_ns`."""
        self._works.append(back_ns - begun_ns)
        if self._last_ns is not None:
            interval = back_ns - self._last_ns
            self._intervals.append(interval)
            self._missed += max(0, round(interval / self.period_ns) - 1)
            self._check_waiting(interval)
        self._last_ns = back_ns

    def _check_waiting(self, interval_ns: int) -> None:
        if self.waits and not self.paced:
            self._too_fast = self._too_fast + 1 if interval_ns < TOO_FAST * self.period_ns else 0
            self.paced = self._too_fast >= UNSYNCED

    def due(self, now_ns: int) -> int:
        """Return when to begin the next picture: now, unless we pace in place of the driver."""
        if not self.paced or self._last_ns is None:
            return now_ns
        work = int(median(self._works))
        return max(now_ns, self._last_ns + self.period_ns - work)

    def expect(self, now_ns: int) -> int:
        """Return when a picture begun now will be seen; call once for each.

        Pictures keep their order.

        With a driver that waits: at the swap that follows the last one by as many whole periods as
        a picture takes. Otherwise: when it is done, plus half a period, the screen's mean time to
        the middle of the picture.
        """
        self._expected_ns = max(self._guess(now_ns), self._expected_ns + 1)
        return self._expected_ns

    def _guess(self, now_ns: int) -> int:
        if self.waits and not self.paced and self._last_ns is not None and self._intervals:
            periods = max(1, round(median(self._intervals) / self.period_ns))
            at = self._last_ns + periods * self.period_ns
            late = max(0, now_ns - at)
            return at + -(-late // self.period_ns) * self.period_ns
        work = int(median(self._works)) if self._works else 0
        return now_ns + work + self.period_ns // 2

    def missed(self) -> int:
        """Return the refreshes without a new picture since the last call."""
        missed, self._missed = self._missed, 0
        return missed


CHECK_NS = 1_000_000_000  # between two checks of which screen the window is on


class ScreenMonitor:
    """Keep the pacer at the refresh rate of the window's screen."""

    def __init__(self, glfw: ModuleType, window: Window, pacer: Pacer) -> None:
        self._window, self._pacer = window, pacer
        self._changed, self._checked_ns = False, 0
        glfw.set_monitor_callback(self._note_change)

    def _note_change(self, *_: object) -> None:
        self._changed = True

    def update(self, now_ns: int) -> None:
        """Check the screen, if one was plugged or unplugged or the last check is a second old."""
        if not self._changed and now_ns - self._checked_ns < CHECK_NS:
            return
        self._checked_ns = now_ns
        if self._changed:
            self._changed = False
            self._window.screens_changed()
        rate_hz = self._window.rate_hz
        if known_rate(rate_hz) != self._pacer.rate_hz:
            self._pacer.set(rate_hz, self._window.vsync)
