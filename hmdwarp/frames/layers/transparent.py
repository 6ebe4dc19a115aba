"""What one sees through."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import attrs
from numpy.typing import NDArray

from . import Layer, Surface, layers

if TYPE_CHECKING:
    import moderngl


@attrs.frozen(eq=False)
class Transparent:
    """Glass and the like, as one veil before the picture."""

    # Its own light, premultiplied, with its inverse depth; coverage 1 wherever something
    # transparent is.
    veil: Surface
    # rgba16f, the share of the light behind that passes, by colour, 1 where nothing is; coverage as
    # the veil's.
    passing: moderngl.Texture


@layers.register
class Transparency(Layer):
    """A Transparent."""

    name = "transparent"
    summary = "glass and the like as a veil with a depth of its own"
    formats = ("rgba16f", "r32f", "rgba16f")
    drawn_by = "transparency"
    apart = True

    @classmethod
    def textures(cls, data: Transparent) -> Iterable[moderngl.Texture]:
        return (*data.veil.textures(), data.passing)

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: Any, drawn_ns: int) -> Transparent:
        colour, inverse_depth, passing = sent
        return Transparent(Surface(colour, inverse_depth), passing)
