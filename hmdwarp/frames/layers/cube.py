"""Everything around the eye."""

from __future__ import annotations

from ...geometry.cube import cube_size
from . import OWN, EyeSizes, Layer, layers


@layers.register
class Cube(Layer):
    """Colour of the six faces of geometry.cube in one texture."""

    name = "cube"
    summary = "colour of everything around the eye, six faces in one texture"
    formats = ("rgba16f",)
    size_class = OWN
    drawn_by = "cube"

    @classmethod
    def size(cls, sizes: EyeSizes) -> tuple[int, int]:
        """Return the size of the larger eye's cube."""
        return max(cube_size(fov, sizes.shown) for fov in sizes.fovs)
