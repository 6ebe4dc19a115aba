"""Draws everything around an eye: the six faces of geometry.cube in one texture, colour alone."""

from __future__ import annotations

import moderngl

from ..errors import InputError
from ..geometry import View
from ..geometry.cube import FACES, cube_size, face_views
from .passes import ScenePasses, clear_depth


def checked_cube_size(view: View, size: tuple[int, int], limit: int) -> tuple[int, int]:
    """(w, h) of the cube around the eye of a (w, h) picture. Errors: InputError beyond the GL limit."""
    wanted = cube_size(view.fov, size)
    if max(wanted) > limit:
        raise InputError(
            f"a cube map as sharp as a picture of {size[0]}x{size[1]} would have {wanted[0]}x{wanted[1]} pixels: wanted at most {limit} on "
            "each side (this GPU's limit); use a smaller size, a wider field of view or another warp"
        )
    return wanted


def draw_cube(
    gl: moderngl.Context, passes: ScenePasses, view: View, framebuffer: moderngl.Framebuffer, time_ns: int = 0
) -> None:
    """All six faces around the eye of `view` at that instant into a framebuffer of 3n x 2n pixels."""
    side = framebuffer.size[0] // 3
    clear_depth(gl, framebuffer)
    for face, seen in zip(FACES, face_views(view, side), strict=True):
        passes.draw_into(seen, framebuffer, (face.column * side, face.row * side, side, side), time_ns)
