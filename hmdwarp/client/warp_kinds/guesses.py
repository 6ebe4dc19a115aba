"""First guesses for gathers from pictures with depth, and the list of pieces still to process."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl

from ...errors import InputError
from ...geometry import View, WarpMap
from ..warps import KEY_BYTES

if TYPE_CHECKING:
    from ...gpu.context import Gpu

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

    def empty(self, pieces: moderngl.Buffer) -> None:
        """Clear all guesses and the list; both stay bound."""
        self._keys.bind_to_storage_buffer(0)
        pieces.bind_to_storage_buffer(1)
        self._empty.uniforms.set(quads=self._quads)
        self._gpu.barrier()
        self._empty.run(self._quads)

    def scatter(self, inverse_depth: moderngl.Texture, view: View, shown: View, unit: int) -> None:
        """Move an inverse depth rendered for `view` to the shown view.

        It stays bound as image `unit`.
        """
        forward = WarpMap.between(view, inverse_depth.size, shown, self._cells)
        inverse_depth.bind_to_image(unit, read=True, write=False)
        self._keys.bind_to_storage_buffer(0)
        sizes = {"rendered_size": inverse_depth.size, "shown_size": self._cells}
        self._seed.uniforms.set(H=forward.H, e=forward.e, rendered_inverse_depth=unit, **sizes)
        self._gpu.barrier()
        self._seed.run(*inverse_depth.size)

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
