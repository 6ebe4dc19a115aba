"""Scopes: where drawing goes, with which switches, and that a loop makes no new ones."""

from __future__ import annotations

import moderngl
import numpy as np
import pytest

from hmdwarp.gpu import COLOUR, allocate, download, drawing_into


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
    has switched it meanwhile.
    """
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
