"""The mark of frames whose indirect light is looked up in a grid of voxels."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import attrs

from ...errors import InputError
from ...scenes import Scene
from . import Layer, between, layers

if TYPE_CHECKING:
    import moderngl

SIZES = (8, 16, 32, 64, 128, 256)
MOST_CONES = 32


def _one_of(known: tuple[int, ...]) -> Any:
    def check(_: object, field: attrs.Attribute[int], value: int) -> None:
        if value not in known:
            raise ValueError(f"{field.name} is {value}: expected one of {', '.join(map(str, known))}")

    return check


@attrs.frozen(order=True)
class VoxelLight:
    """How the server finds indirect light."""

    # Cells of the grid on each axis.
    size: int = attrs.field(default=64, validator=_one_of(SIZES))
    # Cones that look from each pixel, and from each cell at each bounce.
    cones: int = attrs.field(default=6, validator=between(4, MOST_CONES))
    # How often light goes from cell to cell before pixels look.
    bounces: int = attrs.field(default=4, validator=between(0, 16))
    # Times a second that the grid is lit anew, at most.
    updates: float = attrs.field(default=10.0, validator=between(1e-6, 1e6))

    @staticmethod
    def unsuited(scene: Scene) -> str:
        """Return why it is not for the scene, "" if it is."""
        if not scene.meshes:
            return "it is not drawn here, and its light is in its frames"
        return "" if scene.lamps else "its light stands still, and what is baked is exact"


@layers.register
class Voxels(Layer):
    """Adds nothing to a frame: the picture itself has another light. The amount is a VoxelLight."""

    name = "voxels"
    summary = "the picture's indirect light is looked up in a grid of voxels that views share; it adds no bytes"
    drawn_by = "voxels"
    apart = True
    # The grid is lit for the first frame of each update.
    builds_on_frames = True
    lights = True
    nothing, something = None, VoxelLight(size=16)

    @classmethod
    def merged(cls, amount: VoxelLight, other: VoxelLight) -> VoxelLight:
        if amount != other:
            raise InputError(f"frames lit by {amount} and by {other}: a frame has one light; run them apart")
        return amount

    @classmethod
    def pictures(cls, amount: VoxelLight) -> tuple[str, ...]:
        return ()

    @classmethod
    def kept_bytes(cls, amount: VoxelLight) -> int:
        """Return those of six grids of 8 bytes a cell, with all coarser levels."""
        return 6 * 8 * amount.size**3 * 8 // 7

    @classmethod
    def textures(cls, data: Any) -> Iterable[moderngl.Texture]:
        return ()
