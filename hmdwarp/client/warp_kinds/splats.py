"""Light that is splatted at low resolution, for what is drawn with it at full resolution."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl
import numpy as np

from ...gpu.scopes import drawing_into
from ...gpu.textures import SCALAR, Canvas, allocate, release_all
from ..shown_picture import ShownPicture

if TYPE_CHECKING:
    from ...geometry import View
    from ...gpu.context import Gpu
    from ...gpu.shaders import Uniforms
    from ..client_geometry import ReceivedPhotons

_LIGHT = (4, "f4")  # rgba32f: sums of thousands of photons


class Splats:
    """Photons splatted at a part of the shown resolution, by deferred shading.

    Each pixel gets the light of all photons within `radius` metres of what it shows, on about the
    same plane; see shaders/warps/photons.frag.
    """

    def __init__(self, gpu: Gpu, photons: ReceivedPhotons, size: tuple[int, int], scale: int, radius: float) -> None:
        """Compile the programs and allocate the buffers. size: of the shown picture."""
        gl = self._gl = gpu.gl
        self._photons, self._radius, self._size = photons, radius, size
        low = (-(-size[0] // scale), -(-size[1] // scale))
        self._receivers = ShownPicture(Canvas(gl, low), allocate(gl, low, SCALAR))
        self.light = allocate(gl, low, _LIGHT)
        self._framebuffer = gl.framebuffer([self.light])
        self._program = gpu.shaders.draw("warps/photons.vert", "warps/photons.frag")
        self._vertices = gl.vertex_array(self._program.program, [(photons.photons, "3u4/i", "in_photon")])
        self._view: dict[str, object] = {}

    def draw(self, view: View, time_ns: int) -> None:
        """Splat all photons for a view."""
        photons = self._photons
        left, right, down, up = view.fov.tangents
        self._view = {
            "eye": tuple((view.pose.position_m - photons.origin_m).tolist()),
            "scene_from_eye": view.pose.rotation_matrix,
            "low_tangents": (left, down, right, up),
            "radius": self._radius,
        }
        self._framebuffer.clear()
        if not photons.count:
            return
        photons.scene.draw_receivers(view, self._receivers, time_ns)
        self._bind(self._program.uniforms, 0)
        self._program.uniforms.set(low=tuple(photons.cube.low.tolist()), edge=photons.cube.edge)
        with drawing_into(self._framebuffer, moderngl.BLEND):
            self._gl.blend_func = (moderngl.ONE, moderngl.ONE)
            self._vertices.render(moderngl.TRIANGLE_STRIP, vertices=4, instances=photons.count)
            self._gl.blend_func = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA)

    def use(self, uniforms: Uniforms, unit: int) -> None:
        """Bind what shaders/lib/splatted.glsl reads, from that texture unit on."""
        self._bind(uniforms, unit)
        self.light.use(unit + 2)
        shares = tuple((np.array(self.light.size) / self._size).tolist())
        uniforms.set(splatted=unit + 2, low_per_pixel=shares)

    def _bind(self, uniforms: Uniforms, unit: int) -> None:
        self._receivers.colour.texture.use(unit)
        self._receivers.depth.use(unit + 1)
        uniforms.set(receivers=unit, receiver_depth=unit + 1, **self._view)

    def close(self) -> None:
        """Free the buffers; the shader library owns the programs."""
        self._receivers.colour.release()
        release_all(self._receivers.depth, self._vertices, self._framebuffer, self.light)
