"""Light alone: the picture of the surfaces as if their albedo were 1."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...scenes import only_light
from ..moving import moving_parts
from ..passes import ScenePasses
from ..upload import SceneBuffers, SceneTextures
from . import parts
from ._base import DrawContext, Drawing, Part

if TYPE_CHECKING:
    from ...frames import EyeImage


@parts.register
class Light(Part):
    """Draws the plain surfaces itself; their depth stays the same."""

    name = "light"
    order = -1  # before voxels, whose light is that of coloured surfaces

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        gpu, scene = context.gpu, only_light(context.scene)
        self._textures = SceneTextures(gpu, scene)
        surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
        self._buffers = SceneBuffers(gpu, [mesh for mesh in surfaces if mesh.stands_still], self._textures)
        self._moving = moving_parts(gpu, scene, self._textures)
        # Lamps light it as they light the scene itself: between white surfaces there is more light.
        lighting = context.colour.lighting
        self._passes = ScenePasses(gpu, scene, self._buffers, colour=True, moving=self._moving, lighting=lighting)

    def passes_for(self, drawing: Drawing) -> ScenePasses | None:
        return self._passes if "light" in drawing.needs else None

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        return eye.having(light=True) if "light" in drawing.needs else eye

    def close(self) -> None:
        self._passes.close()
        for one in self._moving:
            one.close()
        self._buffers.close()
        self._textures.close()
