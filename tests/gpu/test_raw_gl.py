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


def quiet(gl, what: str) -> None:
    assert gl.error == "GL_NO_ERROR", what


def test_drawing_lands_in_the_foreign_texture(gpu):
    """The texture stands for a runtime's: made by moderngl, known by its GL name alone."""
    gl, size = gpu.gl, (7, 5)
    released = gl.framebuffer([gl.texture((2, 2), 4)])
    released.use()
    released.release()
    begin_anew(gl)
    theirs = gl.depth_texture(size)
    quiet(gl, "a depth texture")
    other = gl.framebuffer([gl.texture((3, 3), 4)])
    other.use()
    quiet(gl, "another framebuffer")
    bound = ctypes.c_int32()
    made = depth_framebuffer(gl, theirs.glo, size)
    quiet(gl, "the framebuffer of a foreign texture")
    gl_function("glGetIntegerv", None, ctypes.c_uint32, ctypes.POINTER(ctypes.c_int32))(0x8CA6, ctypes.byref(bound))
    assert bound.value == other.glo  # what was drawn into before still is
    assert made.size == size
    made.clear(depth=0.25)
    quiet(gl, "clearing it")
    values = np.frombuffer(made.read(components=1, attachment=-1, dtype="f4"), np.float32)
    quiet(gl, "reading it")
    assert values.size == 35 and np.allclose(values, 0.25, atol=2**-16)
    made.release()
    quiet(gl, "releasing it")
    again = gl.framebuffer([gl.texture(size, 4)], theirs)  # theirs is still there, and holds what was drawn
    quiet(gl, "a framebuffer of moderngl's own")
    values = np.frombuffer(again.read(components=1, attachment=-1, dtype="f4"), np.float32)
    quiet(gl, "reading that")
    assert np.allclose(values, 0.25, atol=2**-16)


def test_a_texture_that_takes_no_depth_is_refused(gpu):
    colour = gpu.gl.texture((4, 4), 4)
    with pytest.raises(MachineError, match="cannot draw into the runtime's depth"):
        depth_framebuffer(gpu.gl, colour.glo, (4, 4))
    begin_anew(gpu.gl)


def test_a_function_no_driver_has_is_named():
    """EGL and GLX may promise any name that begins with gl; other names they do not know."""
    with pytest.raises(MachineError, match="no noSuchFunction"):
        gl_function("noSuchFunction", None)
