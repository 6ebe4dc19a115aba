"""Planar reprojection: everything on one plane, at the median depth of the rendered picture."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl

from ..warp_kinds import GatherWarp
from . import warps

if TYPE_CHECKING:
    from ...gpu.textures import Canvas
    from ..inputs import PassInputs


@warps.register
class Planar(GatherWarp):
    """A gather through the fronto-parallel plane at the median inverse depth."""

    name = "planar"
    summary = "turns and shifts the picture as one plane at its median depth"
    reads = ("rendered.colour", "rendered.inverse_depth")
    exact_when = "the eye only turns, or everything lies on one plane facing the eye"
    gets_wrong = "parallax: nearer things move too little, farther ones too much"
    source = (
        "XR_MSFT_composition_layer_reprojection, planar from depth; McMillan and Bishop 1995 for the plane's homography"
    )

    def prepare(self) -> None:
        self._median = self.gpu.shaders.compute("warps/median.comp")
        self._gather = self.gather("warps/planar.comp")
        self._plane = self.gpu.gl.buffer(reserve=16)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self._plane.bind_to_storage_buffer(0)
        inputs.rendered.inverse_depth.use(1)
        self.set_sizes(self._median)
        self._median.uniforms.set(rendered_inverse_depth=1)
        self._median.run(1)
        self.gpu.gl.memory_barrier(moderngl.SHADER_STORAGE_BARRIER_BIT)
        self.run_gather(self._gather, inputs, into)

    def close(self) -> None:
        self._plane.release()
