"""The thesis's fill: one pass of a median over the empty pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

import attrs

from . import fills
from ._base import Fill

if TYPE_CHECKING:
    from ..inputs import PassInputs
    from ..shown_picture import ShownPicture


def minimum_count(size: int) -> int:
    """Return the least covered neighbours of a pixel that is filled, for a kernel of that size.

    3 of 8, 9 of 24, 18 of 48: three eighths of them. A pixel with fewer lies inside a hole, not in
    a crack: filling it would smear.
    """
    return 3 * (size**2 - 1) // 8


@attrs.frozen
class InterpolateSettings:
    size: Literal[3, 5, 7] = 3  # Of the kernel, in pixels.


@fills.register
class Interpolate(Fill):
    """Give an empty pixel with enough covered neighbours their median, by channel.

    Of a kernel of 3x3 three of the eight are enough; of a larger one as many in proportion.
    """

    name = "interpolate"
    needs_compute = False
    summary = "one 3x3 median pass: closes cracks, leaves wide holes"
    source = "the 2014 thesis's interpolation step"
    Settings = InterpolateSettings
    variants = ("size=5", "size=7")

    def prepare(self) -> None:
        self._program = self.gpu.shaders.compute("fills/interpolate.comp", SIZE=self.settings.size)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        picture.colour.texture.bind_to_image(1, read=True, write=False)
        into.colour.bind_for_writing()
        least = minimum_count(self.settings.size)
        self._program.uniforms.set(warped=1, filled=0, shown_size=self.shown_size, minimum_count=least)
        self._program.run(*self.shown_size)
