"""The parts of a picture that have holes.

They are listed while the picture is copied; further passes run on them alone, by indirect dispatch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl
import numpy as np

from ...errors import InputError
from ...gpu.textures import tiles

if TYPE_CHECKING:
    from ...gpu.context import Gpu
    from ...gpu.shaders import Compute
    from ..shown_picture import ShownPicture

PIECE = (8, 4)  # pixels, as in shaders/lib/holes.glsl
_HEADER = np.array([0, 1, 1, 0], np.uint32).tobytes()  # three work-group counts, one count of pieces
_WARPED, _FILLED, _WARPED_DEPTH, _FILLED_DEPTH, _FILLED_TOO = range(5)  # image units


class HolePieces:
    """The list of pieces with holes of the newest picture; owns its buffers.

    with_depth: copies the inverse depth too. twice: copies the colour to a second texture as well.
    coarse: also lists the pieces of the picture at half the resolution that see a hole.
    """

    def __init__(
        self,
        gpu: Gpu,
        name: str,
        size: tuple[int, int],
        *,
        with_depth: bool = False,
        twice: bool = False,
        coarse: bool = False,
    ) -> None:
        self._gpu, self._size, self._stamp, self._with_depth = gpu, size, 0, with_depth
        parts = {"WITH_DEPTH": int(with_depth), "TWICE": int(twice), "COARSE": int(coarse)}
        self._program = gpu.shaders.compute("fills/holes.comp", **parts)
        self.count = _pieces_in(size)
        most = gpu.gl.info["GL_MAX_COMPUTE_WORK_GROUP_COUNT"][0]
        if self.count * PIECE[0] > 64 * most:
            raise InputError(
                f"a shown picture of {size[0]}x{size[1]} is beyond what fill '{name}' can do on this GPU: use a "
                "smaller one"
            )
        self.list = gpu.gl.buffer(reserve=len(_HEADER) + 4 * self.count)
        self._stamps = gpu.gl.buffer(bytes(8 * self.count))
        at_half = _pieces_in(tiles(size, 2))
        self._coarse = gpu.gl.buffer(reserve=len(_HEADER) + 4 * at_half) if coarse else None
        self._coarse_stamps = gpu.gl.buffer(bytes(4 * at_half)) if coarse else None

    def find(self, picture: ShownPicture, into: ShownPicture, too: moderngl.Texture | None = None) -> int:
        """Copy the picture and list its pieces with holes.

        Return the stamp that marks its pieces with covered pixels.
        """
        self._stamp = self._stamp % (2**32 - 1) + 1
        self.list.write(_HEADER)
        uniforms = {"warped": _WARPED, "filled": _FILLED, "shown_size": self._size, "stamp": self._stamp}
        _bind(picture.colour.texture, into.colour.texture, _WARPED)
        if self._with_depth and picture.inverse_depth is not None:
            _bind(picture.inverse_depth, into.depth, _WARPED_DEPTH)
            uniforms |= {"warped_depth": _WARPED_DEPTH, "filled_depth": _FILLED_DEPTH}
        if too is not None:
            too.bind_to_image(_FILLED_TOO, read=False, write=True)
            uniforms["filled_too"] = _FILLED_TOO
        self.list.bind_to_storage_buffer(0)
        self._stamps.bind_to_storage_buffer(1)
        if self._coarse is not None and self._coarse_stamps is not None:
            self._coarse.write(_HEADER)
            self._coarse.bind_to_storage_buffer(2)
            self._coarse_stamps.bind_to_storage_buffer(3)
        self._program.uniforms.set(**uniforms)
        self._program.run(*self._size)
        self._gpu.barrier()
        return self._stamp

    def run(self, program: Compute) -> None:
        """Run a program that includes lib/hole_columns.glsl over the listed pieces."""
        self.list.bind_to_storage_buffer(0)
        self._stamps.bind_to_storage_buffer(1)
        program.program.run_indirect(self.list)
        self._gpu.barrier()

    def run_coarse(self, program: Compute) -> None:
        """Run it over the pieces at half the resolution; its shown_size is that resolution."""
        assert self._coarse is not None
        self._coarse.bind_to_storage_buffer(0)
        program.program.run_indirect(self._coarse)
        self._gpu.barrier()

    def close(self) -> None:
        """Free the buffers."""
        for buffer in (self.list, self._stamps, self._coarse, self._coarse_stamps):
            if buffer is not None:
                buffer.release()


def _pieces_in(size: tuple[int, int]) -> int:
    return -(-size[0] // PIECE[0]) * -(-size[1] // PIECE[1])


def _bind(source: moderngl.Texture, into: moderngl.Texture, unit: int) -> None:
    source.bind_to_image(unit, read=True, write=False)
    into.bind_to_image(unit + 1, read=False, write=True)
