"""Which OpenGL objects there are: asked of the driver itself, name by name, so that nothing which only Python forgot is missed."""

from __future__ import annotations

import ctypes
from collections import Counter

import pytest

KINDS = ("Texture", "Buffer", "Framebuffer", "Renderbuffer", "VertexArray", "Query", "Sampler", "Program")
MOST_NAMES = 20_000  # names are handed out from 1 on; a run uses some hundred


def living() -> Counter[str]:
    """How many objects of each kind the current context has. Skips the test where there is no libGL to ask."""
    try:
        gl = ctypes.CDLL("libGL.so.1")
    except OSError as error:
        pytest.skip(f"no libGL to ask which objects there are: {error}")
    return Counter(
        {kind: sum(bool(getattr(gl, f"glIs{kind}")(name)) for name in range(1, MOST_NAMES)) for kind in KINDS}
    )
