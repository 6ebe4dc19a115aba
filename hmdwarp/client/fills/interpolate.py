"""The thesis's fill: one pass of a median over the empty pixels."""

from __future__ import annotations

from typing import Any, Literal

import attrs

from ..inputs import PassInputs, ShownPicture
from . import fills
from ._base import Fill

WORKERS = 1 << 14  # invocations that share the list of holes


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

    @classmethod
    def needs_compute_for(cls, settings: Any) -> bool:
        """Return whether it runs over a list of holes, which larger kernels do."""
        return bool(settings.size > 3)

    def prepare(self) -> None:
        size, (wide, high) = self.settings.size, self.shown_size
        shaders = self.gpu.shaders
        if size == 3:
            self._program = shaders.compute("fills/interpolate.comp", grid="shown")
            self._list = self._holes = None
            return
        # Run for every pixel, a large kernel takes llvmpipe three to four times as long after
        # `forward`, where most holes are cracks.
        self._program = shaders.compute("fills/interpolate_listed.comp", SIZE=size)
        self._list = shaders.compute("fills/hole_list.comp", grid="shown", COPY=1)
        self._holes = self.gpu.gl.buffer(reserve=16 + 4 * wide * high)

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        picture.colour.texture.bind_to_image(1, read=True, write=False)
        into.colour.bind_for_writing(0)
        units, least = {"warped": 1, "filled": 0}, minimum_count(self.settings.size)
        if self._list is None or self._holes is None:
            self._program.uniforms.set(shown_size=self.shown_size, minimum_count=least, **units)
            self._program.run(*self.shown_size)
            return
        self._holes.write(bytes(16))
        self._holes.bind_to_storage_buffer(2)
        self._list.uniforms.set(shown_size=self.shown_size, **units)
        self._list.run(*self.shown_size)
        self.gpu.barrier()
        self._program.uniforms.set(minimum_count=least, **units)
        self._program.run(WORKERS)

    def close(self) -> None:
        if self._holes is not None:
            self._holes.release()
