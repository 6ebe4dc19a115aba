"""What is drawn into a window: pictures, and text over them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...gpu.context import Gpu
from ...gpu.textures import Canvas
from .. import Label
from ..controls import Control, help_closes
from ..present import Notice, Presenter
from .window_system import Rectangle, Size, WindowView, picture_area, viewports

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
