"""A cube map: everything around an eye, whichever way it turns."""

from __future__ import annotations

from ....errors import InputError
from ....frames import EyeImage
from ....geometry import View
from ....geometry.cube import cube_size
from ..passes import draw_cube
from . import Drawing, Part, parts


@parts.register
class Cube(Part):
    """Colour of the six faces of geometry.cube, as sharp as the picture.

    Errors: InputError beyond the GL limit.
    """

    name = "cube"
    order = 110

    def add(self, eye: EyeImage, drawing: Drawing) -> EyeImage:
        context = self.context
        size = checked_cube_size(eye.view, eye.size, context.gpu.max_texture_size)
        cube = context.acquire(size, depth=False).colour
        draw_cube(context.gpu.gl, context.passes_for(drawing), eye.view, context.framebuffers.over(cube), eye.drawn_ns)
        return eye.having(cube=cube)


def checked_cube_size(view: View, size: tuple[int, int], limit: int) -> tuple[int, int]:
    """Return (w, h) of the cube around the eye of a (w, h) picture.

    Errors: InputError beyond the GL limit.
    """
    cube = cube_size(view.fov, size)
    if max(cube) > limit:
        raise InputError(
            f"a cube map as sharp as a picture of {size[0]}x{size[1]} would have {cube[0]}x{cube[1]} pixels: "
            f"expected at most {limit} on each side (this GPU's limit); "
            "use a smaller size, a wider field of view or another warp"
        )
    return cube
