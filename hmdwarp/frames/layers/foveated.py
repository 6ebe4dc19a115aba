"""The picture, sharp where the eye looks and coarser beyond: what crosses in its place."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import attrs
from numpy.typing import NDArray

from ...errors import InputError
from ...geometry import Fovea, FoveaGrid, grid_of
from . import OWN, PIXEL_BYTES, EyeSizes, Layer, layers

if TYPE_CHECKING:
    import moderngl


# What comes in place of colour and of inverse depth.
FOVEATED = ("foveated", "foveated_depth")


@attrs.frozen(eq=False)
class FoveatedPicture:
    """A picture on a coarser grid."""

    # Of the layer's format, and of the grid's small size.
    texture: moderngl.Texture
    grid: FoveaGrid


class FoveatedLayer(Layer):
    """A FoveatedPicture. The amount is the Fovea."""

    size_class = OWN
    drawn_by = "foveated"
    something = Fovea()

    @classmethod
    def size(cls, sizes: EyeSizes) -> tuple[int, int]:
        return _small(cls.something, sizes)

    @classmethod
    def bytes(cls, amount: Fovea, sizes: EyeSizes) -> int:
        width, height = _small(amount, sizes)
        return PIXEL_BYTES[cls.formats[0]] * width * height

    @classmethod
    def pictures(cls, amount: Fovea) -> tuple[str, ...]:
        return cls.formats

    @classmethod
    def textures(cls, data: FoveatedPicture) -> Iterable[moderngl.Texture]:
        return (data.texture,)

    @classmethod
    def numbers(cls, data: FoveatedPicture) -> NDArray[Any]:
        return data.grid.numbers()

    @classmethod
    def misfit(cls, pictures: Sequence[NDArray[Any]], numbers: NDArray[Any] | None) -> str:
        try:
            grid_of(numbers, pictures[0].shape[1::-1]) if numbers is not None else None
        except InputError as error:
            return str(error)
        return "" if numbers is not None else "its grid is missing"

    @classmethod
    def made(cls, sent: Sequence[Any], numbers: NDArray[Any] | None, amount: Fovea, drawn_ns: int) -> FoveatedPicture:
        assert numbers is not None, "misfit() says so"
        return FoveatedPicture(sent[0], grid_of(numbers, sent[0].size))


def _small(fovea: Fovea, sizes: EyeSizes) -> tuple[int, int]:
    return fovea.small(sizes.fovs[0], sizes.shown, sizes.rendered)


@layers.register
class Foveated(FoveatedLayer):
    """Its colour: the mean of the covered pixels that one of the rim holds."""

    name = "foveated"
    summary = "the rendered picture, coarser away from where the eye looks"
    formats = ("rgba16f",)


@layers.register
class FoveatedDepth(FoveatedLayer):
    """In 1/m: of the pixels that one of the rim holds, the mean over their nearest surface."""

    name = "foveated_depth"
    summary = "inverse depth of the rendered picture, coarser away from where the eye looks"
    formats = ("r32f",)
