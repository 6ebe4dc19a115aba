"""What lenses hide of views, drawn and blackened."""

from __future__ import annotations

from typing import Any
from weakref import WeakKeyDictionary

import moderngl
import numpy as np
from numpy.typing import NDArray

from .shaders import ShaderLibrary
from .strips import WHOLE, HiddenArea, SeenView, Size, Strips
from .textures import Canvas

UNIT = 15  # texture unit of seen_rows, see shaders/gpu/hide.comp
ACROSS = 150  # rectangles of the hidden area, about


class SeenRows:
    """Draws what is hidden of views; keeps what it needs for each field of view and size."""

    def __init__(self, gl: moderngl.Context, shaders: ShaderLibrary) -> None:
        self._gl, self._shaders = gl, shaders
        self._made: WeakKeyDictionary[HiddenArea, dict[tuple[object, ...], Any]] = WeakKeyDictionary()

    def cover(self, view: SeenView, size: Size, nearest: float, **defines: object) -> None:
        """Draw what is hidden of a view in front of everything, into a framebuffer of that size.

        nearest: the end of the depth range in clip space, 1 or -1.
        """
        if view.hidden is None:
            return
        program = self._shaders.draw("server/hidden.vert", "server/hidden.frag", NEAREST=nearest, **defines)
        made, key = self._made.setdefault(view.hidden, {}), (view.fov, size, program)
        if key not in made:
            buffer = self._gl.buffer(_corners(view.hidden.rows(view.fov, size), size).tobytes())
            made[key] = self._gl.vertex_array(program.program, [(buffer, "2f", "in_ndc")])
        made[key].render(moderngl.TRIANGLES)

    def hide(
        self, view: SeenView, colour: Canvas, inverse_depth: moderngl.Texture | None, of: Strips = "hidden"
    ) -> None:
        """Write into the hidden pixels of a shown picture: black, no depth, and no hole either.

        of: "edge" for those alone beside which a pass over the seen strips has written.
        """
        program = self._shaders.compute("gpu/hide.comp", WITH_DEPTH=int(inverse_depth is not None), HIDES=1)
        hidden, size = view.hidden or WHOLE, colour.size
        made, key = self._made.setdefault(hidden, {}), (view.fov, size)
        if key not in made:
            rows = hidden.rows(view.fov, size).astype(np.float32)
            made[key] = self._gl.texture((size[0], 1), 2, rows.tobytes(), dtype="f4")
        made[key].use(UNIT)
        colour.bind_for_writing(0)
        if inverse_depth is not None:
            inverse_depth.bind_to_image(1, read=False, write=True)
            program.uniforms.set(depth=1)
        program.uniforms.set(colour=0, size=size, seen_rows=UNIT)
        if count := self._shaders.strips.bind(view, size, program.group[0], program.rows, of=of):
            program.program.run(count)


def _corners(rows: NDArray[np.int32], size: Size) -> NDArray[np.float32]:
    """Return triangles, in_ndc, of rectangles over all but the seen rows of each column.

    In a wide picture each is several columns wide and leaves what any of them sees. 1234x1370:
    llvmpipe draws those of 8 columns in 3.5 ms of the 15 that they save, those of one in 9.5.
    """
    columns = max(1, size[0] // ACROSS)
    starts = np.arange(0, size[0], columns)
    x = np.stack([starts, np.minimum(starts + columns, size[0])], axis=1)
    below = np.minimum.reduceat(np.where(rows[:, 0] < rows[:, 1], rows[:, 0], size[1]), starts)
    above = np.maximum.reduceat(rows[:, 1], starts)
    edges = ((np.zeros_like(below), below), (np.maximum(above, below), np.full_like(above, size[1])))
    left, right, low, high = np.concatenate([np.stack([x[:, 0], x[:, 1], *ends], axis=1) for ends in edges]).T
    places = np.stack([left, low, right, low, left, high, left, high, right, low, right, high], axis=1)
    return (places.reshape(-1, 2) * 2.0 / size - 1).astype(np.float32)
