"""Title and control panel of a window, which show the run's status."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from .. import Command
from ..controls import Control
from ..status import Status
from .control_panel import PANEL_REMEDY, make_control_panel
from .window import Window

if TYPE_CHECKING:
    from .control_panel.panel import ControlPanel

NO_PANEL = f"no control panel: {PANEL_REMEDY}"
TITLE_NS = 250_000_000  # a title that changes more often is unreadable, and each change costs a round trip


class StatusViews:
    """The parts of a window that show the status."""

    def __init__(self, window: Window, controls: Sequence[Control]) -> None:
        self._window, self._controls = window, tuple(controls)
        self._status = Status()
        self._written_ns = 0
        self.panel: ControlPanel | None = None  # None until it is opened, and if its package is missing

    def update(self, status: Status, *, shows_help: bool) -> None:
        """Show this status, with the state of the window's own switches."""
        self._status = status
        status.values.update(
            full_screen=self._window.fills_screen,
            vsync=self._window.vsync,
            panel=self.panel is not None and self.panel.on,
            help=shows_help,
        )

    @property
    def column(self) -> int:
        """Width of the control panel in framebuffer pixels; 0 while there is none."""
        return self.panel.column if self.panel is not None else 0

    def open_panel(self) -> ControlPanel | None:
        """Open the control panel; None if its package is missing."""
        self.panel = make_control_panel(self._window.handle, self._window.gl, controls=self._controls)
        return self.panel

    def draw_panel(self) -> list[Command]:
        """Draw the control panel over the window; return its commands."""
        return self.panel.draw(self._status, self._window.framebuffer_size) if self.panel is not None else []

    def write_title(self, now_ns: int) -> None:
        """Write the status into the title line, four times a second."""
        if now_ns - self._written_ns >= TITLE_NS and self._status.values:
            self._written_ns = now_ns
            self._window.title(self._status.title())

    def close(self) -> None:
        """Close the control panel. Safe to call twice."""
        panel, self.panel = self.panel, None
        if panel is not None:
            panel.close()
