"""What moderngl has no words for: drawing into somebody else's depth texture."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from hmdwarp.errors import MachineError
from hmdwarp.gpu import depth_framebuffer, gl_function


def begin_anew(gl) -> None:
    """Without what tests before have left in the context that all share.

    moderngl binds again whatever was bound, even a framebuffer that was released since: GL answers
    with GL_INVALID_OPERATION, which hurts nobody, and keeps it until somebody asks.
    """
    gl.framebuffer([gl.texture((1, 1), 4)]).use()
    while gl.error != "GL_NO_ERROR":
        pass


def test_drawing_lands_in_the_foreign_texture(gpu):
    """The texture stands for a runtime's: made by moderngl, known by its GL name alone."""
    gl, size = gpu.gl, (7, 5)
    released = gl.framebuffer([gl.texture((2, 2), 4)])
    released.use()
    released.release()
    begin_anew(gl)
    theirs = gl.depth_texture(size)
    other = gl.framebuffer([gl.texture((3, 3), 4)])
    other.use()
    bound = ctypes.c_int32()
    made = depth_framebuffer(gl, theirs.glo, size)
    gl_function("glGetIntegerv", None, ctypes.c_uint32, ctypes.POINTER(ctypes.c_int32))(0x8CA6, ctypes.byref(bound))
    assert bound.value == other.glo  # what was drawn into before still is
    assert made.size == size
    made.clear(depth=0.25)
    values = np.frombuffer(made.read(components=1, attachment=-1, dtype="f4"), np.float32)
    assert values.size == 35 and np.allclose(values, 0.25, atol=2**-16)
    made.release()
    again = gl.framebuffer([gl.texture(size, 4)], theirs)  # theirs is still there, and holds what was drawn
    values = np.frombuffer(again.read(components=1, attachment=-1, dtype="f4"), np.float32)
    assert np.allclose(values, 0.25, atol=2**-16) and gl.error == "GL_NO_ERROR"


def test_a_texture_that_takes_no_depth_is_refused(gpu):
    colour = gpu.gl.texture((4, 4), 4)
    with pytest.raises(MachineError, match="cannot draw into the runtime's depth"):
        depth_framebuffer(gpu.gl, colour.glo, (4, 4))
    begin_anew(gpu.gl)


def test_a_function_no_driver_has_is_named():
    """EGL and GLX may promise any name that begins with gl; other names they do not know."""
    with pytest.raises(MachineError, match="no noSuchFunction"):
        gl_function("noSuchFunction", None)
