"""Average what a gather shows with what older frames of the eye saw of the same surfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import moderngl

from ...frames import EyeImage
from ...gpu.context import Gpu
from ...gpu.shaders import Compute
from ...gpu.textures import COLOUR, Canvas, allocate, release_all, tiles

BLOCK = 8  # pixels on each side, as ROWS in the shaders
MOST_OLDER = 3
# Image units; the texture unit of an older frame's colour is that of its image.
_SHOWN, _SHOWN_DEPTH, _DEPTH, _LOOKED_UP, _COLOUR, _SUMS = range(6)
_LOOK = {
    "shown_inverse_depth": _SHOWN_DEPTH,
    "older_inverse_depth": _DEPTH,
    "looked_up": _LOOKED_UP,
    "older_colour": _COLOUR,
}
_COMPARE = {"shown_colour": _SHOWN, "looked_up": _LOOKED_UP, "sums": _SUMS}


class OlderFrames:
    """Passes that look each shown pixel up in older frames, where they saw the same surface.

    The place follows from the depth that the warp has found, so nothing is searched again. Noise,
    codec errors and the blur of sampling differ from frame to frame and average out. Of an older
    frame only detail counts: in blocks of 8 x 8 pixels its mean becomes the newest frame's. It
    counts less the more light has changed there, and the farther off it lies.
    """

    def __init__(self, gpu: Gpu, shown_size: tuple[int, int], most: int, ways: Mapping[str, bool]) -> None:
        """Compile for at most `most` older frames; ways: what warps/older_look.comp defines."""
        self._gpu, self._size, self._blocks = gpu, shown_size, tiles(shown_size, BLOCK)
        defines = {name: 1 for name, asked in {**ways, "TEXELS": gpu.is_software}.items() if asked}
        self._look = gpu.shaders.compute("warps/older_look.comp", **defines)
        self._compare = gpu.shaders.compute("warps/older_compare.comp")
        self._agree = gpu.shaders.compute("warps/older_agree.comp")
        self._join = [gpu.shaders.compute("warps/older_join.comp", OLDER=count) for count in range(1, most + 1)]
        self._runs = {one: one.over(*shown_size) for one in (self._look, *self._join)}
        self._runs |= {one: one.over(*self._blocks) for one in (self._compare, self._agree)}
        self._looked_up = [allocate(gpu.gl, shown_size, COLOUR) for _ in range(most)]
        self._told = [allocate(gpu.gl, self._blocks, COLOUR) for _ in range(most)]
        self._sums = allocate(gpu.gl, (self._blocks[0], 4 * self._blocks[1]), (4, "f4"))

    def add(
        self,
        older: Sequence[EyeImage],
        maps: Sequence[Mapping[str, object]],
        into: Canvas,
        inverse_depth: moderngl.Texture,
        limits: Mapping[str, object],
    ) -> None:
        """Average `into`, whose pixels lie at `inverse_depth` (r32f), with the older frames.

        maps: H and e to each of them, as uniforms. limits: depth_tolerance and depth_floor.
        """
        for image, back, looked_up, told in zip(older, maps, self._looked_up, self._told, strict=False):
            inverse_depth.bind_to_image(_SHOWN_DEPTH, read=True, write=False)
            image.inverse_depth.bind_to_image(_DEPTH, read=True, write=False)
            looked_up.bind_to_image(_LOOKED_UP, read=True, write=True)
            image.colour.bind_to_image(_COLOUR, read=True, write=False)
            image.colour.use(_COLOUR)
            sizes = {"shown_size": self._size, "rendered_size": image.size}
            self._run(self._look, **_LOOK, **sizes, **back, **limits)
            into.texture.bind_to_image(_SHOWN, read=True, write=False)
            self._sums.bind_to_image(_SUMS, read=True, write=True)
            self._run(self._compare, **_COMPARE, blocks=self._blocks)
            told.bind_to_image(_SHOWN, read=False, write=True)
            self._run(self._agree, sums=_SUMS, told=_SHOWN, blocks=self._blocks)
        count = min(len(older), len(self._looked_up))
        into.texture.bind_to_image(_SHOWN, read=True, write=True)
        for k in range(count):
            self._looked_up[k].bind_to_image(1 + 2 * k, read=True, write=False)
            self._told[k].bind_to_image(2 + 2 * k, read=True, write=False)
        units = {
            name: first if count == 1 else tuple(range(first, 2 * count + 1, 2))
            for first, name in enumerate(("looked_up", "told"), start=1)
        }
        sizes = {"shown_size": self._size, "last_block": (self._blocks[0] - 1, self._blocks[1] - 1)}
        self._run(self._join[count - 1], shown_colour=_SHOWN, **sizes, **units)

    def _run(self, program: Compute, **uniforms: object) -> None:
        self._gpu.barrier()
        program.uniforms.set(**uniforms)
        self._runs[program]()

    def close(self) -> None:
        """Free the textures."""
        release_all(*self._looked_up, *self._told, self._sums)
