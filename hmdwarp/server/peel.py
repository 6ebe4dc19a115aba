"""Draws what lies behind the visible surfaces, one layer after the other: depth peeling.

Source: Everitt 2001, Interactive Order-Independent Transparency. Each pass draws the scene again without all that is not behind the layer
before. What lies so little behind that an eye within VIEW_CELL_M of this one would see less than a pixel of it past the edge of
what covers it is passed over: it would take the place of what can be seen.
"""

from __future__ import annotations

from collections.abc import Callable

from ..frame import EyeImage, Layer
from ..geometry import View
from .passes import ScenePasses
from .targets import Framebuffers, Target

VIEW_CELL_M = 0.5  # a walker's way in 400 ms
# A surface must not peel out from under itself. It is drawn with the same bits again; 2^-16 leaves room for drivers that round otherwise.
SAME_SURFACE = 2.0**-16


def least_gap(view: View, size: tuple[int, int]) -> float:
    """1/m: the difference of inverse depths at which an eye VIEW_CELL_M aside sees two surfaces one pixel apart."""
    left, right, down, up = view.fov.tangents
    return 1 / (VIEW_CELL_M * max(size[0] / (right - left), size[1] / (up - down)))


def peel(
    passes: ScenePasses, framebuffers: Framebuffers, acquire: Callable[[], Target], visible: EyeImage, count: int
) -> tuple[Layer, ...]:
    """The next `count` layers behind a picture, nearest first, into targets of the same size."""
    before, layers = visible.inverse_depth, []
    limits = {"keep": 1 - SAME_SURFACE, "gap": least_gap(visible.view, visible.size)}
    for _ in range(count):
        target = acquire()
        before.use(1)
        passes.draw(visible.view, framebuffers.over(target.colour, target.inverse_depth), in_front=1, **limits)
        layers.append(Layer(target.colour, target.inverse_depth))
        before = target.inverse_depth
    return tuple(layers)
