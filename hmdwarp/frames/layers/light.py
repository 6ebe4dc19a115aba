"""The mark of frames whose picture is light alone."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from . import Layer, layers

if TYPE_CHECKING:
    import moderngl


@layers.register
class Light(Layer):
    """Adds nothing to a frame: the picture itself shows the light that falls on each surface.

    That is what the surface would send to the eye if its albedo were 1. The amount and the data are
    True.
    """

    name = "light"
    summary = "the picture holds light alone, as if every surface were white; it is sent instead of the colour"
    drawn_by = "light"
    apart = True

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()
