"""Transparent sheets: blended over the picture, or a veil with a depth of its own."""

from __future__ import annotations

import moderngl

from ....frames import EyeImage, Surface, Transparent
from ....gpu.shaders import Draw
from ....gpu.textures import drawing_into
from ....scenes import Scene, is_cutout
from ..passes import SAME_SURFACE
from . import DrawContext, Drawing, Part, parts
from ._sheets import MOST, OVER_KEEPING_COVERAGE, THROUGH, Blending, Sheets

_TWO_DEPTHS = (2, "f4")  # rg32f


@parts.register
class Transparency(Part):
    """Blended into the picture, sheets keep the depth of what lies behind.

    As a layer, all sheets of a pixel are one veil at the depth of the nearest. A sheet that the
    picture occludes is left out where another is visible; elsewhere it is kept for when the head
    moves and uncovers it.
    """

    name = "transparency"
    order = 70

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        scene = context.scene
        self._sheets = Sheets(
            context, [mesh for mesh in scene.meshes if mesh.material.see_through and not is_cutout(scene, mesh)]
        )

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return any(mesh.material.see_through for mesh in scene.meshes)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if "transparent" in drawing.needs:
            return eye.having(transparent=self._layer(eye))
        eye.inverse_depth.use(1)
        self._sheets.draw(
            self._colour(1), eye.view, eye.drawn_ns, self.context.framebuffers.over(eye.colour), OVER_KEEPING_COVERAGE
        )
        return eye

    def _layer(self, eye: EyeImage) -> Transparent:
        veil, passing = self.context.acquire(eye.size), self.context.acquire(eye.size, depth=False).colour
        nearest = self.kept("nearest", eye.size, _TWO_DEPTHS, depth=False).colour
        self._draw(self._tested(self._sheets.program(TESTS=1, COLOUR=0), 1), eye, nearest, (-1.0, -1.0, 0.0, 0.0), MOST)
        # Write the depth of the nearest sheet that is not hidden, else of the nearest of all.
        nearest.bind_to_image(0, read=True, write=False)
        veil.inverse_depth.bind_to_image(1, read=False, write=True)
        program = self.context.gpu.shaders.compute("server/veil_depth.comp")
        program.uniforms.set(nearest=0, inverse_depth=1)
        program.run(*veil.inverse_depth.size)
        self.context.gpu.barrier()
        nearest.use(2)
        for into, through, blending in ((veil.colour, 0.0, OVER_KEEPING_COVERAGE), (passing, 1.0, THROUGH)):
            self._draw(self._colour(2), eye, into, (through, through, through, 0.0), blending)
        return Transparent(Surface(veil.colour, veil.inverse_depth), passing)

    def _draw(
        self,
        program: Draw,
        eye: EyeImage,
        into: moderngl.Texture,
        empty: tuple[float, float, float, float],
        blending: Blending,
    ) -> None:
        framebuffer = self.context.framebuffers.over(into)
        with drawing_into(framebuffer):
            framebuffer.clear(color=empty)
        eye.inverse_depth.use(1)
        self._sheets.draw(program, eye.view, eye.drawn_ns, framebuffer, blending)

    def _colour(self, tests: int) -> Draw:
        return self._tested(self._sheets.colour(tests=tests), tests)

    def _tested(self, program: Draw, tests: int) -> Draw:
        program.uniforms.set(picture=1, keep=1 - SAME_SURFACE, **({"nearest": 2} if tests == 2 else {}))
        return program

    def close(self) -> None:
        self._sheets.close()
        super().close()
