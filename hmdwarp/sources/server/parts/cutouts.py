"""Sheets whose alpha passes all light or none, such as fences: surfaces with holes and depth."""

from __future__ import annotations

import moderngl

from ....frames import EyeImage
from ....geometry import View
from ....scenes import Scene, is_cutout
from . import DrawContext, Drawing, Part, parts
from ._sheets import OVER_KEEPING_COVERAGE, Sheets


@parts.register
class Cutouts(Part):
    """Drawn before all other parts, while the depth buffer is still that of the surfaces.

    As part of the veil, such a sheet seen through glass would move with the glass. Its edges are
    blended; their depth is that of the side that covers more.
    """

    name = "cutouts"
    order = 0

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._sheets = Sheets(context, [mesh for mesh in context.scene.meshes if is_cutout(context.scene, mesh)])

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return any(is_cutout(scene, mesh) for mesh in scene.meshes)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        program, over = self._sheets.colour(), self.context.framebuffers.over(eye.colour)
        self._sheets.draw(program, eye.view, eye.drawn_ns, over, OVER_KEEPING_COVERAGE, hidden_by_surfaces=True)
        self.add_depth(eye.view, eye.drawn_ns, eye.inverse_depth)
        return eye

    def add_depth(self, view: View, time_ns: int, into: moderngl.Texture) -> None:
        self._sheets.draw(self._sheets.program("cutout"), view, time_ns, self.context.framebuffers.over(into), None)

    def close(self) -> None:
        self._sheets.close()
        super().close()
