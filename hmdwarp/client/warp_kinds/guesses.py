"""First guesses for gathers from pictures with depth, and the list of pieces still to process."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import moderngl

from ...errors import InputError
from ...geometry import View, view_map
from ...gpu.context import Gpu
from ...gpu.textures import release_all, tiles
from ..inputs import PassInputs
from ..warps import KEY_BYTES

PIECE_ROWS = 4
# Pixels of a piece (lib/hole_pieces.glsl) and invocations of a work group (lib/rows.glsl).
_PIECE, _GROUP = 8, 64
_HEADER_BYTES = 16  # of a list: three work-group counts and one count of pieces


class DepthGuesses:
    """The nearest inverse depth that lands in each cell of the shown picture."""

    def __init__(self, gpu: Gpu, cells: tuple[int, int]) -> None:
        self._gpu, self._cells = gpu, cells
        self._empty = gpu.shaders.compute("warps/layered_empty.comp")
        self._seed = gpu.shaders.compute("warps/layered_seed.comp")
        self._quads = -(-cells[0] * cells[1] // 4)
        self._keys = gpu.gl.buffer(reserve=4 * KEY_BYTES * self._quads)
        self._run_empty = self._empty.over(self._quads)
        self._run_seed: dict[tuple[int, int], Callable[[], object]] = {}  # by the size of what is moved

    def empty(self, pieces: moderngl.Buffer) -> None:
        """Clear all guesses and the list; both stay bound."""
        self._keys.bind_to_storage_buffer(0)
        pieces.bind_to_storage_buffer(1)
        self._empty.uniforms.set(quads=self._quads)
        self._gpu.barrier()
        self._run_empty()

    def scatter(self, inverse_depth: moderngl.Texture, view: View, shown: View, unit: int) -> None:
        """Move an inverse depth rendered for `view` to the shown view.

        It stays bound as image `unit`.
        """
        size = inverse_depth.size
        forward = view_map(view, size, shown, self._cells)
        inverse_depth.bind_to_image(unit, read=True, write=False)
        self._keys.bind_to_storage_buffer(0)
        sizes = {"rendered_size": size, "shown_size": self._cells}
        self._seed.uniforms.set(H=forward.H, e=forward.e, rendered_inverse_depth=unit, **sizes)
        if size not in self._run_seed:
            self._run_seed[size] = self._seed.over(*size)
        self._gpu.barrier()
        self._run_seed[size]()

    def close(self) -> None:
        """Free the guesses."""
        self._keys.release()


def piece_list(gpu: Gpu, user: str, shown_size: tuple[int, int]) -> moderngl.Buffer:
    """Return an empty list with room for every piece of the shown picture.

    user: for the message. Errors: InputError where the indirect dispatch over all pieces would
    exceed the GL limit, and be dropped silently.
    """
    pieces = -(-shown_size[0] // _PIECE) * -(-shown_size[1] // PIECE_ROWS)
    most = gpu.gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][0]
    if -(-pieces * _PIECE // _GROUP) > most:
        wide, high = shown_size
        found = f"a shown picture of {wide}x{high}: {user} would need more than this GPU's {most} work groups"
        raise InputError(f"{found}; use a smaller one")
    return gpu.gl.buffer(bytes(_HEADER_BYTES + 8 * pieces))


def no_pieces(gpu: Gpu) -> moderngl.Buffer:
    """Return a list of zero capacity, for guesses whose pieces are listed elsewhere."""
    return gpu.gl.buffer(bytes(_HEADER_BYTES))


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
        compute = partial(gpu.shaders.compute, "warps/iterative_seed.comp")
        # The last one visits every cell, whose key may be of the other eye.
        programs = compute(grid="rendered", PASS=0), compute(grid="rendered", PASS=1), compute(PASS=2)
        sizes = {"blocks": self._blocks, "cells": self.cells, "index_bits": self._index_bits}
        grids = (rendered_size, self._blocks), (rendered_size, self._blocks), (shown_size, self.cells)
        self._passes = [
            (program, program.over(*size, BLOCK), {"grid": grid, **sizes})
            for program, (size, grid) in zip(programs, grids, strict=True)
        ]
        self._seeds, self._keys = (gpu.gl.buffer(bytes(CELL_BYTES * self.cells[0] * self.cells[1])) for _ in range(2))
        self._nearest = gpu.gl.buffer(reserve=BLOCK_BYTES * self._blocks[0] * self._blocks[1])

    def find(self, inputs: PassInputs, surface: dict[str, object]) -> None:
        """Compute the guesses and leave them bound for the gather.

        surface: the uniforms of lib/rendered_surface.glsl; the rendered depth is bound.
        """
        shown = inputs.middle
        forward = view_map(inputs.rendered.view, self._rendered_size, shown, self._shown_size)
        back = view_map(shown, self._shown_size, inputs.rendered.view, self._rendered_size)
        for binding, buffer in enumerate((self._seeds, self._nearest, self._keys)):
            buffer.bind_to_storage_buffer(binding)
        for (program, run, sizes), warp in zip(self._passes, (forward, forward, back), strict=True):
            program.uniforms.set(H=warp.H, e=warp.e, **sizes, **surface)
            run()
            self._gpu.barrier()

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
        release_all(self._seeds, self._nearest, self._keys)
