"""Further pictures of the same instant, from places that the eye may come to."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ..frame import EyeImage
from . import Layer, Rows, layers, misfit_of_views, rows_of_views, view_of_row

if TYPE_CHECKING:
    import moderngl

MOST_VIEWS = 12  # as many places as the server looks at


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

    @classmethod
    def amount_of(cls, stated: int | Rows) -> int:
        found = int(super().amount_of(stated))
        if found > MOST_VIEWS:
            raise ValueError(f"{found} views: expected {MOST_VIEWS} at most")
        return found

    @classmethod
    def numbers(cls, data: tuple[EyeImage, ...]) -> NDArray[np.float64]:
        """Return a row for each picture, its view."""
        return rows_of_views(view.view for view in data)

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: NDArray[Any] | None) -> str:
        return misfit_of_views(numbers, len(pictures) // 2)

    @classmethod
    def made(
        cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: int, drawn_ns: int
    ) -> tuple[EyeImage, ...]:
        assert numbers is not None, "misfit() says so"
        pairs = zip(numbers, sent[::2], sent[1::2], strict=True)
        return tuple(EyeImage(view_of_row(row), colour, depth, drawn_ns=drawn_ns) for row, colour, depth in pairs)
