"""Fill holes from other pictures with depth; only the rays of empty pixels are traced."""

from __future__ import annotations

from typing import TYPE_CHECKING

import moderngl

from ...geometry import View, WarpMap
from ...gpu.textures import SCALAR, allocate, release_all, tiles
from ..warp_kinds import DEPTH_FLOOR, DEPTH_TOLERANCE, DepthGuesses, DepthPicture, no_pieces, piece_list

if TYPE_CHECKING:
    from ...gpu.context import Gpu
    from ..shown_picture import ShownPicture

_RENDERED = 1  # texture unit
_SHOWN, _FILLED, _SHOWN_DEPTH, _FILLED_DEPTH, _BEST, _DEPTH = range(6)  # image units
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
            shaders.compute("fills/memory_start.comp"),
            shaders.compute("fills/memory_gather.comp"),
        )
        self._guesses = DepthGuesses(gpu, self._cells)
        self._pieces, self._no_pieces = piece_list(gpu, "the fill", shown_size), no_pieces(gpu)
        self._best = allocate(gl, shown_size, (2, "f4"))
        # Bound where no pass reads depth: stores outside their one pixel are discarded.
        self._no_depth = [allocate(gl, (1, 1), SCALAR) for _ in range(2)]
        self._stamp = 0

    def start(self, picture: ShownPicture, into: ShownPicture) -> None:
        """Copy the picture; pictures added from now on go into its holes."""
        self._stamp = self._stamp % 0xFFFFFFFF + 1
        self._first = True
        self._guesses.empty(self._pieces)
        self._bind(picture, into)
        units = {
            "shown_colour": _SHOWN,
            "filled_colour": _FILLED,
            "shown_depth": _SHOWN_DEPTH,
            "filled_depth": _FILLED_DEPTH,
        }
        self._start.uniforms.set(stamp=self._stamp, shown_size=self._size, **units)
        self._gpu.barrier()
        self._start.run(*self._size)
        self._picture, self._into = picture, into

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
        self._meet(found, shown, newest)
        self._first = False

    def _meet(self, found: DepthPicture, shown: View, newest: bool) -> None:
        size = found.colour.size
        back = WarpMap.between(shown, self._size, found.view, size)
        found.inverse_depth.bind_to_image(_DEPTH, read=True, write=False)
        found.colour.filter = (moderngl.LINEAR, moderngl.LINEAR)
        found.colour.use(_RENDERED)
        self._bind(self._picture, self._into)
        self._best.bind_to_image(_BEST, read=True, write=True)
        self._pieces.bind_to_storage_buffer(1)
        units = {"shown_colour": _SHOWN, "filled_colour": _FILLED, "filled_depth": _FILLED_DEPTH, "best": _BEST}
        units |= {"rendered_colour": _RENDERED, "rendered_depth": _DEPTH}
        sizes = {
            "rendered_size": size,
            "rendered_pixel": (1 / size[0], 1 / size[1]),
            "shown_size": self._size,
            "cells": self._cells,
        }
        sizes["cells_per_pixel"] = tuple(c / s for c, s in zip(self._cells, self._size, strict=True))
        limits = {"depth_tolerance": DEPTH_TOLERANCE, "depth_floor": DEPTH_FLOOR, "guesses": _GUESSES, "once": 1}
        self._gather.uniforms.set(
            H=back.H, e=back.e, is_first=self._first, is_newest=newest, **units, **sizes, **limits
        )
        self._gpu.barrier()
        self._gather.program.run_indirect(self._pieces)

    def _bind(self, picture: ShownPicture, into: ShownPicture) -> None:
        before, after = self._no_depth
        if picture.inverse_depth is not None and into.inverse_depth is not None:
            before, after = picture.inverse_depth, into.inverse_depth
        picture.colour.texture.bind_to_image(_SHOWN, read=True, write=False)
        into.colour.bind_for_writing(_FILLED)
        before.bind_to_image(_SHOWN_DEPTH, read=True, write=False)
        after.bind_to_image(_FILLED_DEPTH, read=False, write=True)

    def close(self) -> None:
        """Free the textures and buffers."""
        self._guesses.close()
        release_all(self._pieces, self._no_pieces, self._best, *self._no_depth)
