"""Sheets whose alpha passes all light or none, such as fences: surfaces with holes and depth."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl

from ....scenes import is_cutout
from . import parts
from ._base import DrawContext, Drawing, Part
from ._sheets import OVER_KEEPING_COVERAGE, Sheets

if TYPE_CHECKING:
    import moderngl

    from ....frames import EyeImage
    from ....geometry import View
    from ....scenes import Scene


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
        cut = [mesh for mesh in context.scene.meshes if is_cutout(context.scene, mesh)]
        self._sheets = Sheets(context, cut) if cut else None

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return any(mesh.material.see_through for mesh in scene.meshes)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if self._sheets is not None:
            program = self.context.gpu.shaders.draw(
                "server/pane.vert", "server/pane.frag", TESTS=0, COLOUR=1, SLOTS=self._sheets.slots
            )
            program.uniforms.set(covers=1.0)
            framebuffer = self.context.framebuffers.over(eye.colour)
            self._sheets.draw(
                program, eye.view, eye.drawn_ns, framebuffer, OVER_KEEPING_COVERAGE, hidden_by_surfaces=True
            )
        self.add_depth(eye.view, eye.drawn_ns, eye.inverse_depth)
        return eye

    def add_depth(self, view: View, time_ns: int, into: moderngl.Texture) -> None:
        if self._sheets is not None:
            program = self.context.gpu.shaders.draw("server/pane.vert", "server/cutout.frag", SLOTS=self._sheets.slots)
            self._sheets.draw(program, view, time_ns, self.context.framebuffers.over(into), None)

    def close(self) -> None:
        if self._sheets is not None:
            self._sheets.close()
