"""The whole parts of sheets (the laths of a fence of alpha, not the air between): surfaces with a depth of their own."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl
import numpy as np

from . import parts
from ._base import Drawing, Easel, Part
from ._sheets import Sheets

if TYPE_CHECKING:
    from ...frame import EyeImage, Needs
    from ...geometry import View
    from ...scenes import Mesh, Scene

WHOLE = 255 / 256  # as in shaders/server/pane.frag


@parts.register
class Cutouts(Part):
    """Comes before all others: the depth buffer is still that of the surfaces. What is left of the sheets is the part `transparency`.

    So what one sees through glass has its own depth as long as nothing shines through it itself.
    """

    name = "cutouts"
    order = 0

    def __init__(self, easel: Easel) -> None:
        super().__init__(easel)
        cut = [mesh for mesh in easel.scene.meshes if mesh.material.see_through and has_whole_parts(easel.scene, mesh)]
        self._sheets = Sheets(easel, cut) if cut else None

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return any(mesh.material.see_through for mesh in scene.meshes)

    @classmethod
    def wanted(cls, needs: Needs) -> bool:
        return False

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        self._draw(eye.view, eye.drawn_ns, self.easel.framebuffers.over(eye.colour, eye.inverse_depth), colour=1)
        return eye

    def add_depth(self, view: View, time_ns: int, into: moderngl.Texture) -> None:
        self._draw(view, time_ns, self.easel.framebuffers.over(into), colour=0)

    def _draw(self, view: View, time_ns: int, framebuffer: moderngl.Framebuffer, colour: int) -> None:
        if self._sheets is not None:
            program = self.easel.gpu.shaders.draw("server/pane.vert", "server/cutout.frag", COLOUR=colour)
            self._sheets.draw(program, view, time_ns, framebuffer, None)

    def close(self) -> None:
        if self._sheets is not None:
            self._sheets.close()


def has_whole_parts(scene: Scene, mesh: Mesh) -> bool:
    """Whether anything of a sheet lets nothing pass."""
    image = scene.textures[mesh.texture].image if mesh.texture >= 0 else None
    most = 1.0 if image is None or image.shape[2] == 3 else float(np.max(image[..., 3])) / 255
    return mesh.material.opacity * most > WHOLE
