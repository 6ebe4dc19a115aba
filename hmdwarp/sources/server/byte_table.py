"""The sRGB bytes of linear light, as shaders look them up."""

from __future__ import annotations

import moderngl
import numpy as np

from ...colour import srgb8_from_linear

BYTES_BINDING = 2  # as in shaders/lib/display_bytes.glsl


def display_bytes(gl: moderngl.Context) -> moderngl.Buffer:
    """Return the buffer of lib/display_bytes.glsl: the sRGB byte of each of the 65536 halves."""
    halves = np.arange(65536, dtype=np.uint16).view(np.float16)
    return gl.buffer(srgb8_from_linear(halves).tobytes())
