"""Close every hole of a picture from its surroundings, for pictures without depth."""

from __future__ import annotations

import moderngl

from ...gpu.context import Gpu
from ...gpu.textures import COLOUR, allocate, release_all, tiles


class Closing:
    """Pull-push through a pyramid for pictures of one size; owns the levels."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self._gpu = gpu
        self._down, self._up = (gpu.shaders.compute("effects/reflect_close.comp", PASS=k) for k in range(2))
        sizes = [size]
        while max(sizes[-1]) > 1:
            sizes.append(tiles(sizes[-1], 2))
        self._levels = [allocate(gpu.gl, each, COLOUR, linear=True) for each in sizes[1:]]

    def run(self, picture: moderngl.Texture) -> None:
        """Close the holes of an rgba16f picture with coverage in alpha, in place.

        A picture without covered pixels stays empty.
        """
        levels = [picture, *self._levels]
        for finer, level in zip(levels[:-1], levels[1:], strict=True):
            finer.bind_to_image(0, read=True, write=False)
            level.bind_to_image(1, read=False, write=True)
            self._down.uniforms.set(finer=0, level=1, level_size=level.size)
            self._down.run(*level.size)
            self._gpu.barrier()
        for level, coarser in reversed(list(zip(levels[:-1], levels[1:], strict=True))):
            level.bind_to_image(0, read=True, write=True)
            coarser.use(0)
            pixel = (0.5 / coarser.size[0], 0.5 / coarser.size[1])
            self._up.uniforms.set(level=0, coarser=0, coarser_pixel=pixel, level_size=level.size)
            self._up.run(*level.size)
            self._gpu.barrier()

    def close(self) -> None:
        """Free the levels."""
        release_all(*self._levels)
