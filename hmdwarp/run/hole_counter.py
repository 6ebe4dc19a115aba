"""Count the holes of warped pictures on the GPU, without waiting for it."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np

from ..gpu.context import Gpu
from ..gpu.textures import Canvas

MOST_EYES = 2
_BYTES = 4 * MOST_EYES


class HoleCounter:
    """Count holes on the GPU: count() starts, shares() returns those of the refresh before.

    Those are finished long ago, so nothing stalls.
    """

    def __init__(self, gpu: Gpu) -> None:
        gl = self._gl = gpu.gl
        self._program = gpu.shaders.compute("live/holes.comp")
        # Cleared by a copy on the GPU: a write from the CPU could wait for a pending read.
        self._empty = gl.buffer(bytes(_BYTES))
        self._now, self._before = (gl.buffer(reserve=_BYTES) for _ in range(2))
        self._pixels: tuple[int, ...] | None = None
        self._pixels_before: tuple[int, ...] | None = None

    def count(self, canvases: Sequence[Canvas]) -> None:
        """Count the pixels with alpha 0 of each eye's picture, which earlier passes have finished.

        Call once a refresh.
        """
        self._now, self._before = self._before, self._now
        self._pixels_before, self._pixels = self._pixels, tuple(canvas.size[0] * canvas.size[1] for canvas in canvases)
        self._gl.copy_buffer(self._now, self._empty)
        self._now.bind_to_storage_buffer(0)
        for slot, canvas in enumerate(canvases):
            canvas.texture.bind_to_image(0, read=True, write=False)
            self._program.uniforms.set(picture=0, size=canvas.size, slot=slot)
            self._program.run(*canvas.size)
        self._gl.memory_barrier(moderngl.BUFFER_UPDATE_BARRIER_BIT)

    def shares(self) -> tuple[float, ...] | None:
        """Return the share of holes in each eye's pixels, 0..1, at the count before the last one.

        None before the second count.
        """
        if self._pixels_before is None:
            return None
        counts = np.frombuffer(self._before.read(), np.uint32)
        return tuple(int(count) / pixels for count, pixels in zip(counts, self._pixels_before, strict=False))

    def close(self) -> None:
        """Free the buffers."""
        for buffer in (self._empty, self._now, self._before):
            buffer.release()
