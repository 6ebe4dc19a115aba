"""The last step of a chain, which leaves no pixel empty."""

from __future__ import annotations

from functools import partial

import numpy as np

from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill

_HEADER_BYTES = 32  # three work-group counts and one spare, then the mean


@fills.register
class Constant(Fill):
    """Give empty pixels the mean colour of the covered ones, or black if there are none."""

    name = "constant"
    summary = "whatever is left takes the mean colour of the picture: nothing stays empty"
    source = "the last resort of a chain: coverage 1 whatever came before"
    complete = True

    def prepare(self) -> None:
        compute = partial(self.gpu.shaders.compute, "fills/constant.comp")
        self._sum, self._fill = (compute(grid="shown", PASS=k) for k in (0, 2))
        self._mean = compute(PASS=1)
        self._columns = self.shown_size[0] * -(-self.shown_size[1] // self._sum.rows)
        self._sums = self.gpu.gl.buffer(bytes(_HEADER_BYTES + 16 * self._columns))

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        picture.colour.texture.bind_to_image(1, read=True, write=False)
        into.colour.bind_for_writing(0)
        if self._sum.skips:
            self._sums.clear()  # both eyes use it, and each hides other pixels
        groups = self._fill.groups(*self.shown_size)
        self._sums.write(np.array([*groups, 0, 0], np.uint32).tobytes())
        self._sums.bind_to_storage_buffer(0)
        for program in (self._sum, self._fill):
            program.uniforms.set(warped=1, filled=0, shown_size=self.shown_size)
        self._mean.uniforms.set(columns=self._columns)
        self._sum.run(*self.shown_size)
        self.gpu.barrier()
        self._mean.run(1)
        self.gpu.barrier()
        self._fill.program.run_indirect(self._sums)

    def close(self) -> None:
        self._sums.release()
