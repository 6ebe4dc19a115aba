"""Forward warping by points: every drawn pixel moves, the nearest wins."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import moderngl

from ...errors import InputError
from ...geometry import WarpMap
from . import warps
from ._base import COLOUR_BYTES, DEPTH_BYTES, KEY_BYTES, Warp

if TYPE_CHECKING:
    from ...gpu.textures import Canvas
    from ..given import Given

MOST_PIXELS = 2**27 - 2  # the keys of infinitely far pixels are indices below 2^27, see shaders/lib/scatter.glsl
_TIE_HEADER = 16  # bytes before the winners: three work-group counts and one spare


@warps.register
class Forward(Warp):
    """Scatters pixels with an exact depth test in two 32-bit atomic passes; equals go to the lower (row mod 4, column mod 4)."""

    name = "forward"
    summary = "moves each pixel by its own depth, nearest wins; leaves cracks and holes"
    kind = "scatter"
    reads = ("late.colour", "late.inverse_depth")
    exact_when = "the eye does not move; else each pixel is right to half a pixel"
    gets_wrong = "surfaces that come closer crack; what was hidden is a hole; soft edges travel with their depth"
    source = "the 2014 thesis's forward warp; atomics as in Schuetz et al. 2021 (arXiv 2104.07526)"

    def prepare(self) -> None:
        if self.late_size[0] * self.late_size[1] > MOST_PIXELS:
            raise InputError(f"a late picture of {self.late_size[0]}x{self.late_size[1]}: 'forward' takes at most {MOST_PIXELS} pixels")
        shaders, gl = self.gpu.shaders, self.gpu.gl
        self._clear = shaders.compute("warps/forward_clear.comp")
        self._nearest, self._colour, *self._settle = (shaders.compute("warps/forward.comp", PASS=k) for k in range(5))
        _check_key_buffer(gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"], self.shown_size)
        self._quads = -(-self.shown_size[0] * self.shown_size[1] // 4)
        self._keys = gl.buffer(reserve=16 * self._quads)
        self._ties = gl.buffer(bytes(_TIE_HEADER) + b"\xff" * (16 * self._quads))

    @classmethod
    def bytes_moved(cls, late_pixels: int, shown_pixels: int, settings: Any) -> int:
        """Each drawn pixel's depth twice and colour once; the shown keys cleared, raised (read, written) and read; the result cleared
        and written."""
        drawn = 2 * DEPTH_BYTES + COLOUR_BYTES
        return late_pixels * drawn + shown_pixels * (4 * KEY_BYTES + 2 * COLOUR_BYTES)

    def run(self, given: Given, into: Canvas) -> None:
        late = given.late
        forward = WarpMap.between(late.view, self.late_size, given.shown, self.shown_size)
        late.colour.bind_to_image(1, read=True, write=False)
        late.inverse_depth.bind_to_image(2, read=True, write=False)
        into.bind_for_writing()
        self._keys.bind_to_storage_buffer(0)
        self._ties.bind_to_storage_buffer(1)
        into.clear()
        groups = self._nearest.groups(*self.late_size)
        self._clear.uniforms.set(quads=self._quads, tie_dispatch=groups)
        self._clear.run(self._quads)
        for program in (self._nearest, self._colour, *self._settle):
            self.gpu.gl.memory_barrier(moderngl.ALL_BARRIER_BITS)
            self._set(program, forward)
            if program in self._settle:
                program.program.run_indirect(self._ties)
            else:
                program.program.run(*groups)

    def _set(self, program, forward: WarpMap) -> None:
        self.set_sizes(program)
        program.uniforms.set(H=forward.H, e=forward.e, late_colour=1, late_inverse_depth=2, shown_colour=0)

    def close(self) -> None:
        self._keys.release()
        self._ties.release()


def _check_key_buffer(limit_bytes: int, size: tuple[int, int]) -> None:
    pixels = (limit_bytes - _TIE_HEADER) // 16 * 4
    if size[0] * size[1] > pixels:
        raise InputError(f"a shown picture of {size[0]}x{size[1]}: 'forward' keeps 4 bytes a pixel, this GPU has room for {pixels} pixels")
