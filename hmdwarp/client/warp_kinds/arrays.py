"""The kind of warps that are Python on NumPy arrays."""

from __future__ import annotations

from abc import abstractmethod
from contextlib import nullcontext
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...colour import linear_from_srgb
from ...errors import InputError
from ...frames.layers import PICTURE
from ...geometry import View
from ...gpu.textures import Canvas, download, upload
from ..inputs import PassInputs
from ..warps import Warp


class ArrayWarp(Warp):
    """A warp whose subclass defines warp(): arrays in, arrays out, row 0 at the top.

    Its stage `warp` times warp() alone, not the copies from and to the GPU.
    """

    kind = "scatter"
    reads = PICTURE
    _is_timed = False

    def prepare(self) -> None:
        """Do nothing: a subclass may load a model here."""

    @abstractmethod
    def warp(self, colour: Any, depth_m: Any, rendered: View, shown: View, /) -> tuple[ArrayLike, ArrayLike]:
        """Return colour and coverage of the view `shown`, of self.shown_size (w, h).

        colour: (h, w, 3) float32 linear light; depth_m: (h, w) float32 metres along -z, inf
        infinitely far, NaN a hole. Both are the warp's own to change. Return colour as floats of
        linear light or as uint8 sRGB, (h, w, 3), and coverage (h, w), 0 in holes.
        """

    def arrays(self, inputs: PassInputs) -> tuple[Any, ...]:
        """Return the arguments of warp()."""
        rendered = inputs.rendered
        colour, inverse = np.array(download(rendered.colour), np.float32), download(rendered.inverse_depth)
        with np.errstate(divide="ignore", over="ignore"):
            depth_m = np.float32(1) / np.where((inverse >= 0) & (colour[..., 3] > 0), np.abs(inverse), np.nan)
        return colour[..., :3].copy(), depth_m, rendered.view, inputs.shown

    def run(self, inputs: PassInputs, into: Canvas) -> None:
        given, shape = self.arrays(inputs), into.size[::-1]
        with self.gpu.timer.cpu_stage("warp") if self._is_timed else nullcontext():
            colour, coverage = map(np.asarray, self.warp(*given))
        if colour.shape != (*shape, 3) or coverage.shape != shape:
            raise InputError(
                f"warp '{self.name}' returned colour {colour.shape} and coverage {coverage.shape}: "
                f"expected {(*shape, 3)} and {shape}"
            )
        light: Any = linear_from_srgb(colour) if colour.dtype == np.uint8 else colour
        covered = (coverage != 0) & np.isfinite(light).all(axis=2)
        most = np.finfo(np.float16).max
        upload(into.texture, np.dstack([np.where(covered[..., None], light.clip(-most, most), 0), covered]))

    def __enter__(self) -> None:
        self._is_timed = True

    def __exit__(self, *_: object) -> None:
        self._is_timed = False

    def stage(self) -> ArrayWarp:
        """Return itself: what times its call alone."""
        return self
