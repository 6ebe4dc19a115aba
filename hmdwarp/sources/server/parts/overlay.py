"""Head-locked content (a HUD): drawn over everything, or a layer that is never warped."""

from __future__ import annotations

import moderngl

from ....frames import EyeImage
from ....geometry import View
from ....gpu.textures import drawing_into
from ....scenes import Scene
from . import DrawContext, Drawing, Part, parts
from ._sheets import OVER, OVER_KEEPING_COVERAGE, Blending, Sheets


@parts.register
class Overlay(Part):
    """Drawn into the picture, it keeps the depth of what it covers."""

    name = "overlay"
    order = 95

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._sheets = Sheets(context, [mesh for mesh in context.scene.meshes if mesh.material.head_locked])

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return any(mesh.material.head_locked for mesh in scene.meshes)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if "overlay" not in drawing.needs:
            self._draw(eye.view, drawing.time_ns, self.context.framebuffers.over(eye.colour), OVER_KEEPING_COVERAGE)
            return eye
        into = self.context.acquire(drawing.shown_size or drawing.size, depth=False).colour
        framebuffer = self.context.framebuffers.over(into)
        with drawing_into(framebuffer):
            framebuffer.clear()
        self._draw(drawing.view, drawing.time_ns, framebuffer, OVER)
        return eye.having(overlay=into)

    def _draw(self, view: View, time_ns: int, framebuffer: moderngl.Framebuffer, blending: Blending) -> None:
        program = self._sheets.colour(covers=blending is not OVER)
        self._sheets.draw(program, view, time_ns, framebuffer, blending)

    def close(self) -> None:
        self._sheets.close()
        super().close()
