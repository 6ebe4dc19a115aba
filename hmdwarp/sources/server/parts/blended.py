"""Sheets (surfaces with holes, overlays, what light passes in part), what is occluded, light.

Occluded ones by depth peeling. Source: Everitt 2001, Interactive Order-Independent Transparency.
"""

from __future__ import annotations

from abc import abstractmethod

import moderngl

from ....frames import EyeImage, Surface, Transparent
from ....geometry import View
from ....gpu.shaders import Draw
from ....gpu.textures import drawing_into
from ....scenes import Mesh, Scene, is_cutout, only_light
from ..passes import SAME_SURFACE, ScenePasses
from ..upload import Moving, SceneBuffers, SceneTextures, moving_parts
from . import DrawContext, Drawing, Part, parts
from ._sheets import MOST, OVER, OVER_KEEPING_COVERAGE, THROUGH, Blending, Sheets

_TWO_DEPTHS = (2, "f4")  # rg32f


class SheetsPart(Part):
    """A part that draws the meshes it has as sheets."""

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._sheets = Sheets(context, [mesh for mesh in context.scene.meshes if self.has(context.scene, mesh)])

    @staticmethod
    @abstractmethod
    def has(scene: Scene, mesh: Mesh) -> bool:
        """Return whether a mesh of the scene is one of its sheets."""

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return any(cls.has(scene, mesh) for mesh in scene.meshes)

    def close(self) -> None:
        self._sheets.close()
        super().close()


@parts.register
class Cutouts(SheetsPart):
    """Drawn before all other parts, while the depth buffer is still that of the surfaces.

    As part of the veil, such a sheet seen through glass would move with the glass. Its edges are
    blended; their depth is that of the side that covers more.
    """

    name = "cutouts"
    order = 0

    @staticmethod
    def has(scene: Scene, mesh: Mesh) -> bool:
        return is_cutout(scene, mesh)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        program, over = self._sheets.colour(), self.context.framebuffers.over(eye.colour)
        self._sheets.draw(program, eye.view, eye.drawn_ns, over, OVER_KEEPING_COVERAGE, hidden_by_surfaces=True)
        self.add_depth(eye.view, eye.drawn_ns, eye.inverse_depth)
        return eye

    def add_depth(self, view: View, time_ns: int, into: moderngl.Texture) -> None:
        self._sheets.draw(self._sheets.program("cutout"), view, time_ns, self.context.framebuffers.over(into), None)


@parts.register
class Overlay(SheetsPart):
    """Drawn into the picture, it keeps the depth of what it covers."""

    name = "overlay"
    order = 95

    @staticmethod
    def has(scene: Scene, mesh: Mesh) -> bool:
        return mesh.material.head_locked

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


@parts.register
class Transparency(SheetsPart):
    """Blended into the picture, sheets keep the depth of what lies behind.

    As a layer, all sheets of a pixel are one veil at the depth of the nearest. A sheet that the
    picture occludes is left out where another is visible; elsewhere it is kept for when the head
    moves and uncovers it.
    """

    name = "transparency"
    order = 70

    @staticmethod
    def has(scene: Scene, mesh: Mesh) -> bool:
        return mesh.material.see_through and not is_cutout(scene, mesh)

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


@parts.register
class Peeled(Part):
    """Surfaces behind the picture's own, nearest first, without what the client moves."""

    name = "peeled"
    order = 100

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._passes: dict[tuple[ScenePasses, tuple[Moving, ...]], ScenePasses] = {}

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        plain = self.context.passes_for(drawing)
        moving = tuple(mover for mover in plain.moving if mover.layer not in drawing.needs)
        if (plain, moving) not in self._passes:
            self._passes[plain, moving] = plain.peeling(moving)
        passes = self._passes[plain, moving]
        before, surfaces = eye.inverse_depth, []
        for _ in range(drawing.needs["peeled"]):
            target = self.context.acquire(eye.size)
            before.use(1)
            into = self.context.framebuffers.over(target.colour, target.inverse_depth)
            passes.draw(eye.view, into, eye.drawn_ns, in_front=1, keep=1 - SAME_SURFACE)
            surfaces.append(Surface(target.colour, target.inverse_depth))
            before = target.inverse_depth
        return eye.having(peeled=tuple(surfaces))

    def close(self) -> None:
        for passes in self._passes.values():
            passes.close()


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
