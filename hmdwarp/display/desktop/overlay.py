"""Everything in a window: the eyes' pictures, black around them, and text over them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...gpu.context import Gpu
from ...gpu.textures import Canvas
from .. import Label
from ..controls import Control, help_goes
from ..notice import Notice
from ..present import Presenter
from .layout import Rectangle, Size, beside, viewports

SAID_NS = 4_000_000_000  # how long a remark stays


class Overlay:
    """Pictures and text of one window.

    help: whether the keys are explained over the picture, in place of any other text. controls:
    which keys. help_text: its words.
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
        self.help = False
        self._plates: list[tuple[Rectangle, Notice]] = []
        self._said, self._until_ns = "", 0

    def say(self, text: str) -> None:
        """Show a remark over the picture for a few seconds."""
        self._said, self._until_ns = text, self._now_ns() + SAID_NS

    def draw(
        self, canvases: Sequence[Canvas], count: int, aspect: float, size: Size, column: int, label: Label
    ) -> None:
        """Draw into the window's framebuffer, (w, h) pixels.

        canvases: the eyes' pictures, none for black. count: of eyes, where there are no pictures.
        aspect: width over height of one picture. column: pixels left to a panel at the right.
        label: over each picture; no remark appears beside a panel.
        """
        self._screen.scissor = None
        self._screen.clear(0.0, 0.0, 0.0, 1.0)
        said = self._said if self._now_ns() < self._until_ns else ""
        notice = self._presenter.notice("\n".join(filter(None, (label, said))) if isinstance(label, str) else label)
        self.help = self.help and not help_goes(self._controls, plate=not isinstance(label, str))
        # The help before the first eye alone: beside it one sees what the keys do.
        notices = (self._presenter.notice(self._help_text()) if self.help else notice, notice)
        pictures = canvases or (None,) * count
        places = viewports(beside(size, column), len(pictures), aspect)
        for picture, over, place in zip(pictures, notices, places, strict=False):
            self._presenter.show(picture, self._screen, place, hardware_srgb=False, notice=over)
        self._plates = [
            (place, over) for place, over in zip(places, notices, strict=False) if over is not None and over is notice
        ]

    def on_plate(self, x: float, y: float) -> tuple[float, float] | None:
        """Return (u, v) on the panel over the pictures at a place of the framebuffer.

        None beside it.

        The place is in pixels from the bottom left; so is (u, v).
        """
        for (left, low, w, h), notice in self._plates:
            if 0 <= x - left < w and 0 <= y - low < h:
                u, v, one = notice.plate_from_place((w, h), None) @ (x - left, y - low, 1.0)
                return (u / one, v / one) if 0 <= u / one <= 1 and 0 <= v / one <= 1 else None
        return None
