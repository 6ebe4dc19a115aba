"""Draw everything around an eye: the six faces of geometry.cube in one texture."""

from __future__ import annotations

import moderngl

from ...geometry import View
from ...geometry.cube import FACES, face_views
from .passes import ScenePasses, clear_depth


def draw_cube(
    gl: moderngl.Context, passes: ScenePasses, view: View, framebuffer: moderngl.Framebuffer, time_ns: int = 0
) -> None:
    """Draw all six faces around the eye of `view` into a framebuffer of 3n x 2n pixels."""
    side = framebuffer.size[0] // 3
    clear_depth(gl, framebuffer)
    for face, seen in zip(FACES, face_views(view, side), strict=True):
        passes.draw_into(seen, framebuffer, (face.column * side, face.row * side, side, side), time_ns)
