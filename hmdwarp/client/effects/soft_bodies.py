"""What deforms is drawn by the client as it is now, in the light of the late picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import attrs
import moderngl
import numpy as np

from ...frames import EyeImage
from ...geometry import View
from ...geometry.view import tangents_of_pixels
from ...gpu import Draw
from ...gpu.textures import COLOUR, SCALAR, Canvas, allocate, bind_images, drawing_into
from ...scenes import unlit
from ...sources.server import DeformingMesh, Framebuffers, SceneTextures, draw_moving
from ..client_scene import ClientScene, Store, whole_weight
from ..fills.model import MODEL_WEIGHT, NEAR, OFF_PLANE, BlockLights, RelightSettings
from ..inputs import PassInputs, ShownPicture
from . import effects
from ._base import ShownPass

PLACE = (4, "f4")
# Relative difference of inverse depth: coded depth is off by less, and a foot is within it of the
# ground only where the two meet.
SAME = 0.01
# Tangent of the angle from facing up to which neighbouring pixels are one surface: 80 degrees.
_STEEPEST = 5.7
_RELIGHT = RelightSettings()
_NOW = ("albedo", "body_inverse_depth", "lit", "late_place", "late_normal")  # what is drawn now, by the shader's names


class _DeformingBodies(Store):
    """What deforms in the scene, drawn without light into textures; -1 in all of them elsewhere."""

    def __init__(self, client: ClientScene, wanted: None) -> None:
        super().__init__(client, wanted)
        # Deforming surfaces alone with their baked light, and the textures that they have.
        meshes = [mesh for mesh in client.scene.meshes if mesh.is_surface and mesh.deformation is not None]
        used = sorted({mesh.texture for mesh in meshes} - {-1})
        number = {-1: -1} | {texture: k for k, texture in enumerate(used)}
        plain = [
            attrs.evolve(mesh, texture=number[mesh.texture], material=attrs.evolve(mesh.material, normal_map=-1))
            for mesh in meshes
        ]
        textures = [client.scene.textures[texture] for texture in used]
        self._scene = scene = attrs.evolve(client.scene, meshes=plain, textures=textures, lamps=())
        gpu = self._gpu = client.gpu
        bare, gl = unlit(scene), gpu.gl
        self._textures = self.own(SceneTextures(gpu, bare))
        # Two of each, so that both eyes find what they draw as it was and as it is.
        self._then, self._now = (
            [self.own(DeformingMesh(gpu, bare, mesh, self._textures)) for mesh in bare.meshes] for _ in range(2)
        )
        self._past = [self.own(gl.buffer(reserve=12 * len(mesh.positions), dynamic=True)) for mesh in scene.meshes]
        self._past_ns: int | None = None
        self._plain, self._late = (
            gpu.shaders.draw("effects/soft_body.vert", "effects/soft_body.frag", LATE=k) for k in (0, 1)
        )
        self._vertices = [
            self.own(body.buffers.vertex_array(gl, self._plain.program, colour=True)) for body in self._then
        ]
        self._vertices_late = []
        for mesh, body, past in zip(scene.meshes, self._now, self._past, strict=True):
            baked = self.own(gl.buffer(np.float32(mesh.light).tobytes()))
            more = (baked, "3f4", "in_baked"), (past, "3f4", "in_late")
            self._vertices_late.append(self.own(body.buffers.vertex_array(gl, self._late.program, *more, colour=True)))
        self._framebuffers = self.own(Framebuffers(gl))

    def reserve(self, size: tuple[int, int]) -> None:
        """Allocate what pictures of that size need."""
        self._framebuffers.reserve(size)

    def draw(self, view: View, time_ns: int, into: Sequence[moderngl.Texture]) -> None:
        """Draw albedo (rgba16f) and inverse depth (r32f) at that instant."""
        self._draw(self._plain, self._then, self._vertices, view, time_ns, into)

    def draw_with_past(
        self, view: View, time_ns: int, into: Sequence[moderngl.Texture], past: View, past_ns: int
    ) -> None:
        """Draw the same, and what shows where each place was for `past` at an earlier instant.

        into: albedo, inverse depth; colour in its baked light (rgba16f); the place then, in metres
        along the axes of the eye of `past` (rgba32f); the surface's normal there, away from the
        side that is seen now (rgba16f).
        """
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
                draw_moving(self._gpu.gl, program, one, vertices, view, time_ns, emitting=True)

    def weights(self) -> list[dict[str, Any]]:
        return [whole_weight(self._scene)]


class _SoftBodiesPass(ShownPass):
    """Take what deforms out of the rendered pictures; draw it into the shown one as it is now."""

    name = "soft bodies"
    takes_out = True
    carries = True  # the depth of what is shown; what samples a cube map would also show the late body
    reads = ("shown.colour", "shown.inverse_depth", "rendered.colour", "rendered.inverse_depth", "client.soft_bodies")
    writes = ("shown.colour", "shown.inverse_depth")

    def prepare(self) -> None:
        geometry, rendered = self.tools.geometry, self.rendered_size
        self._bodies = None if geometry is None else geometry.store(_DeformingBodies)
        self._take, self._light = (self.gpu.shaders.compute(f"effects/soft_{name}.comp") for name in ("take", "light"))
        self._then = self._allocated(rendered, COLOUR, SCALAR)
        self._now = self._allocated(self.shown_size, COLOUR, SCALAR, COLOUR, PLACE, COLOUR)
        self._left = [self._allocated(rendered, COLOUR, SCALAR) for _ in range(self.tools.images)]
        self._lights = self.own(BlockLights(self.gpu, rendered, _RELIGHT.samples, _RELIGHT.reach))
        if self._bodies is not None:
            self._bodies.reserve(rendered)
            self._bodies.reserve(self.shown_size)

    def _allocated(self, size: tuple[int, int], *kinds: tuple[int, str]) -> list[moderngl.Texture]:
        return [self.own(allocate(self.gpu.gl, size, kind)) for kind in kinds]

    def take_out(self, inputs: PassInputs) -> PassInputs:
        # The newest comes last: `_then` is read again when its light is found.
        free = iter(self._left)
        left = [self._without(image, next(free)) for image in reversed(inputs.images)]
        self._late = inputs.rendered
        return inputs.having(reversed(left))

    def _without(self, image: EyeImage, left: list[moderngl.Texture]) -> EyeImage:
        assert self._bodies is not None, "a plan that reads client.soft_bodies is for a client with geometry"
        self._bodies.draw(image.view, image.drawn_ns, self._then)
        self.gpu.barrier()
        read = {"rendered_colour": image.colour, "rendered_inverse_depth": image.inverse_depth}
        read["body_inverse_depth"] = self._then[1]
        units = bind_images(read, {"left_colour": left[0], "left_inverse_depth": left[1]})
        self._take.uniforms.set(rendered_size=image.size, same=SAME, **units)
        self._take.run(*image.size)
        self.gpu.barrier()
        return attrs.evolve(image, colour=left[0], inverse_depth=left[1])

    def run(self, inputs: PassInputs, picture: ShownPicture, into: Canvas) -> None:
        late = self._late
        self._lights.find(late.view, (late.colour, late.inverse_depth, *self._then))
        self.gpu.barrier()
        assert self._bodies is not None, "take_out() has run"
        self._bodies.draw_with_past(inputs.middle, inputs.shown_ns, self._now, late.view, late.drawn_ns)
        self.gpu.barrier()
        sampled = {"picture": picture.colour.texture, **dict(zip(_NOW, self._now, strict=True))}
        sampled |= {"late_colour": late.colour, "late_inverse_depth": late.inverse_depth}
        sampled |= dict(zip(("late_albedo", "late_body_inverse_depth"), self._then, strict=True))
        sampled |= {"lights": self._lights.texture}
        for unit, texture in enumerate(sampled.values()):
            texture.use(unit)
        units = bind_images(write={"written": into}, change={"shown_inverse_depth": picture.depth})
        units |= {name: unit for unit, name in enumerate(sampled)}
        self._lights.bind_samples()
        rays = tangents_of_pixels(late.view, late.size)
        units |= {"late_first": rays["tangent_start"], "late_pixel": rays["tangent_step"], "late_size": late.size}
        limits = {"same": SAME, "steepest": _STEEPEST * max(rays["tangent_step"]), "near": NEAR, "off_plane": OFF_PLANE}
        limits |= {"samples": _RELIGHT.samples, "model_weight": MODEL_WEIGHT["none"]}
        self._light.uniforms.set(shown_size=self.shown_size, **units, **limits)
        self._light.run(*self.shown_size)


effects.declare("soft_bodies", _SoftBodiesPass, applies=lambda _, mesh: mesh.deformation is not None)
