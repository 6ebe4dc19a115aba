"""What mirrors show, apart from the mirrors themselves."""

from __future__ import annotations

import enum
from typing import TYPE_CHECKING

import attrs

from . import BRIGHT_VIDEO, DEPTH, PIXEL_BYTES, VECTORS, EyeSizes, Layer, Surface, layers

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
    # The pixels outside which nothing mirrors: x, y of the first, x, y after the last, from the
    # bottom left; None for the whole picture. Only they are sent; a codec spends nothing on the
    # others, which are all the same.
    bounds: tuple[int, int, int, int] | None = None


@layers.register
class Reflections(Layer):
    """A Reflection; the amount is a Mirrored."""

    name = "reflection"
    summary = "what mirrors show, with the depth of the mirrored world"
    formats = ("rgba16f", "r32f", "rgba16f")
    # What is seen is shown by a share of its light, so light beyond 1 matters.
    codings = (BRIGHT_VIDEO, DEPTH, VECTORS)
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
    def sent_bytes(cls, data: Reflection) -> int:
        """Return the bytes of what is within the bounds."""
        if data.bounds is None:
            return super().sent_bytes(data)
        low_x, low_y, high_x, high_y = data.bounds
        return sum(PIXEL_BYTES[one] for one in cls.formats) * (high_x - low_x) * (high_y - low_y)

    @classmethod
    def textures(cls, data: Reflection) -> Iterable[moderngl.Texture]:
        return (*data.seen.textures(), data.surface)
