"""Average what a gather shows with what older frames of the eye saw of the same surfaces."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import moderngl
import numpy as np

from ...frames import EyeImage
from ...gpu.context import Gpu
from ...gpu.textures import COLOUR, Canvas, allocate, release_all, tiles

BLOCK = 8  # pixels on each side, as SIDE and ROWS in the shaders
MOST_OLDER = 3
# Image units; one for each older frame. The texture unit of a colour is that of its image.
_SHOWN, _SHOWN_DEPTH, _SUMS, _TOLD, _DEPTHS, _COLOURS = 0, 1, 2, 3, 4, 4 + MOST_OLDER


class OlderFrames:
    """Passes that look each shown pixel up in older frames, where they saw the same surface.

    The place follows from the depth that the warp has found, so nothing is searched again. Noise,
    codec errors and the blur of sampling differ from frame to frame and average out. Of an older
    frame only detail counts: in blocks of 8 x 8 pixels its mean becomes the newest frame's. It
    counts less the more light has changed there, and the farther off it lies.
    """

    def __init__(
        self, gpu: Gpu, rendered_size: tuple[int, int], shown_size: tuple[int, int], most: int, *, scanout: bool
    ) -> None:
        """Compile for at most `most` older frames."""
        self._gpu = gpu
        wide, high = blocks = tiles(shown_size, BLOCK)
        ways = {name: 1 for name, asked in {"SCANOUT": scanout, "TEXELS": gpu.is_software}.items() if asked}
        agree = gpu.shaders.compute("warps/older_agree.comp")
        # For each number of frames the passes in order, the constants of each, and what runs it.
        self._passes = []
        for count in range(1, most + 1):
            compare, join = (
                gpu.shaders.compute(f"warps/older_{name}.comp", OLDER=count, **ways) for name in ("compare", "join")
            )
            every: dict[str, object] = {"shown_colour": _SHOWN, "shown_inverse_depth": _SHOWN_DEPTH, "sums": _SUMS}
            every |= {"told": _TOLD, "blocks": blocks, "shown_size": shown_size, "rendered_size": rendered_size}
            every["frames"] = count
            for name, first in (("older_inverse_depth", _DEPTHS), ("older_colour", _COLOURS)):
                every[name] = tuple(range(first, first + count)) if count > 1 else first
            runs = compare.over(*blocks), agree.over(wide, count * high), join.over(wide, shown_size[1])
            self._passes.append((every, tuple(zip((compare, agree, join), runs, strict=True))))
        self._told = allocate(gpu.gl, (wide, most * high), COLOUR)
        self._sums = allocate(gpu.gl, (wide, 4 * most * high), (4, "f4"))

    def add(
        self,
        older: Sequence[EyeImage],
        depths: Sequence[moderngl.Texture],
        maps: Sequence[Mapping[str, np.ndarray]],
        into: Canvas,
        inverse_depth: moderngl.Texture,
        limits: Mapping[str, object],
    ) -> None:
        """Average `into`, whose pixels lie at `inverse_depth` (r32f), with the older frames.

        depths: their inverse depths. maps: H and e to each of them, as uniforms. limits:
        depth_tolerance and depth_floor.
        """
        for k, (image, depth) in enumerate(zip(older, depths, strict=True)):
            depth.bind_to_image(_DEPTHS + k, read=True, write=False)
            image.colour.bind_to_image(_COLOURS + k, read=True, write=False)
            image.colour.use(_COLOURS + k)
        inverse_depth.bind_to_image(_SHOWN_DEPTH, read=True, write=False)
        into.texture.bind_to_image(_SHOWN, read=True, write=True)
        self._sums.bind_to_image(_SUMS, read=True, write=True)
        self._told.bind_to_image(_TOLD, read=True, write=True)
        places = {f"older_{name}": np.array([each[name] for each in maps]) for name in maps[0]}
        every, passes = self._passes[len(older) - 1]
        for program, run in passes:
            self._gpu.barrier()
            program.uniforms.settle(every)
            if program.uniforms.declares("older_H"):
                program.uniforms.set(**places, **limits)
            run()

    def close(self) -> None:
        """Free the textures."""
        release_all(self._told, self._sums)
