"""Motion layers: bodies and their motion, and the velocity of each deforming pixel."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np

from ....frames import BodyIds, EyeImage
from ....gpu.textures import COLOUR, NUMBER, drawing_into
from ...array_passes import Owner
from ..passes import SAME_SURFACE, DeformingMesh, Moving, MovingBody, draw_moving
from . import DrawContext, Drawing, Part, parts


@parts.register
class Motion(Part):
    """Drawn after everything that goes into the picture: the depth says what a pixel shows."""

    name = "motion"
    order = 90

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        self._made: dict[str, _Shown] = {}

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        for name, kind in (("ids", MovingBody), ("velocity", DeformingMesh)):
            if name in drawing.needs and name not in self._made:
                moving = [one for one in self.context.colour.moving if isinstance(one, kind)]
                self._made[name] = self.own(_Shown(self.context, moving, velocity=name == "velocity"))
        if "ids" in drawing.needs:
            bodies = tuple(body.motion.state(drawing.time_ns) for body in self.context.scene.bodies)
            eye = eye.having(ids=BodyIds(self._made["ids"].draw(eye), bodies))
        return eye.having(velocity=self._made["velocity"].draw(eye)) if "velocity" in drawing.needs else eye


class _Shown(Owner):
    """Draws body numbers (r16ui) or velocities (rgba16f) where the picture shows what moves."""

    def __init__(self, context: DrawContext, moving: Sequence[Moving], *, velocity: bool) -> None:
        self._context, self._moving, self._is_velocity = context, moving, velocity
        shaders, gl = context.gpu.shaders, context.gpu.gl
        self._draw = shaders.draw("server/moving.vert", "server/moving.frag", VELOCITY=int(velocity))
        none = shaders.draw("server/background.vert", "server/moving_none.frag")
        self._empty = self.own(gl.vertex_array(none.program, []))
        deforming = [one for one in moving if velocity and isinstance(one, DeformingMesh)]
        sizes = {one: 12 * len(one.mesh.positions) for one in deforming}
        self._velocities = {one: self.own(gl.buffer(reserve=size, dynamic=True)) for one, size in sizes.items()}
        self._vertices = []
        for one in moving:
            more = [(self._velocities[one], "3f4", "in_velocity")] if one in self._velocities else []
            self._vertices.append(self.own(one.buffers.vertex_array(gl, self._draw.program, *more, colour=False)))
        self._written_ns: int | None = None

    def draw(self, eye: EyeImage) -> moderngl.Texture:
        gl, time_ns = self._context.gpu.gl, eye.drawn_ns
        into = self._context.acquire(eye.size, COLOUR if self._is_velocity else NUMBER, depth=False).colour
        framebuffer = self._context.framebuffers.over(into)
        if time_ns != self._written_ns:
            for deforming, buffer in self._velocities.items():
                deforming.set_time(time_ns)
                buffer.write(np.ascontiguousarray(deforming.velocities()).tobytes())
            self._written_ns = time_ns
        if self._is_velocity:
            self._draw.uniforms.set(eye_from_world=eye.view.pose.rotation_matrix.T)
        with drawing_into(framebuffer, moderngl.NOTHING):
            if self._is_velocity:
                framebuffer.clear()
            else:
                self._empty.render(moderngl.TRIANGLES, vertices=3)
            for one, vertices in zip(self._moving, self._vertices, strict=True):
                if isinstance(one, MovingBody):
                    self._draw.uniforms.set(body=one.number)
                # In any order: of two surfaces, only one has the picture's depth.
                eye.inverse_depth.use(0)
                self._draw.uniforms.set(picture=0, same=SAME_SURFACE)
                draw_moving(gl, self._draw, one, vertices, eye.view, time_ns, textured=False)
        return into
