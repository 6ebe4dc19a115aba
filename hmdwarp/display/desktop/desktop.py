"""The window as a display.

Pictures in it, a head led by mouse and keys, commands by keys and panel.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from ...gpu.context import Gpu
from ...headsets import load_headset
from ...poses.desktop import Walker
from ...poses.looped import LoopedSource
from .. import Closed, Command, DisplayOptions, Label, Tick
from ..status import Status
from .opening import start
from .pacing import Pacer, known_rate
from .panel import HOW_TO_GET_THE_PANEL, installed, make_panel
from .views import shown
from .window import Window

if TYPE_CHECKING:
    from ...pipeline.loop import Refresh

TITLE = "hmdwarp"
TITLE_NS = 250_000_000  # a title that changes more often cannot be read, and costs a round trip to the window manager
LOOK_ROUND_NS = 1_000_000_000  # how often to ask which screen the window is on
MINIMISED_S = 0.1
NO_PANEL = f"no panel of controls: {HOW_TO_GET_THE_PANEL}"


class DesktopDisplay:
    """display.Display in a window. Its clock is time.monotonic_ns, for its head and its pictures.

    Errors: MachineError that says why there is no window; InputError for an unknown headset.
    """

    name = "desktop"
    distorts = takes_depth = ""

    def __init__(self, options: DisplayOptions) -> None:
        self._headset = load_headset(options.headset)
        self._size_asked = options.size
        self.look(options.view)
        self._glfw = start()
        self._closers: list[Callable[[], None]] = []
        try:
            self._open(options)
        except BaseException:
            self.close()
            raise

    def _open(self, options: DisplayOptions) -> None:
        from ..present import Presenter
        from .hands import Hands, LedHead
        from .keys import Keys
        from .overlay import Overlay

        self._controls = options.controls
        self._own = {one.name for one in options.controls if one.of_display}
        panel = options.panel and "panel" in self._own
        self._window = Window(
            self._glfw,
            TITLE,
            self._shown.whole,
            _column() if panel else 0,
            full_screen=options.full_screen,
            vsync=options.vsync,
        )
        self._closers.append(self._window.close)
        self.gpu = Gpu(self._window.gl)
        self._closers.append(self.gpu.close)
        self._presenter = Presenter(self.gpu)
        self._closers.append(self._presenter.close)
        keys = Keys(options.controls)
        self._overlay = Overlay(self.gpu, self._presenter, self.now_ns, keys.controls, keys.help_text)
        self._pacer = Pacer(self._window.rate_hz, options.vsync)
        self._walker = Walker(self.now_ns())
        self._hands = Hands(self._window.handle, self._walker, self.now_ns, keys)
        if options.trace is not None:
            self.source = LoopedSource(options.trace, self.now_ns)
        else:
            self.source = LedHead(self._walker, self._read_inputs)
        self._panel = None
        if panel and not self._make_panel():
            self._overlay.say(f"H shows the keys\n{NO_PANEL}")
        self._closers.append(self._close_panel)
        self._pending: list[Command] = []
        self._screens_changed = False
        self._glfw.set_monitor_callback(self._note_screens)
        self._status = Status()
        self._begun_ns = self._titled_ns = self._looked_ns = 0
        self.about = {"window": self._kind(), "screen": self._window.screen_in_words(), "renderer": self.gpu.renderer}

    def _kind(self) -> str:
        glfw = self._glfw
        names = {
            glfw.PLATFORM_X11: "X11",
            glfw.PLATFORM_WAYLAND: "Wayland",
            glfw.PLATFORM_WIN32: "Windows",
            glfw.PLATFORM_COCOA: "macOS",
        }
        return f"glfw {'.'.join(map(str, glfw.get_version()))}, {names.get(glfw.get_platform(), 'unknown')}, context: {self._window.api}"

    # --- what the driver sees ---

    @property
    def rate_hz(self) -> float:
        """Rate of the screen the window is on; 60 where it does not say."""
        return self._pacer.rate_hz

    def now_ns(self) -> int:
        """Return time.monotonic_ns."""
        return time.monotonic_ns()

    def look(self, view: str) -> None:
        """Switch to another view."""
        self._shown = shown(view, self._headset, self._size_asked)
        self.eyes, self.size, self.headset = self._shown.eyes, self._shown.size, self._shown.headset

    def restart(self) -> None:
        """Begin a recorded head anew; a led one goes on."""
        if isinstance(self.source, LoopedSource):
            self.source.restart()

    def wait(self) -> Tick | None:
        """Wait until it is time for the next picture; None while the window is minimised."""
        self._read_inputs()
        self._refuse_if_over()
        self._obey()
        if self._window.hidden:
            self._glfw.wait_events_timeout(MINIMISED_S)
            self._pacer.pause()
            return None
        self._look_round()
        now = self.now_ns()
        due = self._pacer.due(now)
        if due > now:  # a sleep of nothing takes 60 us
            time.sleep((due - now) * 1e-9)
        self._begun_ns = self.now_ns()
        return Tick(self._pacer.expect(self._begun_ns), self._pacer.period_ns, missed=self._pacer.missed())

    def show(self, refresh: Refresh | None, label: Label = "") -> int:
        """Draw the eyes' pictures, the text over them and the panel, and swap."""
        canvases = () if refresh is None else tuple(eye.panel for eye in refresh.eyes)
        size, column = self._window.framebuffer_size, self._panel.column if self._panel is not None else 0
        self._overlay.draw(canvases, self._shown.count, self._shown.aspect, size, column, label)
        self._hands.point(self._on_plate if not isinstance(label, str) and label.pointed else None)
        if self._panel is not None:
            self._pending += self._panel.draw(self._status, size)
        handed_over_ns = self.now_ns()
        self._window.swap()
        self._pacer.swapped(self._begun_ns, self.now_ns())
        self._write_title()
        return handed_over_ns

    def commands(self) -> Sequence[Command]:
        """Return the requests that change the run; the window's own are done already."""
        asked, self._pending = self._pending, []
        return [command for command in asked if not self._do(command)]

    def tell(self, status: Status) -> None:
        """Show a Status in the title line and the panel."""
        self._status = status
        panel = self._panel is not None and self._panel.on
        status.values.update(
            full_screen=self._window.fills_screen, vsync=self._window.vsync, panel=panel, help=self._overlay.help
        )

    def reopen(self) -> bool:
        """Return False: a window is closed, never lost."""
        return False

    def close(self) -> None:
        """Release everything, in the opposite order."""
        while self._closers:
            self._closers.pop()()

    # --- within a refresh ---

    def _read_inputs(self) -> int:
        self._glfw.poll_events()
        self._hands.lead()
        return self.now_ns()

    def _on_plate(self, x: float, y: float) -> tuple[float, float] | None:
        """Return the panel's (u, v) at a place in the window's own units from the top left.

        On some desktops these units are not pixels.
        """
        (w, h), (fw, fh) = self._glfw.get_window_size(self._window.handle), self._window.framebuffer_size
        return self._overlay.on_plate(x * fw / max(w, 1), fh - y * fh / max(h, 1))

    def _refuse_if_over(self) -> None:
        reason = self._window.over()
        if reason:
            raise Closed(reason)

    def _look_round(self) -> None:
        now = self.now_ns()
        if self._screens_changed or now - self._looked_ns >= LOOK_ROUND_NS:
            self._looked_ns = now
            if self._screens_changed:
                self._screens_changed = False
                self._window.screens_changed()
            rate_hz = self._window.rate_hz
            if known_rate(rate_hz) != self._pacer.rate_hz:
                self._pacer.set(rate_hz, self._window.vsync)

    def _note_screens(self, *_: object) -> None:
        self._screens_changed = True

    def _write_title(self) -> None:
        now = self.now_ns()
        if now - self._titled_ns >= TITLE_NS and self._status.values:
            self._titled_ns = now
            self._window.title(self._status.title())

    # --- the window's own controls ---

    def _obey(self) -> None:
        """What came by keys: the window's own at once, the others when the driver asks for them."""
        asked, self._hands.commands = self._hands.commands, []
        self._pending += [command for command in asked if not self._do(command)]

    def _do(self, command: Command) -> bool:
        """Whether it was the window's own."""
        if command.control not in self._own:
            return False
        getattr(self, f"_do_{command.control}")(command.value)
        return True

    def _do_recentre(self, _: object) -> None:
        self._walker.recentre(self.now_ns())

    def _do_full_screen(self, value: object) -> None:
        self._window.fill_screen(not self._window.fills_screen if value is None else bool(value))
        self._pacer.pause()

    def _do_vsync(self, value: object) -> None:
        self._window.wait_for_screen(not self._window.vsync if value is None else bool(value))
        self._pacer.set(self._window.rate_hz, self._window.vsync)

    def _do_panel(self, value: object) -> None:
        if self._panel is not None:
            self._panel.on = not self._panel.on if value is None else bool(value)
        elif not self._make_panel():
            self._overlay.say(NO_PANEL)

    def _do_help(self, value: object) -> None:
        self._overlay.help = not self._overlay.help if value is None else bool(value)

    def _do_quit(self, _: object) -> None:
        self._window.end()

    def _make_panel(self) -> bool:
        """Make the panel when it is first wanted; return whether there is one."""
        self._panel = self._hands.panel = make_panel(self._window.handle, self._window.gl, controls=self._controls)
        return self._panel is not None

    def _close_panel(self) -> None:
        panel, self._panel = self._panel, None
        if panel is not None:
            panel.close()


def _column() -> int:
    """Return how wide the panel is on a usual screen, 0 where its package is missing."""
    if not installed():
        return 0
    from .panel_style import WIDTH

    return WIDTH
