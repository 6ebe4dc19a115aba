"""Where drawing goes: scopes with their switches, and a depth texture of somebody else."""

from __future__ import annotations

import ctypes

import moderngl
import numpy as np
import pytest

from hmdwarp.base import MachineError
from hmdwarp.gpu import COLOUR, allocate, depth_framebuffer, download, drawing_into, gl_function


@pytest.fixture
def framebuffers(gpu):
    textures = [allocate(gpu.gl, (2, 2), COLOUR) for _ in range(2)]
    made = [gpu.gl.framebuffer([texture]) for texture in textures]
    yield made
    for thing in (*made, *textures):
        thing.release()


def colour(framebuffer) -> float:
    return float(download(framebuffer.color_attachments[0])[0, 0, 0])


def test_drawing_goes_there_and_then_back_to_where_it_went(gpu, framebuffers):
    outer, inner = framebuffers
    for number in (1.0, 2.0):  # the second time with the scopes of the first
        with drawing_into(outer):
            with drawing_into(inner, moderngl.NOTHING):
                gpu.gl.clear(number + 10)
            gpu.gl.clear(number)
        assert (colour(outer), colour(inner)) == (number, number + 10)


def test_switches_are_those_asked_for_each_time(gpu, framebuffers):
    """A triangle that faces away is drawn or not, as culling is switched, also after something else
    has switched it meanwhile."""
    program = gpu.shaders.draw("server/background.vert", "server/background.frag")
    triangle = gpu.gl.vertex_array(program.program, [])
    into = framebuffers[0]
    gpu.gl.front_face = "cw"
    try:
        for flags, drawn in ((moderngl.CULL_FACE, False), (moderngl.NOTHING, True), (moderngl.CULL_FACE, False)):
            into.clear(5.0)
            gpu.gl.enable_only(moderngl.NOTHING if flags else moderngl.CULL_FACE)
            with drawing_into(into, flags):
                triangle.render(moderngl.TRIANGLES, vertices=3)
            assert (colour(into) != 5.0) is drawn
    finally:
        gpu.gl.front_face = "ccw"
        gpu.gl.enable_only(moderngl.NOTHING)
        triangle.release()


def test_a_loop_keeps_nothing_in_the_context(gpu, framebuffers):
    """moderngl's collector keeps a piece of each dead scope until the context is closed."""
    with drawing_into(framebuffers[0]):
        pass
    before = len(gpu.gl.objects)
    for _ in range(10):
        with drawing_into(framebuffers[0]):
            np.zeros(1)
    assert len(gpu.gl.objects) == before


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
