"""The thesis's fill: one 3x3 median pass over the empty pixels."""

from __future__ import annotations

from typing import TYPE_CHECKING

from . import fills
from ._base import Fill

if TYPE_CHECKING:
    from ..inputs import PassInputs
    from ..shown_picture import ShownPicture

# A pixel with fewer covered neighbours lies inside a hole, not in a crack: filling it would smear.
MINIMUM_COUNT = 3


@fills.register
class Interpolate(Fill):
    """Give an empty pixel with at least three covered neighbours their median, by channel."""

    name = "interpolate"
    needs_compute = False
    summary = "one 3x3 median pass: closes cracks, leaves wide holes"
    source = "the 2014 thesis's interpolation step"

    def prepare(self) -> None:
        self._program = self.gpu.shaders.compute("fills/interpolate.comp")

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        picture.colour.texture.bind_to_image(1, read=True, write=False)
        into.colour.bind_for_writing()
        self._program.uniforms.set(warped=1, filled=0, shown_size=self.shown_size, minimum_count=MINIMUM_COUNT)
        self._program.run(*self.shown_size)
