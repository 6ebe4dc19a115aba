"""A picture as textures: uploaded from arrays, or converted from a caller's own textures."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError, in_brief
from ..geometry import DepthLayer
from ..geometry.depth import HALF_STEP
from ..gpu.context import Gpu
from ..gpu.textures import COLOUR, SCALAR, allocate, release_all, upload
from ..sources.array_passes import LINEAR, SRGB
from .picture_arrays import ENCODINGS, is_one_of

INVERSE, METRES = "inverse", "metres"
_FORMS = {INVERSE: 0, METRES: 1}
_OF_BUFFER = 2
_MOST = 3.4028234e38  # of a float32
Pair = tuple[moderngl.Texture, moderngl.Texture]


class HeldPicture:
    """Colour and inverse depth of one picture, and with a repair how sure the depth is."""

    def __init__(self, gpu: Gpu, size: tuple[int, int], has_confidence: bool) -> None:
        self.pair = allocate(gpu.gl, size, COLOUR), allocate(gpu.gl, size, SCALAR)
        # rgba16f: confidence in red, coverage in alpha; for a Warper with a repair.
        self.sure: Any = allocate(gpu.gl, size, COLOUR) if has_confidence else None

    def hold_confidence(self, confidence: NDArray[np.float32]) -> None:
        nothing = np.zeros_like(confidence)
        upload(self.sure, np.stack([confidence, nothing, nothing, confidence > 0], axis=2))

    def close(self) -> None:
        release_all(*self.pair, *filter(None, [self.sure]))


class ForeignTextures:
    """Converts textures of one size; each conversion is compiled when it is first needed."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self._gpu, self._size = gpu, size

    def converted(
        self, colour: moderngl.Texture, depth: moderngl.Texture, depth_as: str | DepthLayer, encoding: str, into: Pair
    ) -> Pair:
        """Return rgba16f linear light with coverage, and r32f inverse depth.

        The textures themselves where they are that; else `into`, written by a pass. depth_as,
        encoding: as Warper.warp_textures. Errors: InputError.
        """
        for name, texture in (("colour", colour), ("depth", depth)):
            if not isinstance(texture, moderngl.Texture):
                raise InputError(
                    f"{name} is a {type(texture).__name__}: expected a moderngl.Texture; for an OpenGL id take "
                    "gpu.gl.external_texture(id, size, components, 0, dtype)"
                )
            if texture.size != self._size:
                wide, high = self._size
                raise InputError(f"{name} is {texture.width}x{texture.height} pixels: this Warper is for {wide}x{high}")
        if colour.components != 4:
            raise InputError(f"colour has {colour.components} components: expected 4, with coverage in alpha")
        if depth_as is None or not (isinstance(depth_as, DepthLayer) or is_one_of(depth_as, _FORMS)):
            raise InputError(f"depth_as is {in_brief(depth_as)}: expected {', '.join(_FORMS)} or a hmdwarp.DepthLayer")
        if encoding is None or not is_one_of(encoding, ENCODINGS):
            raise InputError(f"encoding is {in_brief(encoding)}: expected {' or '.join(ENCODINGS)}")
        kinds = [(picture.components, picture.dtype) for picture in (colour, depth)]
        if kinds == [COLOUR, SCALAR] and depth_as == INVERSE and encoding == LINEAR:
            return colour, depth
        form = _OF_BUFFER if isinstance(depth_as, DepthLayer) else _FORMS[depth_as]
        program = self._gpu.shaders.compute("image/given.comp", ENCODED=int(encoding == SRGB), DEPTH=form)
        colour.use(0)
        depth.use(1)
        into[0].bind_to_image(0, read=False, write=True)
        into[1].bind_to_image(1, read=False, write=True)
        program.uniforms.set(given_colour=0, given_depth=1, colour=0, inverse_depth=1, rendered_size=self._size)
        if isinstance(depth_as, DepthLayer):
            span = depth_as.max_depth - depth_as.min_depth
            near, far = 1 / depth_as.near_z, 1 / depth_as.far_z
            program.uniforms.set(low=depth_as.min_depth, high=depth_as.max_depth, slack=min(HALF_STEP, 0.01 * span))
            program.uniforms.set(at_least=min(near, _MOST), per_value=(far - near) / span)
        program.run(*self._size)
        self._gpu.barrier()
        return into
