"""The mark of frames whose indirect light is looked up in a grid of voxels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import attrs

from . import EyeSizes, Layer, layers

if TYPE_CHECKING:
    from collections.abc import Iterable

    import moderngl

LEAST_CELLS, MOST_CELLS = 8, 256
MOST_CONES = 32


def _between(least: int, most: int) -> Any:
    def check(_: object, field: attrs.Attribute, value: int) -> None:
        if not least <= value <= most:
            raise ValueError(f"{field.name} is {value}: expected {least} to {most}")

    return check


@attrs.frozen(order=True)
class VoxelLight:
    """How the server finds indirect light."""

    # Cells of the grid on each axis; 115 bytes each on the server's GPU.
    size: int = attrs.field(default=64, validator=_between(LEAST_CELLS, MOST_CELLS))
    # Cones that look from each pixel, and from each cell at each bounce.
    cones: int = attrs.field(default=6, validator=_between(4, MOST_CONES))
    # How often light goes from cell to cell before pixels look.
    bounces: int = attrs.field(default=2, validator=_between(0, 16))
    # Times a second that the grid is lit anew, at most.
    updates: float = attrs.field(default=10.0, validator=attrs.validators.gt(0))


@layers.register
class Voxels(Layer):
    """Adds nothing to a frame: the picture itself has another light. The amount is a VoxelLight."""

    name = "voxels"
    summary = "the picture's indirect light is looked up in a grid of voxels that views share; it adds no bytes"
    drawn_by = "voxels"
    apart = True
    nothing, something = None, VoxelLight()

    @classmethod
    def bytes(cls, amount: Any, sizes: EyeSizes) -> int:
        return 0

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()
