"""First guesses for gathers that search the rendered depth.

A forward splat of that depth at a quarter of the resolution, the nearest wins.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...errors import InputError
from ...geometry import WarpMap
from ...gpu.textures import tiles

if TYPE_CHECKING:
    from ...gpu.context import Gpu
    from ...gpu.shaders import Compute
    from ..inputs import PassInputs

BLOCK = 4  # pixels on each axis, rendered and shown; as in shaders/lib/seeds.glsl
BLOCK_BYTES, CELL_BYTES = 16, 4
MOST_INDEX_BITS = 27  # of a key's 32; five are the exponent of the depth


class Seeds:
    """The rendered inverse depths that the rays of each cell of 4x4 shown pixels meet first."""

    def __init__(self, gpu: Gpu, rendered_size: tuple[int, int], shown_size: tuple[int, int]) -> None:
        self._gpu, self._rendered_size, self._shown_size = gpu, rendered_size, shown_size
        self._index_bits = tuple((n - 1).bit_length() for n in rendered_size)
        self._blocks, self.cells = (tiles(size, BLOCK) for size in (rendered_size, shown_size))
        self._check_size()
        self._passes = tuple(gpu.shaders.compute("warps/iterative_seed.comp", PASS=k) for k in range(3))
        self._seeds = gpu.gl.buffer(reserve=CELL_BYTES * self.cells[0] * self.cells[1])
        self._nearest = gpu.gl.buffer(reserve=BLOCK_BYTES * self._blocks[0] * self._blocks[1])

    def find(self, inputs: PassInputs, surface: dict[str, object]) -> None:
        """Compute the guesses and leave them bound for the gather.

        surface: the uniforms of lib/rendered_surface.glsl; the rendered depth is bound.
        """
        shown = inputs.middle
        forward = WarpMap.between(inputs.rendered.view, self._rendered_size, shown, self._shown_size)
        back = WarpMap.between(shown, self._shown_size, inputs.rendered.view, self._rendered_size)
        self._seeds.bind_to_storage_buffer(0)
        self._nearest.bind_to_storage_buffer(1)
        both = tuple(max(pair) for pair in zip(self._blocks, self.cells, strict=True))
        grids = (both, self._blocks, self.cells)
        for program, grid, warp in zip(self._passes, grids, (forward, forward, back), strict=True):
            self._run(program, grid, warp, surface)
            self._gpu.barrier()

    def _run(self, program: Compute, grid: tuple[int, ...], warp: WarpMap, surface: dict[str, object]) -> None:
        sizes = {"grid": grid, "blocks": self._blocks, "cells": self.cells, "index_bits": self._index_bits}
        program.uniforms.set(H=warp.H, e=warp.e, **sizes, **surface)
        program.run(*grid)

    def _check_size(self) -> None:
        wide, high = self._rendered_size
        most = min(self._gpu.gl.info["GL_MAX_SHADER_STORAGE_BLOCK_SIZE"] // BLOCK_BYTES * BLOCK**2, 2**MOST_INDEX_BITS)
        if sum(self._index_bits) > MOST_INDEX_BITS or BLOCK**2 * self._blocks[0] * self._blocks[1] > most:
            raise InputError(
                f"a rendered picture of {wide}x{high}: the forward seed takes about {most} pixels at most; use "
                "seed=rotation"
            )

    def close(self) -> None:
        """Free the buffers."""
        self._seeds.release()
        self._nearest.release()
