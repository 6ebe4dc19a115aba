"""The whole of a window: the eyes' pictures, black around them, and text over them."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from ...gpu.context import Gpu
from ...gpu.textures import Canvas
from .. import Label
from ..present import Presenter
from .keys import help_text
from .layout import Size, beside, viewports

SAID_NS = 4_000_000_000  # how long a remark stays


class Overlay:
    """help: whether the keys are explained over the picture, in place of anything else there."""

    def __init__(self, gpu: Gpu, presenter: Presenter, now_ns: Callable[[], int]) -> None:
        self._screen, self._presenter, self._now_ns = gpu.gl.screen, presenter, now_ns
        self.help = False
        self._said, self._until_ns = "", 0

    def say(self, text: str) -> None:
        """A remark over the picture, for a few seconds."""
        self._said, self._until_ns = text, self._now_ns() + SAID_NS

    def draw(self, canvases: Sequence[Canvas], count: int, aspect: float, size: Size, column: int, label: Label) -> None:
        """Into the window's framebuffer, (w, h) pixels. canvases: the eyes' pictures, none for black. count: of eyes, where there are no
        pictures. aspect: width over height of one picture. column: of it are left to a panel at the right.
        label: over each picture; beside a plate nothing is said."""
        self._screen.scissor = None
        self._screen.clear(0.0, 0.0, 0.0, 1.0)
        said = self._said if self._now_ns() < self._until_ns else ""
        notice = self._presenter.notice("\n".join(filter(None, (label, said))) if isinstance(label, str) else label)
        # The help before the first eye alone: beside it one sees what the keys do.
        notices = (self._presenter.notice(help_text()) if self.help else notice, notice)
        pictures = canvases or (None,) * count
        for picture, over, place in zip(pictures, notices, viewports(beside(size, column), len(pictures), aspect), strict=False):
            self._presenter.show(picture, self._screen, place, hardware_srgb=False, notice=over)
