"""Pictures whose indirect light is looked up in a grid of voxels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..voxels import NearLight, VoxelLighting, VoxelPasses
from . import parts
from ._base import DrawContext, Drawing, Part

if TYPE_CHECKING:
    from ....frames import EyeImage
    from ....frames.layers.voxels import VoxelLight
    from ..passes import ScenePasses


@parts.register
class Voxels(Part):
    """Draws the plain surfaces itself, in a scene with lamps; all light of others is baked."""

    name = "voxels"
    order = 1

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._made: dict[VoxelLight, tuple[VoxelLighting, NearLight, VoxelPasses]] = {}

    def passes_for(self, drawing: Drawing) -> ScenePasses | None:
        context, settings = self.context, drawing.needs.get("voxels")
        if settings is None or not context.scene.lamps:
            return None
        if settings not in self._made:
            lighting = VoxelLighting(context.gpu, context.scene, settings)
            near = NearLight(lighting, context.scene, context.colour, context.framebuffers)
            self._made[settings] = lighting, near, VoxelPasses(lighting, near, context.colour)
        return self._made[settings][-1]

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye.having(voxels=drawing.needs["voxels"]) if "voxels" in drawing.needs else eye

    def close(self) -> None:
        for lighting, near, passes in self._made.values():
            passes.close()
            near.close()
            lighting.close()
