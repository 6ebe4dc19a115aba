"""Fills from the picture's own pixels: none, their mean, the median of neighbours, stretching."""

from __future__ import annotations

from functools import partial
from typing import Any, Literal

import attrs
import numpy as np

from ...geometry import view_map
from ...gpu.textures import COLOUR, allocate, bind_images
from ..inputs import PassInputs, ShownPicture
from ..settings import limited
from . import fills
from ._base import Fill, HolePieces


@fills.register
class NoFill(Fill):
    """Leave every hole as it is; the plan leaves this pass out."""

    name = "none"
    is_pass = False

    def prepare(self) -> None:
        """Do nothing."""

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        raise AssertionError("the plan leaves this fill out")


_HEADER_BYTES = 32  # three work-group counts and one spare, then the mean


@fills.register
class Constant(Fill):
    """Give empty pixels the mean colour of the covered ones, or black if there are none."""

    name = "constant"
    complete = True

    def prepare(self) -> None:
        compute = partial(self.gpu.shaders.compute, "fills/constant.comp")
        self._sum, self._fill = (compute(grid="shown", PASS=k) for k in (0, 2))
        self._mean = compute(PASS=1)
        self._columns = self.shown_size[0] * -(-self.shown_size[1] // self._sum.rows)
        self._sums = self.own(self.gpu.gl.buffer(bytes(_HEADER_BYTES + 16 * self._columns)))

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        units = bind_images({"warped": picture.colour}, {"filled": into.colour})
        if self._sum.skips:
            self._sums.clear()  # both eyes use it, and each hides other pixels
        groups = self._fill.groups(*self.shown_size)
        self._sums.write(np.array([*groups, 0, 0], np.uint32).tobytes())
        self._sums.bind_to_storage_buffer(0)
        for program in (self._sum, self._fill):
            program.uniforms.set(shown_size=self.shown_size, **units)
        self._mean.uniforms.set(columns=self._columns)
        self._sum.run(*self.shown_size)
        self.gpu.barrier()
        self._mean.run(1)
        self.gpu.barrier()
        self._fill.program.run_indirect(self._sums)


WORKERS = 1 << 14  # invocations that share the list of holes


def minimum_count(size: int) -> int:
    """Return the least covered neighbours of a pixel that is filled, for a kernel of that size.

    3 of 8, 9 of 24, 18 of 48: three eighths of them. A pixel with fewer lies inside a hole, not in
    a crack: filling it would smear.
    """
    return 3 * (size**2 - 1) // 8


@attrs.frozen
class _InterpolateSettings:
    size: Literal[3, 5, 7] = 3  # Of the kernel, in pixels.


@fills.register
class Interpolate(Fill):
    """Give an empty pixel with enough covered neighbours their median, by channel.

    Of a kernel of 3x3 three of the eight are enough; of a larger one as many in proportion.
    """

    name = "interpolate"
    needs_compute = False
    Settings = _InterpolateSettings
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
            self._list = None
            return
        # Run for every pixel, a large kernel takes llvmpipe three to four times as long after
        # `forward`, where most holes are cracks.
        self._program = shaders.compute("fills/interpolate_listed.comp", SIZE=size)
        self._list = shaders.compute("fills/hole_list.comp", grid="shown", COPY=1)
        self._holes = self.own(self.gpu.gl.buffer(reserve=16 + 4 * wide * high))

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        units = bind_images({"warped": picture.colour}, {"filled": into.colour})
        least = minimum_count(self.settings.size)
        if self._list is None:
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


_LEAST_PARALLAX = 0.25  # pixels at 1 m; below this no hole is a pixel wide unless an object is nearer than 25 cm


@attrs.frozen
class _StretchSettings:
    """How streaks are smoothed, and what is one surface: see depth_limits of warps/gather.py."""

    # Pixels of smoothing per pixel of distance from the start of the streak, if that is at least
    # one pixel; 0: none.
    spread: float = limited(0.1)
    tolerance: float = limited(0.1)
    floor: float = limited(0.02)  # 1/m


@fills.register
class Stretch(Fill):
    """Follow the epipolar line of an empty pixel to both edges of the hole; take the farther one.

    Pixels outside the rendered picture stay empty: they were not occluded, and their line leads
    nowhere. `stretch+pyramid` fills them too.
    """

    name = "stretch"
    reads = ("shown.colour", "shown.inverse_depth")
    writes = ("shown.colour", "shown.inverse_depth")
    Settings = _StretchSettings

    def prepare(self) -> None:
        self._draw, self._smooth = (self.gpu.shaders.compute("fills/stretch.comp", PASS=k) for k in range(2))
        self._pieces = self.own(HolePieces(self.gpu, self.name, self.shown_size, with_depth=True))
        self._streaks = self.own(allocate(self.gpu.gl, self.shown_size, COLOUR))

    def run(self, inputs: PassInputs, picture: ShownPicture, into: ShownPicture) -> None:
        stamp, chosen = self._pieces.find(picture, into), self.settings
        forward = view_map(inputs.rendered.view, self.rendered_size, inputs.middle, self.shown_size)
        back = view_map(inputs.middle, self.shown_size, inputs.rendered.view, self.rendered_size)
        read, write = {"warped": picture.colour, "warped_depth": picture.depth}, {"filled": into.colour}
        both = bind_images(read, write, {"filled_depth": into.depth, "streaks": self._streaks})
        both |= {"shown_size": self.shown_size, "e": forward.e, "least_parallax": _LEAST_PARALLAX}
        both |= {"depth_tolerance": chosen.tolerance, "depth_floor": chosen.floor}
        views = {"back_H": back.H, "back_e": back.e, "rendered_size": self.rendered_size}
        for program, own in ((self._draw, {"stamp": stamp, **views}), (self._smooth, {"spread": chosen.spread})):
            program.uniforms.set_declared(**both, **own)
            self._pieces.run(program)
