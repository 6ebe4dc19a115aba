"""Light alone: the picture of the surfaces as if their albedo were 1."""

from __future__ import annotations

from ....frames import EyeImage
from ....scenes import only_light
from ..passes import ScenePasses
from ..upload import SceneBuffers, SceneTextures, moving_parts
from . import DrawContext, Drawing, Part, parts


@parts.register
class Light(Part):
    """Drawn over the plain surfaces, before anything else is added; their depth stays the same."""

    name = "light"
    order = -1  # before cut-outs, which it would draw over

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

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if "light" not in drawing.needs:
            return eye
        self.context.draw_colour(self._passes, eye.view, eye.colour, eye.drawn_ns)
        return eye.having(light=True)

    def close(self) -> None:
        self._passes.close()
        for drawing in self._moving:
            drawing.close()
        self._buffers.close()
        self._textures.close()
