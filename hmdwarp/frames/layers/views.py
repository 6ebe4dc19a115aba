"""Further pictures of the same instant, from places that the eye may come to."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from ..frame import EyeImage
from . import Layer, layers

if TYPE_CHECKING:
    import moderngl


@layers.register
class Views(Layer):
    """A tuple of EyeImage, the most useful first; the amount is their number."""

    name = "views"
    summary = "whole pictures of the same instant from places that the eye may come to"
    formats = ("rgba16f", "r32f")
    drawn_by = "views"
    something = 2

    @classmethod
    def only(cls, data: tuple[EyeImage, ...], amount: int) -> tuple[EyeImage, ...]:
        """Return the most useful `amount` pictures."""
        return data[:amount]

    @classmethod
    def textures(cls, data: tuple[EyeImage, ...]) -> Iterable[moderngl.Texture]:
        return (texture for view in data for texture in (view.colour, view.inverse_depth))
