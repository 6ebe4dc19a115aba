"""What mirrors show, apart from the mirrors themselves."""

from __future__ import annotations

import enum
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry import Mirror
from . import BRIGHT_VIDEO, DEPTH, PIXEL_BYTES, VECTORS, Layer, Surface, layers

if TYPE_CHECKING:
    import moderngl

_MIRROR_NUMBERS = 11


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
    def pictures(cls, amount: Mirrored) -> tuple[str, ...]:
        """Return the same for all kinds of mirrors: they share the textures."""
        return cls.formats

    @classmethod
    def merged(cls, amount: Mirrored, other: Mirrored) -> Mirrored:
        return amount | other

    @classmethod
    def sent_bytes(cls, data: Reflection) -> int:
        """Return the bytes of what is within the bounds."""
        if data.bounds is None:
            return super().sent_bytes(data)
        low_x, low_y, high_x, high_y = data.bounds
        return sum(PIXEL_BYTES[kind] for kind in cls.formats) * (high_x - low_x) * (high_y - low_y)

    @classmethod
    def textures(cls, data: Reflection) -> Iterable[moderngl.Texture]:
        return (*data.seen.textures(), data.surface)

    @classmethod
    def numbers(cls, data: Reflection) -> NDArray[np.float64]:
        """Return a row for each mirror: centre, right, up, radius, reflectivity."""
        rows = [
            (*mirror.centre_m, *mirror.right_m, *mirror.up_m, mirror.radius_m, mirror.reflectivity)
            for mirror in data.mirrors
        ]
        return np.array(rows, np.float64).reshape(-1, _MIRROR_NUMBERS)

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: NDArray[Any] | None) -> str:
        if numbers is None or numbers.shape[1] != _MIRROR_NUMBERS:
            return f"its mirrors are missing: expected rows of {_MIRROR_NUMBERS} numbers"
        radius, reflectivity = numbers[:, 9], numbers[:, 10]
        areas = np.linalg.norm(np.cross(numbers[:, 3:6], numbers[:, 6:9]), axis=1)
        is_there = (radius > 0) | ((radius == 0) & (areas > 0))
        if not (is_there & (reflectivity >= 0) & (reflectivity <= 1)).all():
            return "a mirror without an area, or that reflects less than nothing or more than all"
        return ""

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: Any, drawn_ns: int) -> Reflection:
        assert numbers is not None, "misfit() says so"
        colour, inverse_depth, surface = sent
        mirrors = tuple(Mirror(row[:3], row[3:6], row[6:9], *map(float, row[9:])) for row in numbers)
        return Reflection(Surface(colour, inverse_depth), surface, mirrors)
