"""The kind of warps that combine several pictures with depth.

The shown rays are intersected with one picture after the other; the best hit stays per pixel.
"""

from __future__ import annotations

from abc import abstractmethod
from functools import partial
from typing import ClassVar

import attrs
import moderngl

from ...geometry import View, view_map
from ...gpu.textures import Canvas, allocate, release_all
from ..inputs import PassInputs
from ..warps import KEY_BYTES, Warp
from .gather import DEPTH_FLOOR, DEPTH_TOLERANCE
from .guesses import PIECE_ROWS, DepthGuesses, piece_list
from .scatter import check_room

_COLOUR = 1  # texture unit
_RESULT, _BEST, _DEPTH = 0, 1, 2  # image units; from 3 on they are the warp's own
_GUESSES = 3


@attrs.frozen(eq=False)
class DepthPicture:
    """A picture with depth and the view it was rendered for."""

    colour: moderngl.Texture  # As in EyeImage.
    inverse_depth: moderngl.Texture  # As in EyeImage.
    view: View


class CompositeWarp(Warp):
    """A gather from several pictures, each seeded by a scatter of its depth alone.

    The scatter leaves in each shown pixel the nearest depth that lands there. The gather starts
    from these guesses, its own and its neighbours', and finds where the ray meets the picture's
    surface (lib/meeting.glsl).
    """

    kind = "scatter"
    best: ClassVar[tuple[int, str]] = (1, "f4")  # texture format of the best hit so far

    def prepare(self) -> None:
        check_room(self.gpu, self.name, self.shown_size, KEY_BYTES)
        self._guesses = DepthGuesses(self.gpu, self.shown_size)
        self._pieces = piece_list(self.gpu, f"warp '{self.name}'", self.shown_size)
        compute = partial(self.gpu.shaders.compute, f"warps/{self.name}.comp", ROWS=PIECE_ROWS)
        self._choose, self._first = (compute(grid="shown", PASS=k) for k in (0, 1))
        self._more = compute(PASS=2)
        self._stamp = 0
        self._best = allocate(self.gpu.gl, self.shown_size, self.best)

    @abstractmethod
    def pictures(self, inputs: PassInputs) -> list[DepthPicture]:
        """Return the pictures to combine, the preferred of equals first."""

    def own_uniforms(self, inputs: PassInputs) -> dict[str, object]:
        """Return further uniforms of the warp's own shader, by name."""
        return {}

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        into.bind_for_writing(_RESULT)
        self._best.bind_to_image(_BEST, read=True, write=True)
        own = self.own_uniforms(inputs)
        for index, picture in enumerate(self.pictures(inputs)):
            self._guesses.empty(self._pieces)
            self._guesses.scatter(picture.inverse_depth, picture.view, inputs.shown, _DEPTH)
            self._gather(picture, inputs.middle, own, is_first=index == 0)

    def _gather(self, picture: DepthPicture, shown: View, own: dict[str, object], *, is_first: bool) -> None:
        size = picture.colour.size
        back = view_map(shown, self.shown_size, picture.view, size)
        chosen = moderngl.NEAREST if back.moves_whole_pixels() else moderngl.LINEAR  # see bind_rendered_colour
        picture.colour.filter = (chosen, chosen)
        picture.colour.use(_COLOUR)
        limits = {"depth_tolerance": DEPTH_TOLERANCE, "depth_floor": DEPTH_FLOOR}
        sizes = {"rendered_size": size, "rendered_pixel": (1 / size[0], 1 / size[1]), "shown_size": self.shown_size}
        units = {"rendered_colour": _COLOUR, "rendered_depth": _DEPTH, "shown_colour": _RESULT, "best": _BEST}
        uniforms = {"H": back.H, "e": back.e, "guesses": _GUESSES, **units, **sizes, **limits, **own}
        if is_first:
            self._first.uniforms.set(**uniforms)
            self.gpu.barrier()
            self._first.run(*self.shown_size)
            return
        self._stamp = self._stamp % 0xFFFFFFFF + 1
        self._choose.uniforms.set(stamp=self._stamp, **uniforms)
        self.gpu.barrier()
        self._choose.run(*self.shown_size)
        self._more.uniforms.set(**uniforms)
        self.gpu.barrier()
        self._more.program.run_indirect(self._pieces)

    def close(self) -> None:
        self._guesses.close()
        release_all(self._pieces, self._best)
