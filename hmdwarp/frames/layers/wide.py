"""A second, wide and coarse picture of the same eye and instant."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...geometry.cube import wide_size
from ..frame import EyeImage
from . import OWN, EyeSizes, Layer, layers, misfit_of_views, rows_of_views, view_of_row

if TYPE_CHECKING:
    import moderngl


@layers.register
class Wide(Layer):
    """An EyeImage of its own, with the view that geometry.wide gives."""

    name = "wide"
    summary = "a second picture of the same eye, wide and coarse"
    formats = ("rgba16f", "r32f")
    size_class = OWN
    drawn_by = "wide"

    @classmethod
    def size(cls, sizes: EyeSizes) -> tuple[int, int]:
        """Return the larger of both eyes' width and height."""
        widths, heights = zip(*(wide_size(fov, sizes.shown) for fov in sizes.fovs), strict=True)
        return max(widths), max(heights)

    @classmethod
    def textures(cls, data: EyeImage) -> Iterable[moderngl.Texture]:
        return data.textures()

    @classmethod
    def sent(cls, data: EyeImage) -> Iterable[moderngl.Texture]:
        """Return the picture alone: what head-locked content was drawn into is not read."""
        return data.colour, data.inverse_depth

    @classmethod
    def numbers(cls, data: EyeImage) -> NDArray[np.float64]:
        """Return a row, its view."""
        return rows_of_views([data.view])

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: NDArray[Any] | None) -> str:
        return misfit_of_views(numbers, 1)

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: Any, drawn_ns: int) -> EyeImage:
        assert numbers is not None, "misfit() says so"
        return EyeImage(view_of_row(numbers[0]), sent[0], sent[1], drawn_ns=drawn_ns)
