"""The shown picture as it passes through fills and effects."""

from __future__ import annotations

from typing import TYPE_CHECKING

import attrs

if TYPE_CHECKING:
    import moderngl

    from ..gpu.textures import Canvas


@attrs.frozen(eq=False)
class ShownPicture:
    """The shown picture."""

    # rgba16f, linear, coverage in alpha.
    colour: Canvas
    # r32f of the same size, 1/m in the shown view, -1 where unknown (a hole, or a filled pixel
    # without depth); None where no pass of the plan reads it.
    inverse_depth: moderngl.Texture | None = None

    @property
    def depth(self) -> moderngl.Texture:
        """The inverse depth, for passes that read or write it: their plan makes it."""
        assert self.inverse_depth is not None
        return self.inverse_depth
