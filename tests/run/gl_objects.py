"""Which OpenGL objects there are.

Asked of the driver itself, name by name, so that nothing which only Python forgot is missed.
"""

from __future__ import annotations

import ctypes
from collections import Counter

import pytest

KINDS = ("Texture", "Buffer", "Framebuffer", "Renderbuffer", "VertexArray", "Query", "Sampler", "Program")
MOST_NAMES = 20_000  # names are handed out from 1 on; a run uses some hundred, a worker's tests many more


def living() -> Counter[str]:
    """How many objects of each kind the current context has.

    Skips the test where there is no libGL to ask.
    """
    try:
        gl = ctypes.CDLL("libGL.so.1")
    except OSError as error:
        pytest.skip(f"no libGL to ask which objects there are: {error}")
    most = {kind: max(MOST_NAMES, _newest_name(gl, kind)) for kind in KINDS}
    return Counter(
        {kind: sum(bool(getattr(gl, f"glIs{kind}")(name)) for name in range(1, most[kind])) for kind in KINDS}
    )


def _newest_name(gl: ctypes.CDLL, kind: str) -> int:
    """Return a name handed out now: Mesa hands out none again, so that all others are smaller."""
    if kind == "Program":
        name = gl.glCreateProgram()
        gl.glDeleteProgram(name)
        return name
    plural = "Queries" if kind == "Query" else f"{kind}s"
    made = ctypes.c_uint()
    getattr(gl, f"glGen{plural}")(1, ctypes.byref(made))
    getattr(gl, f"glDelete{plural}")(1, ctypes.byref(made))
    return made.value
