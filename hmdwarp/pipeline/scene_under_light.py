"""The scene on a client that draws it under its own lamps."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..gpu.textures import COLOUR, allocate
from ..scenes import kernel_factors, transport_of
from ..sources.server import (
    Framebuffers,
    Indirect,
    SceneBuffers,
    ScenePasses,
    SceneTextures,
    moving_parts,
)

if TYPE_CHECKING:
    import moderngl

    from ..client import ShownPicture
    from ..geometry import View
    from ..gpu.context import Gpu
    from ..gpu.shaders import Inputs
    from ..scenes import Scene


class _Surfaces:
    """Surfaces only, by the server's own passes: one for each source of indirect light."""

    def __init__(self, gpu: Gpu, scene: Scene, *sources: Indirect) -> None:
        self.scene = scene
        surfaces = [mesh for mesh in scene.meshes if mesh.is_surface]
        self._textures = SceneTextures(gpu, scene)
        self._buffers = SceneBuffers(gpu, [mesh for mesh in surfaces if mesh.stands_still], self._textures)
        self._moving = moving_parts(gpu, scene, self._textures)
        self._passes = {
            source: ScenePasses(gpu, scene, self._buffers, colour=True, moving=self._moving, indirect=source)
            for source in sources
        }
        self._framebuffers = Framebuffers(gpu.gl)

    def _draw(self, source: Indirect, view: View, into: ShownPicture, time_ns: int) -> None:
        self._passes[source].draw(view, self._framebuffers.over(into.colour.texture, into.depth), time_ns)

    def close(self) -> None:
        """Free its buffers; the shader library owns the programs."""
        for passes in self._passes.values():
            passes.close()
        self._framebuffers.close()
        for one in self._moving:
            one.close()
        self._buffers.close()
        self._textures.close()


class SceneUnderLight(_Surfaces):
    """A client.LitScene."""

    def __init__(self, gpu: Gpu, scene: Scene) -> None:
        super().__init__(gpu, scene, Indirect.ATLAS)

    def draw(self, view: View, into: ShownPicture, time_ns: int, indirect: moderngl.Texture) -> None:
        """Draw the whole picture, see LitScene.draw."""
        lighting = self._passes[Indirect.ATLAS].lighting
        if lighting is not None:
            lighting.indirect = indirect
        self._draw(Indirect.ATLAS, view, into, time_ns)


class SceneUnderPhotons(_Surfaces):
    """A client.SplattedScene for photons of that radius."""

    def __init__(self, gpu: Gpu, scene: Scene, radius: float) -> None:
        super().__init__(gpu, scene, Indirect.SPLATS, Indirect.RECEIVERS)
        lighting = self._passes[Indirect.RECEIVERS].lighting
        self._factors: moderngl.Texture | None = None
        if lighting is not None:
            factors = kernel_factors(transport_of(scene), radius)
            self._factors = lighting.indirect = allocate(gpu.gl, factors.shape[1::-1], COLOUR)
            self._factors.write(factors.tobytes())

    def draw_receivers(self, view: View, into: ShownPicture, time_ns: int) -> None:
        """Draw normals and factors, see SplattedScene.draw_receivers."""
        self._draw(Indirect.RECEIVERS, view, into, time_ns)

    def draw(self, view: View, into: ShownPicture, time_ns: int, splats: Inputs) -> None:
        """Draw the whole picture, see SplattedScene.draw."""
        lighting = self._passes[Indirect.SPLATS].lighting
        if lighting is not None:
            lighting.splats = splats
        self._draw(Indirect.SPLATS, view, into, time_ns)

    def close(self) -> None:
        """Free its buffers; the shader library owns the programs."""
        super().close()
        if self._factors is not None:
            self._factors.release()
