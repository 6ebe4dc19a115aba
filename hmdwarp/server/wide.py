"""The second, wide and coarse view of an eye: a whole picture of its own, with depth."""

from __future__ import annotations

from collections.abc import Callable

from ..frames.frame import EyeImage, Needs
from ..geometry import View
from ..geometry.wide import wide_size, wide_view
from .parts import Drawing


def draw_wide(draw: Callable[[View, tuple[int, int], Drawing], EyeImage], drawing: Drawing) -> EyeImage:
    """As wide as geometry.wide says, around the shown view of `drawing`, by the server's own way to draw a picture.

    Everything is drawn into it as it is, nothing is a layer of its own, but for what is fixed to the head: that is no scenery.
    """
    view, size = wide_view(drawing.view), wide_size(drawing.view.fov, drawing.size)
    return draw(view, size, Drawing(view, size, drawing.time_ns, Needs(overlay=drawing.needs.overlay)))
