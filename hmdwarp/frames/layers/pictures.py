"""Further pictures of the same eye or instant, and marks of what the picture holds."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ...geometry.cube import cube_size, wide_size
from ..frame import EyeImage
from . import OWN, EyeSizes, Layer, Rows, Surface, layers, misfit_of_views, rows_of_views, view_of_row

if TYPE_CHECKING:
    import moderngl

MOST_VIEWS = 12  # as many places as the server looks at


@layers.register
class Cube(Layer):
    """Colour of the six faces of geometry.cube in one texture."""

    name = "cube"
    summary = "colour of everything around the eye, six faces in one texture"
    formats = ("rgba16f",)
    size_class = OWN
    drawn_by = "cube"

    @classmethod
    def size(cls, sizes: EyeSizes) -> tuple[int, int]:
        """Return the size of the larger eye's cube."""
        return max(cube_size(fov, sizes.shown) for fov in sizes.fovs)


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


@layers.register
class Light(Layer):
    """Adds nothing to a frame: the picture itself shows the light that falls on each surface.

    That is what the surface would send to the eye if its albedo were 1. The amount and the data are
    True.
    """

    name = "light"
    summary = "the picture holds light alone, as if every surface were white; it is sent instead of the colour"
    drawn_by = "light"
    apart = True

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()


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
