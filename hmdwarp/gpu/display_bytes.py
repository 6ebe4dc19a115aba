"""What a display shows of each half float, as a table that shaders read."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..colour import srgb8_from_linear

if TYPE_CHECKING:
    import moderngl

BINDING = 2  # as in shaders/lib/display_bytes.glsl


def display_bytes(gl: moderngl.Context) -> moderngl.Buffer:
    """Return the buffer of lib/display_bytes.glsl: the sRGB byte of all 65536 halves; bind it.

    Holes are none of its business: their colour is black already.
    """
    halves = np.arange(65536, dtype=np.uint16).view(np.float16)
    return gl.buffer(srgb8_from_linear(halves).tobytes())
