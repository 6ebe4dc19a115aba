"""Motion layers: bodies and their motion, and the velocity of each deforming pixel."""

from __future__ import annotations

import moderngl
import numpy as np

from ....frames import BodyIds, EyeImage
from ....gpu.shaders import Draw
from ....gpu.textures import COLOUR, NUMBER, drawing_into
from ..passes import SAME_SURFACE, draw_moving
from ..upload import DeformingMesh, Moving, MovingBody
from . import DrawContext, Drawing, Part, parts


@parts.register
class Motion(Part):
    """Drawn after everything that goes into the picture: the depth says what a pixel shows."""

    name = "motion"
    order = 90

    def __init__(self, context: DrawContext) -> None:
        super().__init__(context)
        moving = context.colour.moving
        self._bodies = tuple(body for body in moving if isinstance(body, MovingBody))
        self._deforming = tuple(body for body in moving if isinstance(body, DeformingMesh))
        self._of_bodies: _Numbers | None = None
        self._of_deforming: _Velocities | None = None

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        if "ids" in drawing.needs:
            if self._of_bodies is None:
                self._of_bodies = _Numbers(self.context, self._bodies)
            bodies = tuple(body.motion.state(drawing.time_ns) for body in self.context.scene.bodies)
            eye = eye.having(ids=BodyIds(self._of_bodies.draw(eye), bodies))
        if "velocity" in drawing.needs:
            if self._of_deforming is None:
                self._of_deforming = _Velocities(self.context, self._deforming)
            eye = eye.having(velocity=self._of_deforming.draw(eye))
        return eye

    def close(self) -> None:
        for velocities in (self._of_bodies, self._of_deforming):
            if velocities is not None:
                velocities.close()


class _Numbers:
    def __init__(self, context: DrawContext, bodies: tuple[MovingBody, ...]) -> None:
        self._context, self._bodies = context, bodies
        shaders, gl = context.gpu.shaders, context.gpu.gl
        self._draw = shaders.draw("server/moving.vert", "server/moving.frag", VELOCITY=0)
        self._none = shaders.draw("server/background.vert", "server/moving_none.frag")
        self._vertices = [body.buffers.vertex_array(gl, self._draw.program, colour=False) for body in bodies]
        self._empty = gl.vertex_array(self._none.program, [])

    def draw(self, eye: EyeImage) -> moderngl.Texture:
        """Return the numbers: r16ui of the eye's size."""
        gl = self._context.gpu.gl
        into = self._context.acquire(eye.size, NUMBER, depth=False).colour
        framebuffer = self._context.framebuffers.over(into)
        with drawing_into(framebuffer, moderngl.NOTHING):
            self._empty.render(moderngl.TRIANGLES, vertices=3)
            for one, vertices in zip(self._bodies, self._vertices, strict=True):
                self._draw.uniforms.set(body=one.number)
                _draw_where_shown(gl, self._draw, one, vertices, eye)
        return into

    def close(self) -> None:
        for vertices in (*self._vertices, self._empty):
            vertices.release()


class _Velocities:
    def __init__(self, context: DrawContext, deforming: tuple[DeformingMesh, ...]) -> None:
        self._context, self._deforming = context, deforming
        gl = context.gpu.gl
        self._draw = context.gpu.shaders.draw("server/moving.vert", "server/moving.frag", VELOCITY=1)
        self._velocities = [gl.buffer(reserve=12 * len(mesh.mesh.positions), dynamic=True) for mesh in deforming]
        self._vertices = [
            one.buffers.vertex_array(gl, self._draw.program, (buffer, "3f4", "in_velocity"), colour=False)
            for one, buffer in zip(deforming, self._velocities, strict=True)
        ]
        self._written_ns: int | None = None

    def draw(self, eye: EyeImage) -> moderngl.Texture:
        """Return the velocities: rgba16f of the eye's size."""
        gl = self._context.gpu.gl
        into = self._context.acquire(eye.size, COLOUR, depth=False).colour
        framebuffer = self._context.framebuffers.over(into)
        if eye.drawn_ns != self._written_ns:
            for one, buffer in zip(self._deforming, self._velocities, strict=True):
                one.set_time(eye.drawn_ns)
                buffer.write(np.ascontiguousarray(one.velocities()).tobytes())
            self._written_ns = eye.drawn_ns
        self._draw.uniforms.set(eye_from_world=eye.view.pose.rotation_matrix.T)
        with drawing_into(framebuffer, moderngl.NOTHING):
            framebuffer.clear()
            for one, vertices in zip(self._deforming, self._vertices, strict=True):
                _draw_where_shown(gl, self._draw, one, vertices, eye)
        return into

    def close(self) -> None:
        for vertices, buffer in zip(self._vertices, self._velocities, strict=True):
            vertices.release()
            buffer.release()


def _draw_where_shown(
    gl: moderngl.Context, draw: Draw, one: Moving, vertices: moderngl.VertexArray, eye: EyeImage
) -> None:
    """Draw where the picture shows the surface; in any order, as one alone has its depth."""
    eye.inverse_depth.use(0)
    draw.uniforms.set(picture=0, same=SAME_SURFACE)
    draw_moving(gl, draw, one, vertices, eye.view, eye.drawn_ns, textured=False)
