"""What lenses hide of views: drawn, blackened, and left out by shaders, which run over strips."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, Literal
from weakref import WeakKeyDictionary

import moderngl
import numpy as np
from numpy.typing import NDArray

from .textures import Canvas, drawing_into

UNIT = 15  # texture unit of seen_rows, see shaders/gpu/hide.comp
ACROSS = 150  # rectangles of the hidden area, about
_STRIPS, STRIP = 7, 16  # storage buffer and columns of shaders/lib/rows.glsl
_NO_STRIP = 0xFFFF  # beyond every picture: the last work group may have fewer
Size = tuple[int, int]
SeenView = Any  # a geometry.View
Strips = Literal["seen", "hidden", "edge"]
Grid = Literal["rendered", "shown", "panel"]


class _Whole:
    """A view of which nothing is hidden, and its hidden area, as geometry.Hidden has it."""

    fov, hidden = None, None

    def seen(self, fov: Any, size: Size) -> NDArray[np.bool_]:
        return np.ones(size[::-1], bool)


WHOLE = _Whole()


class HiddenAreas:
    """Whose hidden areas count, and what is made of each, once for each field of view and size.

    The compensator sets both attributes; passes only say which view their grid is of.
    """

    def __init__(self, gl: moderngl.Context, shaders: Any) -> None:
        self._gl, self._shaders = gl, shaders
        # Whether programs that are made now leave out what is hidden, if their grid is of a view.
        self.skips = False
        # The views that count now; nothing is hidden of one that is missing.
        self.views: dict[Grid, SeenView] = {}
        self._made: WeakKeyDictionary[Any, dict[tuple[object, ...], Any]] = WeakKeyDictionary()

    @contextmanager
    def skipping(self, skips: bool) -> Iterator[None]:
        """Set `skips` inside the block."""
        before, self.skips = self.skips, skips
        try:
            yield
        finally:
            self.skips = before

    def bind(self, view: SeenView, size: Size, group: int, rows: int, cell: int = 1, of: Strips = "seen") -> int:
        """Bind the list of strips for a program made with HIDES; return its work groups.

        size: in pixels. group: invocations across. rows: as its ROWS. cell: pixels on each axis for
        which it has one invocation, or row of one. of: strips at a seen pixel, with a hidden one,
        or with a hidden one near the outline.
        """
        hidden = view.hidden or WHOLE
        made, key = self._made.setdefault(hidden, {}), (view.fov, size, group, rows, cell, of)
        if key not in made:
            seen = hidden.seen(view.fov, size)
            # Passes read beside the pixels that they write.
            beside = np.pad(seen, 1)
            beside = beside[:-2, 1:-1] | beside[2:, 1:-1] | beside[1:-1, :-2] | beside[1:-1, 2:] | seen
            # Which groups of strips and rows have such a pixel.
            steps = (1, np.arange(0, size[0], STRIP * cell)), (0, np.arange(0, size[1], rows * cell))
            any_seen, any_hidden = beside, ~seen
            for axis, at in steps:
                any_seen, any_hidden = (np.logical_or.reduceat(one, at, axis) for one in (any_seen, any_hidden))
            # A pass of other rows writes up to the next of these.
            written = any_seen | np.roll(any_seen, 1, axis=0) | np.roll(any_seen, -1, axis=0)
            lists = {"seen": any_seen, "hidden": any_hidden, "edge": written & any_hidden}
            (row, column), each = np.nonzero(lists[of]), group // STRIP
            count = -(-len(row) // each)
            places = np.full(max(1, count * each), _NO_STRIP, np.uint32)
            places[: len(row)] = column | row << 16
            made[key] = self._gl.buffer(places.tobytes()), count
        strips, count = made[key]
        strips.bind_to_storage_buffer(_STRIPS)
        return int(count)

    def cover(self, view: SeenView, framebuffer: moderngl.Framebuffer, nearest: float, **defines: object) -> None:
        """Draw what is hidden of a view in front of all. nearest: the depth in clip space, +-1."""
        if view.hidden is None:
            return
        size = framebuffer.size
        program = self._shaders.draw("server/hidden.vert", "server/hidden.frag", NEAREST=nearest, **defines)
        made, key = self._made.setdefault(view.hidden, {}), (view.fov, size, program)
        if key not in made:
            # Triangles over all but the seen rows of each column. In a wide picture each is several
            # columns wide and leaves what any of them sees. 1234x1370: llvmpipe draws those of 8
            # columns in 3.5 ms of the 15 that they save, those of one in 9.5.
            rows, columns = view.hidden.rows(view.fov, size), max(1, size[0] // ACROSS)
            starts = np.arange(0, size[0], columns)
            left, right = np.tile([starts, np.minimum(starts + columns, size[0])], 2)
            below = np.minimum.reduceat(np.where(rows[:, 0] < rows[:, 1], rows[:, 0], size[1]), starts)
            above = np.maximum.reduceat(rows[:, 1], starts)
            low = np.concatenate([np.zeros_like(below), np.maximum(above, below)])
            high = np.concatenate([below, np.full_like(above, size[1])])
            places = np.stack([left, low, right, low, left, high, left, high, right, low, right, high], axis=1)
            buffer = self._gl.buffer((places.reshape(-1, 2) * 2.0 / size - 1).astype(np.float32).tobytes())
            made[key] = self._gl.vertex_array(program.program, [(buffer, "2f", "in_ndc")])
        framebuffer.viewport = (0, 0, *size)
        with drawing_into(framebuffer, moderngl.DEPTH_TEST):
            made[key].render(moderngl.TRIANGLES)

    def hide(
        self, view: SeenView, colour: Canvas, inverse_depth: moderngl.Texture | None, of: Strips = "hidden"
    ) -> None:
        """Make hidden pixels, or those of the "edge", black, without depth, and no hole either."""
        program = self._shaders.compute("gpu/hide.comp", WITH_DEPTH=int(inverse_depth is not None), HIDES=1)
        made, key = self._made.setdefault(view.hidden, {}), (view.fov, size := colour.size)
        if key not in made:
            rows = view.hidden.rows(view.fov, size).astype(np.float32)
            made[key] = self._gl.texture((size[0], 1), 2, rows.tobytes(), dtype="f4")
        made[key].use(UNIT)
        colour.bind_for_writing(0)
        if inverse_depth is not None:
            inverse_depth.bind_to_image(1, read=False, write=True)
            program.uniforms.set(depth=1)
        program.uniforms.set(colour=0, size=size, seen_rows=UNIT)
        if count := self.bind(view, size, program.group[0], program.rows, of=of):
            program.program.run(count)
