"""A second, wide and coarse picture of the same eye and instant."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ...geometry.cube import wide_size
from ..frame import EyeImage
from . import OWN, EyeSizes, Layer, layers

if TYPE_CHECKING:
    import moderngl


@layers.register
class Wide(Layer):
    """An EyeImage of its own, with the view that geometry.wide gives."""

    name = "wide"
    summary = "a second picture of the same eye, wide and coarse"
    formats = ("rgba16f", "r32f")
    size_class = OWN
    drawn_by = "wide"

    @classmethod
    def size(cls, sizes: EyeSizes) -> tuple[int, int]:
        """Return the larger of both eyes' width and height."""
        widths, heights = zip(*(wide_size(fov, sizes.shown) for fov in sizes.fovs), strict=True)
        return max(widths), max(heights)

    @classmethod
    def textures(cls, data: EyeImage) -> Iterable[moderngl.Texture]:
        return data.textures()

    @classmethod
    def sent(cls, data: EyeImage) -> Iterable[moderngl.Texture]:
        """Return the picture alone: what head-locked content was drawn into is not read."""
        return data.colour, data.inverse_depth
