"""Commands from keys, mouse and control panel of a window, which handles some of them itself."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING

from ...poses.synth import Walker
from .. import Command
from .control_panel import PANEL_REMEDY, installed
from .pacing import Pacer
from .painter import Painter
from .window import Window
from .window_input import Keys, WindowInput, label

if TYPE_CHECKING:
    from .control_panel.panel import ControlPanel

NO_PANEL = f"no control panel: {PANEL_REMEDY}"


class WindowCommands:
    """Collect commands, and handle those of controls that belong to the display."""

    def __init__(
        self, keys: Keys, window: Window, walker: Walker, painter: Painter, pacer: Pacer, now_ns: Callable[[], int]
    ) -> None:
        self._window, self._painter, self._pacer = window, painter, pacer
        self._controls, self._now_ns = keys.controls, now_ns
        self.panel: ControlPanel | None = None  # None until it is opened, and if its packages are missing
        self.input = WindowInput(window.handle, walker, now_ns, keys)
        self.input.close_help = self._close_help
        self.pending: list[Command] = []  # for the run, oldest first
        # Of each control of the window; a value of None for the other state.
        handlers: dict[str, Callable[[object], None]] = {
            "recentre": lambda _: walker.recentre(now_ns()),
            "full_screen": self._full_screen,
            "vsync": self._vsync,
            "panel": self._control_panel,
            "help": lambda value: setattr(painter, "help", not painter.help if value is None else bool(value)),
            "quit": lambda _: window.end(),
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
            if command.control in self._handlers:
                self._handlers[command.control](command.value)
            else:
                others.append(command)
        return others

    def _full_screen(self, value: object) -> None:
        self._window.fill_screen(not self._window.fills_screen if value is None else bool(value))
        self._pacer.pause()

    def _vsync(self, value: object) -> None:
        self._window.wait_for_screen(not self._window.vsync if value is None else bool(value))
        self._pacer.set(self._window.rate_hz, self._window.vsync)

    def _control_panel(self, value: object) -> None:
        if self.panel is not None:
            self.panel.on = not self.panel.on if value is None else bool(value)
        elif not self.open_panel():
            self._painter.say(NO_PANEL)

    def _close_help(self) -> bool:
        was, self._painter.help = self._painter.help, False
        return was

    def open_panel(self) -> bool:
        """Open the control panel; return whether its packages are installed."""
        if installed():
            from .control_panel.panel import ControlPanel

            # After the window has set its callbacks: the panel chains them.
            self.panel = ControlPanel(self._window.handle, self._window.gl, self._controls, label)
            self.input.control_panel = self.panel
        return self.panel is not None

    def close(self) -> None:
        """Close the control panel."""
        if self.panel is not None:
            self.panel.close()
