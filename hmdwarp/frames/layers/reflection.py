"""What mirrors show, apart from the mirrors themselves."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING

import attrs

from . import EyeSizes, Layer, Surface, layers

if TYPE_CHECKING:
    from collections.abc import Iterable

    import moderngl

    from ...geometry import Mirror


class Mirrored(enum.Flag):
    """The kinds of mirrors whose reflections are a layer; the picture has the others."""

    PLANE = enum.auto()
    CURVED = enum.auto()


@attrs.frozen(eq=False)
class Reflection:
    """What mirrors show."""

    # The mirrored world. Its inverse depth is that of the virtual image behind the mirror: 1 / the
    # depth of the whole reflected path. Drawn wherever a mirror is and a little around it, also
    # behind what stands before it; holes elsewhere.
    seen: Surface
    # rgba16f, of what the picture itself shows: reflectivity straight on (r; 0 where nothing
    # mirrors), the disturbed normal's x and y along the mirror's right and up (g, b), and coverage.
    surface: moderngl.Texture
    # All mirrors that `seen` and `surface` describe, in the world.
    mirrors: tuple[Mirror, ...] = ()


@layers.register
class Reflections(Layer):
    """A Reflection; the amount is a Mirrored."""

    name = "reflection"
    summary = "what mirrors show, with the depth of the mirrored world"
    formats = ("rgba16f", "r32f", "rgba16f")
    drawn_by = "reflections"
    apart = True
    something = Mirrored.PLANE | Mirrored.CURVED

    @classmethod
    def bytes(cls, amount: Mirrored, sizes: EyeSizes) -> int:
        """Return the same for all kinds of mirrors: they share the textures."""
        return super().bytes(1, sizes)

    @classmethod
    def merged(cls, amount: Mirrored, other: Mirrored) -> Mirrored:
        return amount | other

    @classmethod
    def textures(cls, data: Reflection) -> Iterable[moderngl.Texture]:
        return (*data.seen.textures(), data.surface)
