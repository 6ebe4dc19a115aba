"""A picture with depth, as several layers have them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

if TYPE_CHECKING:
    import moderngl


@attrs.frozen(eq=False)
class Surface:
    """Another surface of the same view and size; holes as in EyeImage."""

    # rgba16f, linear light with coverage in alpha.
    colour: moderngl.Texture
    # r32f in 1/m, -1 in holes.
    inverse_depth: moderngl.Texture

    def textures(self) -> tuple[moderngl.Texture, moderngl.Texture]:
        """Return both textures."""
        return self.colour, self.inverse_depth
