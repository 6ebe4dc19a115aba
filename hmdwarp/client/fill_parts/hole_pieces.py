"""The parts of a picture that have holes.

They are listed while the picture is copied; further passes run on them alone, by indirect dispatch.
"""

from __future__ import annotations

from functools import partial

import moderngl
import numpy as np

from ...errors import InputError
from ...geometry import View, view_map
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import SCALAR, allocate, release_all, tiles
from ..inputs import ShownPicture
from ..warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE, DepthGuesses, DepthPicture, no_pieces, piece_list

PIECE = (8, 4)  # pixels, as in shaders/lib/holes.glsl
_HEADER = np.array([0, 1, 1, 0], np.uint32).tobytes()  # three work-group counts, one count of pieces
_WARPED, _FILLED, _WARPED_DEPTH, _FILLED_DEPTH = range(4)  # image units


class HolePieces:
    """The list of pieces with holes of the newest picture; owns its buffers.

    with_depth: copies the inverse depth too. coarse: also lists the pieces of the picture at half
    the resolution that see a hole.
    """

    def __init__(
        self,
        gpu: Gpu,
        name: str,
        size: tuple[int, int],
        *,
        with_depth: bool = False,
        coarse: bool = False,
    ) -> None:
        self._gpu, self._size, self._stamp, self._with_depth = gpu, size, 0, with_depth
        self._program = gpu.shaders.compute(
            "fills/holes.comp", grid="shown", WITH_DEPTH=int(with_depth), COARSE=int(coarse)
        )
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
        self._run_find = self._program.over(*size)

    def find(self, picture: ShownPicture, into: ShownPicture) -> int:
        """Copy the picture, and list its pieces with holes.

        Return the stamp that marks its pieces with covered pixels.
        """
        self._stamp = self._stamp % (2**32 - 1) + 1
        self.list.write(_HEADER)
        uniforms = {"warped": _WARPED, "filled": _FILLED, "shown_size": self._size, "stamp": self._stamp}
        picture.colour.texture.bind_to_image(_WARPED, read=True, write=False)
        into.colour.texture.bind_to_image(_FILLED, read=False, write=True)
        if self._with_depth and picture.inverse_depth is not None:
            picture.inverse_depth.bind_to_image(_WARPED_DEPTH, read=True, write=False)
            into.depth.bind_to_image(_FILLED_DEPTH, read=False, write=True)
            uniforms |= {"warped_depth": _WARPED_DEPTH, "filled_depth": _FILLED_DEPTH}
        self.list.bind_to_storage_buffer(0)
        self._stamps.bind_to_storage_buffer(1)
        if self._coarse is not None and self._coarse_stamps is not None:
            self._coarse.write(_HEADER)
            self._coarse.bind_to_storage_buffer(2)
            self._coarse_stamps.bind_to_storage_buffer(3)
        self._program.uniforms.set(**uniforms)
        self._run_find()
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


_RENDERED = 1  # texture unit
_SHOWN, _BEST_FILLED, _SHOWN_DEPTH, _BEST_FILLED_DEPTH, _BEST, _DEPTH = range(6)  # image units
_GUESSES = 3


class HoleFiller:
    """Intersect the rays of holes with one picture after the other.

    Of several hits the nearest stays; of equally near ones, the one sampled more densely. Nothing
    overrules the first picture if it is the newest.

    cell: side, in shown pixels, of the square that shares a guess: a texel of the guessing picture
    covers as much.
    """

    def __init__(self, gpu: Gpu, shown_size: tuple[int, int], cell: int = 1) -> None:
        self._gpu, self._size = gpu, shown_size
        self._cells = tiles(shown_size, cell)
        shaders, gl = gpu.shaders, gpu.gl
        self._start, self._gather = (
            shaders.compute("fills/memory_start.comp", grid="shown"),
            shaders.compute("fills/memory_gather.comp"),
        )
        self._run_start = self._start.over(*shown_size)
        self._guesses = DepthGuesses(gpu, self._cells)
        self._pieces, self._no_pieces = piece_list(gpu, "the fill", shown_size), no_pieces(gpu)
        self._best = allocate(gl, shown_size, (2, "f4"))
        # Bound where no pass reads depth: stores outside their one pixel are discarded.
        self._no_depth = [allocate(gl, (1, 1), SCALAR) for _ in range(2)]
        self._stamp = 0
        # Uniforms of every gather, but for what depends on the picture.
        self._fixed: dict[str, object] = {
            "shown_colour": _SHOWN,
            "filled_colour": _BEST_FILLED,
            "filled_depth": _BEST_FILLED_DEPTH,
            "best": _BEST,
            "rendered_colour": _RENDERED,
            "rendered_depth": _DEPTH,
            "shown_size": shown_size,
            "cells": self._cells,
            "cells_per_pixel": (self._cells[0] / shown_size[0], self._cells[1] / shown_size[1]),
            "depth_tolerance": DEPTH_TOLERANCE,
            "depth_floor": DEPTH_FLOOR,
            "guesses": _GUESSES,
        }

    def start(self, picture: ShownPicture, into: ShownPicture) -> None:
        """Copy a picture; pictures added from now on go into its holes."""
        self._stamp = self._stamp % 0xFFFFFFFF + 1
        self._first = True
        self._guesses.empty(self._pieces)
        before, after = self._no_depth
        if picture.inverse_depth is not None and into.inverse_depth is not None:
            before, after = picture.inverse_depth, into.inverse_depth
        self._bind = (
            partial(picture.colour.texture.bind_to_image, _SHOWN, read=True, write=False),
            partial(before.bind_to_image, _SHOWN_DEPTH, read=True, write=False),
            partial(into.colour.bind_for_writing, _BEST_FILLED),
            partial(after.bind_to_image, _BEST_FILLED_DEPTH, read=False, write=True),
        )
        for bind in self._bind:
            bind()
        units = {"shown_colour": _SHOWN, "filled_colour": _BEST_FILLED, "filled_depth": _BEST_FILLED_DEPTH}
        self._start.uniforms.set(stamp=self._stamp, shown_depth=_SHOWN_DEPTH, shown_size=self._size, **units)
        self._gpu.barrier()
        self._run_start()

    def add(
        self, found: DepthPicture, shown: View, *, seeds: moderngl.Texture | None = None, newest: bool = False
    ) -> None:
        """Fill the remaining holes from `found`.

        seeds: its inverse depth at a lower resolution, for the guesses. newest: whether it is the
        newest rendered picture.
        """
        if not self._first:
            self._guesses.empty(self._no_pieces)
        depth = found.inverse_depth if seeds is None else seeds
        self._guesses.scatter(depth, found.view, shown, _DEPTH)
        size = found.colour.size
        back = view_map(shown, self._size, found.view, size)
        found.inverse_depth.bind_to_image(_DEPTH, read=True, write=False)
        found.colour.filter = (moderngl.LINEAR, moderngl.LINEAR)
        found.colour.use(_RENDERED)
        for bind in self._bind:
            bind()
        self._best.bind_to_image(_BEST, read=True, write=True)
        self._pieces.bind_to_storage_buffer(1)
        self._gather.uniforms.set(
            H=back.H,
            e=back.e,
            is_first=self._first,
            is_newest=newest,
            rendered_size=size,
            rendered_pixel=(1 / size[0], 1 / size[1]),
            **self._fixed,
        )
        self._gpu.barrier()
        self._gather.program.run_indirect(self._pieces)
        self._first = False

    def close(self) -> None:
        """Free the textures and buffers."""
        self._guesses.close()
        release_all(self._pieces, self._no_pieces, self._best, *self._no_depth)
