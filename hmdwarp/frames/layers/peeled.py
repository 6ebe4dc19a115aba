"""Surfaces behind the visible one, by depth peeling."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from numpy.typing import NDArray

from . import Layer, Surface, layers

if TYPE_CHECKING:
    import moderngl


@layers.register
class Peeled(Layer):
    """A tuple of Surface, nearest first; the amount is their number."""

    name = "peeled"
    summary = "the surfaces behind the visible one, nearest first"
    formats = ("rgba16f", "r32f")
    drawn_by = "peeled"
    something = 2

    @classmethod
    def only(cls, data: tuple[Surface, ...], amount: int) -> tuple[Surface, ...]:
        """Return the nearest `amount` surfaces."""
        return data[:amount]

    @classmethod
    def textures(cls, data: tuple[Surface, ...]) -> Iterable[moderngl.Texture]:
        return (texture for surface in data for texture in surface.textures())

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: Any, drawn_ns: int) -> tuple[Surface, ...]:
        return tuple(Surface(*pair) for pair in zip(sent[::2], sent[1::2], strict=True))
