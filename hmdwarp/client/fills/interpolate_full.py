"""The thesis's fill, repeated until no small hole remains."""

from __future__ import annotations

import attrs
import moderngl
import numpy as np

from ...gpu.textures import COLOUR, allocate, release_all
from ..fill_parts import HolePieces
from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill
from .interpolate import minimum_count

MOST_REACH = 1024


@attrs.frozen
class InterpolateFullSettings:
    # Most passes, so most pixels from a filled pixel to a covered one: it closes holes twice as
    # wide.
    reach: int = 16

    def __attrs_post_init__(self) -> None:
        if not 1 <= self.reach <= MOST_REACH:
            raise ValueError(f"reach={self.reach}: expected 1 to {MOST_REACH}")


@fills.register
class InterpolateFull(Fill):
    """The pass of `interpolate`, repeated in the parts that still have holes.

    It stops when nothing changes any more.
    """

    name = "interpolate_full"
    summary = "3x3 median passes until holes of up to 32 pixels are closed; wider ones get a rim"
    source = "the 2014 thesis's interpolation step, repeated"
    Settings = InterpolateFullSettings

    def prepare(self) -> None:
        gl, reach = self.gpu.gl, self.settings.reach
        self._program = self.gpu.shaders.compute("fills/interpolate_full.comp")
        self._pieces = HolePieces(self.gpu, self.name, self.shown_size, twice=True, hiding=self.hiding)
        self._other = allocate(gl, self.shown_size, COLOUR)
        self._untouched = np.tile(np.array([0, 1, 0, 0], np.uint32), reach + 1).tobytes()
        self._steps = gl.buffer(self._untouched)
        self._lists = [gl.buffer(reserve=4 * self._pieces.count) for _ in range(2)]
        self._listed, self._stamp = gl.buffer(bytes(4 * self._pieces.count)), 0

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        self._pieces.find(inputs.middle, picture, into, self._other)
        self._steps.write(self._untouched)
        self._pieces.list.bind_to_storage_buffer(0)
        self._steps.bind_to_storage_buffer(1)
        self._listed.bind_to_storage_buffer(4)
        reach = self.settings.reach
        for number in range(reach):
            # The last step writes `into`; where the steps stop early both pictures are the same.
            pictures = into.colour.texture, self._other
            to = (reach - 1 - number) % 2
            self._step(number, pictures[1 - to], pictures[to])

    def _step(self, number: int, before: moderngl.Texture, after: moderngl.Texture) -> None:
        self._stamp = self._stamp % (2**32 - 1) + 1
        before.bind_to_image(1, read=True, write=False)
        after.bind_to_image(0, read=False, write=True)
        self._lists[number % 2].bind_to_storage_buffer(2)
        self._lists[1 - number % 2].bind_to_storage_buffer(3)
        uniforms = {
            "shown_size": self.shown_size,
            "minimum_count": minimum_count(3),
            "step_number": number,
            "stamp": self._stamp,
        }
        self._program.uniforms.set(warped=1, filled=0, **uniforms)
        if number == 0:
            self._program.program.run_indirect(self._pieces.list)
        else:
            self._program.program.run_indirect(self._steps, offset=16 * number)
        self.gpu.barrier()

    def close(self) -> None:
        self._pieces.close()
        release_all(self._other, self._steps, self._listed, *self._lists)
