"""Planar reprojection: everything on one plane, at the median depth of the late picture."""

from __future__ import annotations

import moderngl

from ...frame import EyeImage
from ...geometry import View, WarpMap
from ...gpu.textures import Canvas
from . import warps
from ._base import Warp
from ._homography import bind_late_colour


@warps.register
class Planar(Warp):
    """A gather through the fronto-parallel plane at the median inverse depth, found on the GPU."""

    name = "planar"
    summary = "turns and shifts the picture as one plane at its median depth"
    kind = "gather"
    reads = ("late.colour", "late.inverse_depth")
    exact_when = "the eye only turns, or everything lies on one plane facing the eye"
    gets_wrong = "parallax: nearer things move too little, farther ones too much"
    source = "XR_MSFT_composition_layer_reprojection, planar from depth; McMillan and Bishop 1995 for the plane's homography"

    def prepare(self) -> None:
        self._median = self.gpu.shaders.compute("warps/median.comp")
        self._gather = self.gpu.shaders.compute("warps/planar.comp")
        self._plane = self.gpu.gl.buffer(reserve=16)

    def run(self, late: EyeImage, shown: View, into: Canvas, client_inverse_depth: moderngl.Texture | None = None) -> None:
        forward = WarpMap.between(late.view, self.late_size, shown, self.shown_size)
        gather, step = forward.gather_seed()
        self._plane.bind_to_storage_buffer(0)
        late.inverse_depth.use(1)
        self.set_sizes(self._median)
        self._median.uniforms.set(late_inverse_depth=1)
        self._median.run(1)
        self.gpu.gl.memory_barrier(moderngl.SHADER_STORAGE_BARRIER_BIT)
        bind_late_colour(late, 0, whole_pixels=forward.moves_whole_pixels())
        into.bind_for_writing()
        self.set_sizes(self._gather)
        self._gather.uniforms.set(H=gather, e=step, late_colour=0, shown_colour=0)
        self._gather.run(*self.shown_size)

    def close(self) -> None:
        self._plane.release()
