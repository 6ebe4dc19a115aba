"""What deforms, on the client: drawn without light at any instant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import attrs
import moderngl
import numpy as np

from ..gpu.scopes import drawing_into
from ..gpu.textures import release_all
from ..scenes import unlit
from ..sources.server import DeformingMesh, Framebuffers, SceneTextures, draw_moving

if TYPE_CHECKING:
    from ..geometry import View
    from ..gpu.context import Gpu
    from ..gpu.shaders import Draw
    from ..scenes import Scene


class ClientSoftBodies:
    """A client.SoftBodies of a scene; `scene` has what deforms alone, with its baked light."""

    def __init__(self, gpu: Gpu, scene: Scene) -> None:
        self._gpu = gpu
        self.scene = scene = _what_deforms(scene)
        bare = unlit(scene)
        self._textures = SceneTextures(gpu, bare)
        # Two of each, so that both eyes find what they draw as it was and as it is.
        self._then, self._now = (
            [DeformingMesh(gpu, bare, mesh, self._textures) for mesh in bare.meshes] for _ in range(2)
        )
        gl = gpu.gl
        self._baked = [gl.buffer(np.float32(mesh.light).tobytes()) for mesh in scene.meshes]
        self._past = [gl.buffer(reserve=12 * len(mesh.positions), dynamic=True) for mesh in scene.meshes]
        self._past_ns: int | None = None
        plain, late = (gpu.shaders.draw("effects/soft_body.vert", "effects/soft_body.frag", LATE=k) for k in (0, 1))
        self._plain, self._late = plain, late
        self._vertices = [one.buffers.vertex_array(gl, plain.program, colour=True) for one in self._then]
        self._vertices_late = [
            one.buffers.vertex_array(
                gl, late.program, (baked, "3f4", "in_baked"), (past, "3f4", "in_late"), colour=True
            )
            for one, baked, past in zip(self._now, self._baked, self._past, strict=True)
        ]
        self._framebuffers = Framebuffers(gl)

    def reserve(self, size: tuple[int, int]) -> None:
        """Allocate for pictures of that size, see SoftBodies.reserve."""
        self._framebuffers.reserve(size)

    def draw(self, view: View, time_ns: int, into: Sequence[moderngl.Texture]) -> None:
        """Draw albedo and inverse depth, see SoftBodies.draw."""
        self._draw(self._plain, self._then, self._vertices, view, time_ns, into)

    def draw_with_past(
        self, view: View, time_ns: int, into: Sequence[moderngl.Texture], past: View, past_ns: int
    ) -> None:
        """Draw it with where it was before, see SoftBodies.draw_with_past."""
        if past_ns != self._past_ns:
            for one, buffer in zip(self._now, self._past, strict=True):
                buffer.write(one.positions(past_ns).tobytes())
            self._past_ns = past_ns
        if self._now:
            self._late.uniforms.set(late_from_scene=self._now[0].place(past).eye_from_here)
        self._draw(self._late, self._now, self._vertices_late, view, time_ns, into)

    def _draw(
        self,
        program: Draw,
        bodies: Sequence[DeformingMesh],
        arrays: Sequence[moderngl.VertexArray],
        view: View,
        time_ns: int,
        into: Sequence[moderngl.Texture],
    ) -> None:
        framebuffer = self._framebuffers.over(*into)
        with drawing_into(framebuffer, moderngl.DEPTH_TEST):
            framebuffer.clear(-1.0, -1.0, -1.0, -1.0, depth=1.0)
            for one, vertices in zip(bodies, arrays, strict=True):
                draw_moving(self._gpu.gl, program, one, vertices, view, time_ns)

    def close(self) -> None:
        """Free its buffers; the shader library owns the programs."""
        release_all(*self._vertices, *self._vertices_late, *self._baked, *self._past)
        for one in (*self._then, *self._now):
            one.close()
        self._framebuffers.close()
        self._textures.close()


def _what_deforms(scene: Scene) -> Scene:
    """Return the scene with its deforming surfaces alone, and the textures that they have."""
    meshes = [mesh for mesh in scene.meshes if mesh.is_surface and mesh.deformation is not None]
    used = sorted({mesh.texture for mesh in meshes} - {-1})
    number = {-1: -1} | {texture: k for k, texture in enumerate(used)}
    textures = [scene.textures[texture] for texture in used]
    plain = [
        attrs.evolve(mesh, texture=number[mesh.texture], material=attrs.evolve(mesh.material, normal_map=-1))
        for mesh in meshes
    ]
    return attrs.evolve(scene, meshes=plain, textures=textures, lamps=())
