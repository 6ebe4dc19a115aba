"""What meshes are drawn into: colour and depth of the shown view, of which the nearer stays."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

import moderngl

from ...gpu.scopes import drawing_into
from ...gpu.textures import COLOUR, Canvas, allocate, release_all

if TYPE_CHECKING:
    from ...gpu.context import Gpu


class MeshTarget:
    """A framebuffer of the shown size."""

    def __init__(self, gpu: Gpu, shown_size: tuple[int, int]) -> None:
        self._gl = gpu.gl
        self._colour = allocate(gpu.gl, shown_size, COLOUR)
        self._depth = gpu.gl.depth_renderbuffer(shown_size)
        self._framebuffer = gpu.gl.framebuffer([self._colour], self._depth)

    @contextmanager
    def drawing(self) -> Iterator[None]:
        """Clear it, and draw what faces the eye; larger depth values are nearer."""
        with drawing_into(self._framebuffer, moderngl.DEPTH_TEST | moderngl.CULL_FACE):
            self._framebuffer.clear(depth=0.0)
            self._gl.depth_func = ">"
            yield
            self._gl.depth_func = "<"

    def copy_to(self, into: Canvas) -> None:
        """Copy the colour."""
        into.copy_from(self._framebuffer)

    def close(self) -> None:
        """Free the textures."""
        release_all(self._framebuffer, self._colour, self._depth)
