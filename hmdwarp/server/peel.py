"""Draws what lies behind the visible surfaces, one layer after the other: depth peeling.

Source: Everitt 2001, Interactive Order-Independent Transparency. Each pass draws the scene again without all that is not behind the layer
before. Every surface that faces the eye counts, also one close behind another (a picture on a wall): passed over, what lies behind both
would take its place, which it hides.
"""

from __future__ import annotations

from collections.abc import Callable

from ..frames.frame import EyeImage, Layer
from .passes import ScenePasses
from .targets import Framebuffers, Target

# A surface must not peel out from under itself. It is drawn with the same bits again; 2^-16 leaves room for drivers that round otherwise.
SAME_SURFACE = 2.0**-16


def peel(
    passes: ScenePasses, framebuffers: Framebuffers, acquire: Callable[[], Target], visible: EyeImage, count: int
) -> tuple[Layer, ...]:
    """The next `count` layers behind a picture, nearest first, into targets of the same size."""
    before, layers = visible.inverse_depth, []
    for _ in range(count):
        target = acquire()
        before.use(1)
        into = framebuffers.over(target.colour, target.inverse_depth)
        passes.draw(visible.view, into, visible.drawn_ns, in_front=1, keep=1 - SAME_SURFACE)
        layers.append(Layer(target.colour, target.inverse_depth))
        before = target.inverse_depth
    return tuple(layers)
