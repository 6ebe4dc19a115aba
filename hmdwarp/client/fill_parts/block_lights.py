"""The light on surfaces that a picture and the client's own drawing both show, block by block."""

from __future__ import annotations

from collections.abc import Sequence

import moderngl
import numpy as np
from numpy.typing import NDArray

from ...geometry import View
from ...geometry.view import tangents_of_pixels
from ...gpu.context import Gpu
from ...gpu.textures import allocate, release_all, tiles

BLOCK = 8  # pixels, as in shaders/lib/relight.glsl
LIGHT = (4, "f4")  # rgba32f, PARTS texels a block
PARTS = 3
SEED = 0.5
SAME_DEPTH = SAME_SURFACE = (
    0.05  # the model's surfaces are off by a few hundredths; a smaller tolerance leaves curved objects unlit
)
NEAR, OFF_PLANE = 0.05, 0.06
_LIGHTS, _SAMPLES = 5, 1  # image unit, storage binding


def sample_offsets(count: int, reach_pixels: float) -> NDArray[np.int32]:
    """Return (count, 2) pixel offsets in a disc of that radius, denser towards the middle.

    They are the same for every pixel and picture. A separate pattern for every pixel would be grain
    that crawls when the head moves; with a common one, light changes only as its samples do.
    Source: Roberts 2018, The Unreasonable Effectiveness of Quasirandom Sequences (R2).
    """
    plastic = 1.32471795724474602596
    k = np.arange(1, count + 1)
    ring, turn = (SEED + k / plastic) % 1, 2 * np.pi * ((SEED + k / plastic**2) % 1)
    places = reach_pixels * ring[:, None] ** 2 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    offsets: NDArray[np.int32] = np.rint(places).astype(np.int32)
    return offsets


class BlockLights:
    """Finds light on blocks of a picture, and holds where a pixel looks for it.

    size: (w, h) of the picture. samples: places from which a pixel takes light; reach: the farthest
    of them, in picture widths.
    """

    def __init__(self, gpu: Gpu, size: tuple[int, int], samples: int, reach: float) -> None:
        self._size, self._blocks = size, tiles(size, BLOCK)
        self._find = gpu.shaders.compute("fills/relight_blocks.comp")
        # What find() writes; read by shaders with lib/relight.glsl.
        self.texture = allocate(gpu.gl, (PARTS * self._blocks[0], self._blocks[1]), LIGHT)
        offsets = sample_offsets(samples, reach * size[0])
        self._samples = gpu.gl.buffer(np.pad(offsets, ((0, 0), (0, 2))).tobytes())

    def find(self, view: View, textures: Sequence[moderngl.Texture]) -> None:
        """Divide the albedo out of a picture where it shows the same surface.

        textures: colour and inverse depth of the picture, then albedo and inverse depth of what the
        client draws; they stay bound to image units 0 to 3, the light to 5.
        """
        for unit, texture in enumerate(textures):
            texture.bind_to_image(unit, read=True, write=False)
        self.texture.bind_to_image(_LIGHTS, read=True, write=True)
        self._find.uniforms.set(
            warped=0, warped_inverse_depth=1, albedo=2, model_inverse_depth=3, lights=_LIGHTS, shown_size=self._size,
            block_count=self._blocks, same_depth=SAME_DEPTH, same_surface=SAME_SURFACE,
            **tangents_of_pixels(view, self._size),
        )  # fmt: skip
        self._find.run(*self._blocks)

    def bind_samples(self) -> None:
        """Bind the places for the shader that reads them."""
        self._samples.bind_to_storage_buffer(_SAMPLES)

    def close(self) -> None:
        """Free the texture and the buffer."""
        release_all(self.texture, self._samples)
