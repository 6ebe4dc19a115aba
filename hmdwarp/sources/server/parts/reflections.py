"""Reflections: drawn into the picture, or a layer with the depth of the mirrored world."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl

from ....frames import EyeImage, Mirrored, Reflection, Surface
from ....gpu.shaders import Compute
from ....gpu.textures import COLOUR
from ....scenes import Scene
from ..mirror_drawing import (
    FACE_PIXELS,
    Ball,
    Bounds,
    MirroredPasses,
    MirrorSurface,
    Uniforms,
    bounds_in_view,
    bounds_of_all,
    uniforms_of,
)
from ..targets import Target
from . import parts
from ._base import DrawContext, Drawing, Part


@parts.register
class Reflections(Part):
    """Plane mirrors: the scene drawn again for each, mirrored.

    Curved ones: lookups in a cube map with depth around their centre.
    """

    name = "reflections"
    order = 10

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        shaders = context.gpu.shaders
        mirrors = context.scene.mirrors
        self._surfaces = [(Ball if mirror.shape.is_curved else MirrorSurface)(context, mirror) for mirror in mirrors]
        self._mirrored: MirroredPasses | None = None
        self._take = shaders.compute("server/mirror_take.comp")
        self._compose = shaders.compute("server/mirror_compose.comp")
        self._march: Compute | None = None

    @classmethod
    def in_scene(cls, scene: Scene) -> bool:
        return bool(scene.mirrors)

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        needed = drawing.needs.get("reflection", Mirrored(0))
        layered = [surface for surface in self._surfaces if _kind_of(surface) in needed]
        baked = [surface for surface in self._surfaces if surface not in layered]
        if baked:
            seen, surface = self.kept("seen", eye.size), self.kept("surface", eye.size, depth=False)
            self._draw(eye, baked, seen, surface, drawing.marched)
            self._compose_into(eye, baked, seen, surface)
        if not needed:
            return eye
        seen, surface = self.context.acquire(eye.size), self.context.acquire(eye.size, COLOUR, depth=False)
        self._draw(eye, layered, seen, surface, drawing.marched)
        shapes = tuple(surface.mirror.shape for surface in layered)
        bounds = bounds_of_all(shapes, eye.view, eye.size)
        mirrored = Surface(seen.colour, seen.inverse_depth)
        return eye.having(reflection=Reflection(mirrored, surface.colour, shapes, bounds))

    def _draw(
        self, eye: EyeImage, chosen: Sequence[MirrorSurface], seen: Target, surface: Target, marched: bool
    ) -> None:
        """Draw the reflections of the chosen mirrors, and the mirrors' properties."""
        over = self.context.framebuffers.over
        over(seen.colour).clear()
        over(seen.inverse_depth).clear(red=-1.0)
        onto = over(surface.colour)
        onto.clear(alpha=1.0)
        for mirrored in chosen:
            mirrored.draw_surface(eye, onto)
        mirrors = uniforms_of([surface.mirror for surface in chosen], eye.view, eye.size)
        # Plane mirrors come first and ignore balls: at the rim of a ball's triangles something else
        # shows.
        planes = mirrors | {"mirror_count": sum(not surface.mirror.shape.is_curved for surface in chosen)}
        for number, one in enumerate(chosen):
            if isinstance(one, Ball):
                side = FACE_PIXELS + 2
                around = self.kept(f"around {id(one)}", (3 * side, 2 * side))
                one.draw_image(eye, number, mirrors, over(seen.colour, seen.inverse_depth), around)
            elif (bounds := bounds_in_view(one.mirror.shape, eye.view, eye.size)) is not None:
                if marched:
                    self._march_through(eye, number, planes, bounds, seen)
                else:
                    self._draw_behind(eye, one, number, planes, bounds, seen)

    def _draw_behind(
        self, eye: EyeImage, one: MirrorSurface, number: int, mirrors: Uniforms, bounds: Bounds, seen: Target
    ) -> None:
        if self._mirrored is None:
            self._mirrored = MirroredPasses(self.context)
        behind = self.kept("behind", eye.size)
        framebuffer = self.context.framebuffers.over(behind.colour, behind.inverse_depth)
        self._mirrored.draw_behind(one.mirror.shape, eye.view, framebuffer, bounds, eye.drawn_ns)
        self._store(self._take, behind, number, mirrors, bounds, seen)

    def _march_through(self, eye: EyeImage, number: int, mirrors: Uniforms, bounds: Bounds, seen: Target) -> None:
        if self._march is None:
            self._march = self.context.gpu.shaders.compute("server/mirror_march.comp")
        self._store(self._march, Target(eye.colour, eye.inverse_depth), number, mirrors, bounds, seen)

    def _store(
        self, program: Compute, behind: Target, number: int, mirrors: Uniforms, bounds: Bounds, seen: Target
    ) -> None:
        """Write the reflection in mirror `number` into `seen`; `program` makes it from `behind`."""
        for unit, texture in enumerate((seen.colour, seen.inverse_depth)):
            texture.bind_to_image(unit, read=False, write=True)
        for unit, texture in enumerate((behind.colour, behind.inverse_depth), start=2):
            texture.bind_to_image(unit, read=True, write=False)
        units = {"seen_colour": 0, "seen_inverse_depth": 1, "behind_colour": 2, "behind_inverse_depth": 3}
        places = {"from": bounds[:2], "to": bounds[2:]}
        program.uniforms.set(taken=number, **units, **places, **mirrors)
        self._barrier()
        program.run(bounds[2] - bounds[0], bounds[3] - bounds[1])
        self._barrier()

    def _compose_into(self, eye: EyeImage, chosen: Sequence[MirrorSurface], seen: Target, surface: Target) -> None:
        eye.colour.bind_to_image(0, read=True, write=True)
        surface.colour.bind_to_image(1, read=True, write=False)
        seen.inverse_depth.bind_to_image(2, read=True, write=False)
        seen.colour.filter = (moderngl.LINEAR, moderngl.LINEAR)
        seen.colour.use(0)
        units = {"picture": 0, "surface": 1, "seen_inverse_depth": 2, "seen": 0}
        pixel = (1 / eye.size[0], 1 / eye.size[1])
        mirrors = uniforms_of([surface.mirror for surface in chosen], eye.view, eye.size)
        self._compose.uniforms.set(size=eye.size, seen_pixel=pixel, **units, **mirrors)
        self._barrier()
        self._compose.run(*eye.size)
        self._barrier()

    def _barrier(self) -> None:
        self.context.gpu.gl.memory_barrier(moderngl.ALL_BARRIER_BITS)

    def close(self) -> None:
        for surface in self._surfaces:
            surface.close()
        if self._mirrored is not None:
            self._mirrored.close()
        super().close()


def _kind_of(surface: MirrorSurface) -> Mirrored:
    return Mirrored.CURVED if surface.mirror.shape.is_curved else Mirrored.PLANE
