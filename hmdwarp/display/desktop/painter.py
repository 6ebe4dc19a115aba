"""What is drawn into a window: pictures, text over them, its title and its control panel."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from ...gpu.context import Gpu
from ...gpu.textures import Canvas
from .. import Command, Label
from ..controls import Control, Status, help_closes
from ..present import Notice, Presenter
from .control_panel import PANEL_REMEDY, installed
from .window import Window
from .window_system import Rectangle, Size, WindowView, picture_area, viewports

if TYPE_CHECKING:
    from .control_panel.panel import ControlPanel

REMARK_NS = 4_000_000_000  # how long a remark stays


class Painter:
    """Pictures and text of one window.

    help_text: explains the keys of the controls.
    """

    def __init__(
        self,
        gpu: Gpu,
        presenter: Presenter,
        now_ns: Callable[[], int],
        controls: tuple[Control, ...],
        help_text: Callable[[], str],
    ) -> None:
        self._screen, self._presenter, self._now_ns = gpu.gl.screen, presenter, now_ns
        self._controls, self._help_text = controls, help_text
        self.help = False  # whether the help covers the picture, in place of any other text
        self._labels: list[tuple[Rectangle, Notice]] = []  # the label's place over each viewport
        self._remark, self._until_ns = "", 0

    def say(self, text: str) -> None:
        """Show a remark over the picture for a few seconds."""
        self._remark, self._until_ns = text, self._now_ns() + REMARK_NS

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
        """Open the control panel; None if its packages are missing.

        After the window has set its callbacks: the panel chains them.
        """
        if installed():
            from .control_panel.panel import ControlPanel

            self.panel = ControlPanel(self._window.handle, self._window.gl, self._controls)
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
