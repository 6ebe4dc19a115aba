"""The kind of gather warps that take everything to lie on one plane, at the median depth."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import moderngl

from .gather import GatherWarp

if TYPE_CHECKING:
    from ...gpu.textures import Canvas
    from ..inputs import PassInputs


class PlaneWarp(GatherWarp):
    """A gather whose shader reads the median inverse depth, which never leaves the GPU."""

    reads = ("rendered.colour", "rendered.inverse_depth")
    shader: ClassVar[str]

    def prepare(self) -> None:
        self._median = self.gpu.shaders.compute("warps/median.comp")
        self._gather = self.gather(self.shader)
        self._plane = self.gpu.gl.buffer(reserve=16)

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        self._plane.bind_to_storage_buffer(0)
        inputs.rendered.inverse_depth.use(1)
        self.set_sizes(self._median)
        self._median.uniforms.set(rendered_inverse_depth=1)
        self._median.run(1)
        self.gpu.gl.memory_barrier(moderngl.SHADER_STORAGE_BARRIER_BIT)
        self.bind_beside(self._gather, inputs)
        self.run_gather(self._gather, inputs, into, **self.own_uniforms(inputs))

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        """Return uniforms of this warp's shader alone."""
        return {}

    def close(self) -> None:
        super().close()
        self._plane.release()
