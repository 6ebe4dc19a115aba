"""Textures of somebody else, taken over into the forms of the inside by one pass where need be."""

from __future__ import annotations

import moderngl

from ..errors import InputError
from ..geometry import DepthLayer
from ..geometry.depth import HALF_STEP
from ..gpu.context import Gpu
from ..gpu.shaders import Compute
from ..gpu.textures import COLOUR, SCALAR
from .given_arrays import ENCODINGS, LINEAR, SRGB

INVERSE, METRES = "inverse", "metres"
_FORMS = {INVERSE: 0, METRES: 1}
_OF_BUFFER = 2
_MOST = 3.4028234e38  # of a float32
Pair = tuple[moderngl.Texture, moderngl.Texture]


class GivenTextures:
    """Takes textures of one size over; each way is compiled when it is first needed."""

    def __init__(self, gpu: Gpu, size: tuple[int, int]) -> None:
        self._gpu, self._size = gpu, size
        self._programs: dict[tuple[int, int], Compute] = {}

    def taken_over(
        self,
        colour: moderngl.Texture,
        depth: moderngl.Texture,
        depth_as: str | DepthLayer,
        encoding: str,
        into: Pair,
    ) -> Pair:
        """Return rgba16f linear light with coverage, and r32f inverse depth.

        The given textures themselves where they are that; else `into`, written by a pass. depth_as,
        encoding: as Warper.warp_textures. Errors: InputError.
        """
        self._check(colour, depth, depth_as, encoding)
        kinds = [(one.components, one.dtype) for one in (colour, depth)]
        if kinds == [COLOUR, SCALAR] and depth_as == INVERSE and encoding == LINEAR:
            return colour, depth
        form = _OF_BUFFER if isinstance(depth_as, DepthLayer) else _FORMS[depth_as]
        program = self._program(int(encoding == SRGB), form)
        colour.use(0)
        depth.use(1)
        into[0].bind_to_image(0, read=False, write=True)
        into[1].bind_to_image(1, read=False, write=True)
        program.uniforms.set(given_colour=0, given_depth=1, colour=0, inverse_depth=1, rendered_size=self._size)
        if isinstance(depth_as, DepthLayer):
            program.uniforms.set(**_buffer_uniforms(depth_as))
        program.run(*self._size)
        self._gpu.barrier()
        return into

    def _check(
        self, colour: moderngl.Texture, depth: moderngl.Texture, depth_as: str | DepthLayer, encoding: str
    ) -> None:
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
        if not isinstance(depth_as, DepthLayer) and depth_as not in _FORMS:
            raise InputError(f"depth_as is {depth_as!r}: expected {', '.join(_FORMS)} or a hmdwarp.DepthLayer")
        if encoding not in ENCODINGS:
            raise InputError(f"encoding is {encoding!r}: expected {' or '.join(ENCODINGS)}")

    def _program(self, encoded: int, form: int) -> Compute:
        key = encoded, form
        if key not in self._programs:
            self._programs[key] = self._gpu.shaders.compute("image/given.comp", ENCODED=encoded, DEPTH=form)
        return self._programs[key]


def _buffer_uniforms(layer: DepthLayer) -> dict[str, float]:
    """Return the numbers by which a depth buffer's values become inverse depth."""
    span = layer.max_depth - layer.min_depth
    near, far = 1 / layer.near_z, 1 / layer.far_z
    return {
        "low": layer.min_depth,
        "high": layer.max_depth,
        "slack": min(HALF_STEP, 0.01 * span),
        "at_least": min(near, _MOST),
        "per_value": (far - near) / span,
    }
