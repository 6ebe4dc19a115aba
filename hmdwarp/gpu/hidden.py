"""What a lens hides of a view, for shaders: the seen rows of each column."""

from __future__ import annotations

from typing import Any, Protocol
from weakref import WeakKeyDictionary

import moderngl
import numpy as np
from numpy.typing import NDArray

from .shaders import Compute, Draw, ShaderLibrary
from .textures import Canvas

GROUPS = 7  # storage buffer of shaders/lib/rows.glsl
UNIT = 15  # texture unit of seen_rows, see shaders/gpu/hide.comp
ACROSS = 150  # rectangles of the hidden area, about
Size = tuple[int, int]
Fov = Any


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
        self._groups: WeakKeyDictionary[HiddenArea, dict[tuple[Fov, Size, Size], tuple[moderngl.Buffer, int]]]
        self._groups = WeakKeyDictionary()

    def use(self, view: SeenView, size: Size) -> int:
        """Bind those of a view; return the texture unit."""
        hidden = view.hidden or self._nothing
        made, key = self._made.setdefault(hidden, {}), (view.fov, size)
        if key not in made:
            rows = hidden.rows(view.fov, size)
            made[key] = self._gl.texture((size[0], 1), 2, rows.astype(np.float32).tobytes(), dtype="f4")
        made[key].use(UNIT)
        return UNIT

    def corners(self, view: SeenView, size: Size, program: Draw) -> moderngl.VertexArray:
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

    def run(self, program: Compute, view: SeenView, size: Size) -> None:
        """Run a program made with HIDES over the work groups that see something of a view."""
        hidden = view.hidden or self._nothing
        wide, high = program.group[0], program.group[1] * program.rows
        made, key = self._groups.setdefault(hidden, {}), (view.fov, size, (wide, high))
        if key not in made:
            seen = hidden.seen(view.fov, size)
            any_seen = np.logical_or.reduceat(seen, np.arange(0, size[1], high), axis=0)
            any_seen = np.logical_or.reduceat(any_seen, np.arange(0, size[0], wide), axis=1)
            row, column = np.nonzero(any_seen)
            made[key] = self._gl.buffer((column | row << 16).astype(np.uint32).tobytes()), len(row)
        groups, count = made[key]
        groups.bind_to_storage_buffer(GROUPS)
        program.program.run(count)

    def hide(self, view: SeenView, colour: Canvas, inverse_depth: moderngl.Texture | None) -> None:
        """Write into the hidden pixels of a shown picture: black, no depth, and no hole either."""
        program = self._shaders.compute("gpu/hide.comp", WITH_DEPTH=int(inverse_depth is not None))
        colour.bind_for_writing(0)
        if inverse_depth is not None:
            inverse_depth.bind_to_image(1, read=False, write=True)
            program.uniforms.set(depth=1)
        program.uniforms.set(colour=0, size=colour.size, seen_rows=self.use(view, colour.size))
        program.run(*colour.size)
