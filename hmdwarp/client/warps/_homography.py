"""What the warps through one homography share: a single bilinear look per pixel."""

from __future__ import annotations

from abc import abstractmethod
from typing import TYPE_CHECKING

import moderngl

from ...geometry import WarpMap
from ._base import Warp

if TYPE_CHECKING:
    from ...frame import EyeImage
    from ...geometry import View
    from ...gpu.textures import Canvas


def bind_late_colour(late: EyeImage, unit: int, *, whole_pixels: bool) -> None:
    """Bind the late colour for bilinear looks; for nearest ones where every look falls on a pixel centre.

    Bilinear hardware computes the centre's coordinate with an error of up to 1e-4 pixels (llvmpipe) or 1/512 (GPUs), enough to
    change the last bit of a dark pixel beside a bright one; so an unmoved head is given nearest looks and is bit-exact.
    """
    chosen = moderngl.NEAREST if whole_pixels else moderngl.LINEAR
    late.colour.filter = (chosen, chosen)
    late.colour.use(unit)


class HomographyWarp(Warp):
    """A gather through a 3x3 matrix that does not depend on depth."""

    kind = "gather"
    reads = ("late.colour",)

    def prepare(self) -> None:
        self._program = self.gpu.shaders.compute("warps/rotation.comp")

    @abstractmethod
    def relative_map(self, late: View, shown: View) -> WarpMap:
        """The map from shown to rendered pixels whose H is looked through."""

    def run(self, late: EyeImage, shown: View, into: Canvas, client_inverse_depth: moderngl.Texture | None = None) -> None:
        gather = self.relative_map(late.view, shown)
        bind_late_colour(late, 0, whole_pixels=gather.moves_whole_pixels())
        into.bind_for_writing()
        self.set_sizes(self._program)
        self._program.uniforms.set(H=gather.H, late_colour=0, shown_colour=0)
        self._program.run(*self.shown_size)
