"""The picture less that of a simplified scene, for clients that draw that one themselves."""

from __future__ import annotations

from ....frames import EyeImage
from ....frames.layers.scene_parts import Simplified
from ....gpu.textures import COLOUR
from ....scenes import partial_scene
from ..targets import BYTES_BINDING, MOST_SETTINGS, LastUsed, display_bytes
from . import DrawContext, Drawing, Part, Renderer, parts


@parts.register
class Difference(Part):
    """Drawn when the picture is complete: the simplified scene for the same view and instant."""

    name = "difference"
    order = 190

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._program = context.gpu.shaders.compute("server/difference.comp")
        self._bytes = display_bytes(context.gpu.gl)
        self._renderers: LastUsed[Simplified, Renderer] = LastUsed()

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        needed: frozenset[Simplified] = drawing.needs.get("difference", frozenset())
        if not needed:
            return eye
        made = {}
        for each in sorted(needed):
            target = self.kept("simplified", eye.size)
            self._renderer(each).draw(eye.view, eye.size, target, drawing.time_ns)
            made[each] = self.context.acquire(eye.size, COLOUR, depth=False).colour
            self.context.gpu.barrier()
            for unit, texture in enumerate((eye.colour, target.colour)):
                texture.bind_to_image(unit, read=True, write=False)
            made[each].bind_to_image(2, read=False, write=True)
            self._bytes.bind_to_storage_buffer(BYTES_BINDING)
            self._program.uniforms.set(full=0, simplified=1, difference=2, rendered_size=eye.size)
            self._program.run(*eye.size)
            self.context.gpu.barrier()
        for unused in self._renderers.beyond(max(MOST_SETTINGS, len(needed))):
            unused.close()
        return eye.having(difference=made)

    def _renderer(self, each: Simplified) -> Renderer:
        """Return what draws the simplified scene, as the client draws it."""
        of = self.context.scene, each.share, each.texture
        return self._renderers.made(each, lambda: self.context.renderer(partial_scene(*of, lit=each.lit)))

    def close(self) -> None:
        for renderer in self._renderers.values():
            renderer.close()
        self._bytes.release()
        super().close()
