"""What a lens hides of a view, for shaders: the seen rows of each column."""

from __future__ import annotations

from typing import Any, Literal, Protocol
from weakref import WeakKeyDictionary

import moderngl
import numpy as np
from numpy.typing import NDArray

from .shaders import Compute, Draw, ShaderLibrary
from .textures import Canvas, tiles

STRIPS, STRIP = 7, 16  # storage buffer and columns of shaders/lib/rows.glsl
NO_STRIP = 0xFFFF  # beyond every picture: the last work group may have fewer
UNIT = 15  # texture unit of seen_rows, see shaders/gpu/hide.comp
ACROSS = 150  # rectangles of the hidden area, about
Size = tuple[int, int]


Fov = Any
Strips = Literal["seen", "hidden", "edge"]


def hiding(hides: bool) -> dict[str, object]:
    """Return the defines of a program that SeenRows.run runs, {} where nothing is hidden."""
    return {"HIDES": 1} if hides else {}


class HiddenArea(Protocol):
    """What is hidden of a view, as geometry.Hidden has it."""

    def rows(self, fov: Fov, size: Size) -> NDArray[np.int32]: ...

    def seen(self, fov: Fov, size: Size) -> NDArray[np.bool_]: ...


class SeenView(Protocol):
    """A geometry.View."""

    @property
    def fov(self) -> Fov: ...

    @property
    def hidden(self) -> HiddenArea | None: ...


class _Nothing:
    """Of views without a hidden area."""

    def rows(self, fov: Fov, size: Size) -> NDArray[np.int32]:
        return np.array([[0, size[1]]] * size[0], np.int32)

    def seen(self, fov: Fov, size: Size) -> NDArray[np.bool_]:
        return np.ones(size[::-1], bool)


class SeenRows:
    """Textures of the seen rows of views, made once for each field of view and size."""

    def __init__(self, gl: moderngl.Context, shaders: ShaderLibrary) -> None:
        self._gl, self._shaders, self._nothing = gl, shaders, _Nothing()
        self._made: WeakKeyDictionary[HiddenArea, dict[tuple[Fov, Size], moderngl.Texture]] = WeakKeyDictionary()
        self._arrays: WeakKeyDictionary[HiddenArea, dict[tuple[Fov, Size, Draw], moderngl.VertexArray]]
        self._arrays = WeakKeyDictionary()
        self._strips: WeakKeyDictionary[
            HiddenArea, dict[tuple[Fov, Size, int, int, Strips], tuple[moderngl.Buffer, int]]
        ]
        self._strips = WeakKeyDictionary()

    def use(self, view: SeenView, size: Size) -> int:
        """Bind those of a view; return the texture unit."""
        hidden = view.hidden or self._nothing
        made, key = self._made.setdefault(hidden, {}), (view.fov, size)
        if key not in made:
            rows = hidden.rows(view.fov, size)
            made[key] = self._gl.texture((size[0], 1), 2, rows.astype(np.float32).tobytes(), dtype="f4")
        made[key].use(UNIT)
        return UNIT

    def cover(self, view: SeenView, size: Size, nearest: float, **defines: object) -> None:
        """Draw what is hidden of a view in front of everything, into a framebuffer of that size.

        nearest: the end of the depth range in clip space, 1 or -1.
        """
        if view.hidden is not None:
            program = self._shaders.draw("server/hidden.vert", "server/hidden.frag", NEAREST=nearest, **defines)
            self._corners(view, size, program).render(moderngl.TRIANGLES)

    def _corners(self, view: SeenView, size: Size, program: Draw) -> moderngl.VertexArray:
        """Return rectangles, in_ndc, of what is hidden of a view, for a program.

        In a wide picture each is several columns wide and leaves what any of them sees. 1234x1370:
        llvmpipe draws those of 8 columns in 3.5 ms of the 15 that they save, those of one in 9.5.
        """
        assert view.hidden is not None
        made, key = self._arrays.setdefault(view.hidden, {}), (view.fov, size, program)
        if key not in made:
            rows = view.hidden.rows(view.fov, size)
            columns = max(1, size[0] // ACROSS)
            starts = np.arange(0, size[0], columns)
            x = np.stack([starts, np.minimum(starts + columns, size[0])], axis=1)
            below = np.minimum.reduceat(np.where(rows[:, 0] < rows[:, 1], rows[:, 0], size[1]), starts)
            above = np.maximum.reduceat(rows[:, 1], starts)
            edges = ((np.zeros_like(below), below), (np.maximum(above, below), np.full_like(above, size[1])))
            quads = [np.stack([x[:, 0], x[:, 1], *ends], axis=1) for ends in edges]
            left, right, low, high = np.concatenate(quads).T
            places = np.stack([left, low, right, low, left, high, left, high, right, low, right, high], axis=1)
            ndc = places.reshape(-1, 2) * 2.0 / size - 1
            buffer = self._gl.buffer(ndc.astype(np.float32).tobytes())
            made[key] = self._gl.vertex_array(program.program, [(buffer, "2f", "in_ndc")])
        return made[key]

    def run(self, program: Compute, view: SeenView, size: Size, cell: int = 1) -> None:
        """Run over the strips that see something of a view; over all without HIDES.

        cell: pixels on each axis for which the program has one invocation, or row of one.
        """
        program.program.run(*self.grid(program, view, size, cell))

    def grid(self, program: Compute, view: SeenView, size: Size, cell: int = 1) -> tuple[int, int]:
        """Return the work groups of such a run; a list of them is bound."""
        if program.hides:
            return self.groups(program, view, size, cell=cell), 1
        return program.groups(*tiles(size, cell))

    def groups(self, program: Compute, view: SeenView, size: Size, of: Strips = "seen", cell: int = 1) -> int:
        """Bind the list of strips for a program made with HIDES; return its work groups.

        of: strips at a seen pixel, with a hidden one, or with a hidden one near the outline.
        """
        hidden = view.hidden or self._nothing
        rows = program.rows
        made, key = self._strips.setdefault(hidden, {}), (view.fov, size, cell, rows, of)
        if key not in made:
            seen = hidden.seen(view.fov, size)
            # Passes read beside the pixels that they write.
            beside = np.pad(seen, 1)
            beside = beside[:-2, 1:-1] | beside[2:, 1:-1] | beside[1:-1, :-2] | beside[1:-1, 2:] | seen
            any_seen, any_hidden = (_any_of(part, STRIP * cell, rows * cell) for part in (beside, ~seen))
            # A pass of other rows writes up to the next of these.
            written = any_seen | np.roll(any_seen, 1, axis=0) | np.roll(any_seen, -1, axis=0)
            lists = {"seen": any_seen, "hidden": any_hidden, "edge": written & any_hidden}
            row, column = np.nonzero(lists[of])
            each = program.group[0] // STRIP
            count = -(-len(row) // each)
            places = np.full(max(1, count * each), NO_STRIP, np.uint32)
            places[: len(row)] = column | row << 16
            made[key] = self._gl.buffer(places.tobytes()), count
        strips, count = made[key]
        strips.bind_to_storage_buffer(STRIPS)
        return count

    def hide(
        self, view: SeenView, colour: Canvas, inverse_depth: moderngl.Texture | None, of: Strips = "hidden"
    ) -> None:
        """Write into the hidden pixels of a shown picture: black, no depth, and no hole either.

        of: "edge" for those alone beside which a pass over the seen strips has written.
        """
        program = self._shaders.compute("gpu/hide.comp", WITH_DEPTH=int(inverse_depth is not None), **hiding(True))
        colour.bind_for_writing(0)
        if inverse_depth is not None:
            inverse_depth.bind_to_image(1, read=False, write=True)
            program.uniforms.set(depth=1)
        program.uniforms.set(colour=0, size=colour.size, seen_rows=self.use(view, colour.size))
        if count := self.groups(program, view, colour.size, of):
            program.program.run(count)


def _any_of(chosen: NDArray[np.bool_], wide: int, high: int) -> NDArray[np.bool_]:
    """Return which groups of wide x high pixels have one that is chosen."""
    rows = np.logical_or.reduceat(chosen, np.arange(0, chosen.shape[0], high), axis=0)
    found: NDArray[np.bool_] = np.logical_or.reduceat(rows, np.arange(0, chosen.shape[1], wide), axis=1)
    return found
