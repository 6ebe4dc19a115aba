"""FLIP on the GPU, of pictures of one size; flip-evaluator is its judge in the tests."""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb
from ..gpu import Gpu
from .picture_pairs import check_pair

Array = NDArray[np.float64]
# Of sRGB with white D65, as flip-evaluator has it.
_XYZ_FROM_RGB = np.array(
    [
        [10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
        [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
        [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382],
    ]
)
_WHITE_FROM_RGB = _XYZ_FROM_RGB / _XYZ_FROM_RGB.sum(axis=1, keepdims=True)
# Contrast sensitivity as sums of Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b), x in degrees: (a, b).
_SIGHT = (((1.0, 0.0047),), ((1.0, 0.0053),), ((34.1, 0.04), (13.5, 0.025)))
_FEATURE_DEG = 0.082
_POWER = 0.7


def _kernels(pixels_per_degree: float) -> tuple[int, Array, Array]:
    """Return the radius, and the weights of (Y, Cx, Cz, Cz) and of (smooth, edge, point)."""
    spread = 0.5 * _FEATURE_DEG * pixels_per_degree
    far = math.ceil(3 * math.sqrt(0.04 / (2 * math.pi**2)) * pixels_per_degree), math.ceil(3 * spread)
    k = np.arange(-max(far), max(far) + 1)
    sight = []
    for parts in _SIGHT:
        gaussians = [
            np.sqrt(a * np.sqrt(np.pi / b)) * np.exp(-((np.pi * k / pixels_per_degree) ** 2) / b) * (abs(k) <= far[0])
            for a, b in parts
        ]
        sight += [one / np.sqrt(sum(other.sum() ** 2 for other in gaussians)) for one in gaussians]
    # In float32, as the library has it: below two pixels a degree it has no neighbours.
    bell = np.exp(-((k / spread) ** 2) / 2).astype(np.float32).astype(np.float64) * (abs(k) <= far[1])
    shapes = [bell / bell.sum()]
    for form in (-k * bell, ((k / spread) ** 2 - 1) * bell):
        sums = np.where(form < 0, -form[form < 0].sum(), form[form > 0].sum())
        shapes.append(np.divide(form, sums, out=np.zeros_like(form), where=sums > 0))
    return max(far), np.stack(sight, axis=1), np.stack(shapes, axis=1)


@functools.cache
def _green_from_blue() -> float:
    """Return the colour difference of green and blue, the largest there is, to the power."""
    found = []
    for rgb in ((0, 1, 0), (0, 0, 1)):
        w = _WHITE_FROM_RGB @ rgb
        f = np.where(w > 216 / 24389, np.cbrt(w), w / (108 / 841) + 4 / 29)
        lightness = 116 * f[1] - 16
        found.append(np.array([lightness, 5 * lightness * (f[0] - f[1]), 2 * lightness * (f[1] - f[2])]))
    apart = found[0] - found[1]
    return float((abs(apart[0]) + np.hypot(*apart[1:])) ** _POWER)


class FlipPass:
    """Measures pairs of byte pictures; see picture_pairs.flip, whose numbers it gives."""

    def __init__(self, gpu: Gpu, size: tuple[int, int], pixels_per_degree: float) -> None:
        self._gpu, self._size = gpu, size
        radius, sight, shape = _kernels(pixels_per_degree)
        self._rows = gpu.shaders.compute("metrics/flip_rows.comp", RADIUS=radius)
        self._columns = gpu.shaders.compute("metrics/flip.comp", RADIUS=radius)
        count = size[0] * size[1]
        light = linear_from_srgb(np.arange(256, dtype=np.uint8)).astype(np.float32)
        self._pixels = np.zeros((2, size[1], size[0], 4), np.uint8)
        buffer = gpu.gl.buffer
        self._buffers = [
            buffer(reserve=8 * count, dynamic=True), buffer(light.tobytes()), buffer(reserve=32 * count),
            buffer(reserve=32 * count), buffer(reserve=4 * count),
        ]  # fmt: skip
        self._constant = {"size": size, "sight": sight, "shape": shape, "white_from_rgb": _WHITE_FROM_RGB}
        self._compared = {"rgb_from_white": np.linalg.inv(_WHITE_FROM_RGB), "most": _green_from_blue()}

    def run(self, shown: NDArray[Any], truth: NDArray[Any]) -> NDArray[np.float32]:
        """Return the FLIP error of each pixel, (h, w), 0..1.

        shown, truth: (h, w, 3) uint8 sRGB of the size. Errors: InputError as check_pair.
        """
        check_pair(shown, truth)
        self._pixels[0, ..., :3], self._pixels[1, ..., :3] = truth, shown
        self._buffers[0].write(self._pixels)
        for binding, buffer in enumerate(self._buffers):
            buffer.bind_to_storage_buffer(binding)
        wide, high = self._size
        self._rows.uniforms.set(**self._constant)
        self._rows.run(-(-wide // 4), 2 * high)
        self._gpu.barrier()
        self._columns.uniforms.set(**self._constant, **self._compared)
        self._columns.run(wide, high)
        self._gpu.barrier()
        return np.frombuffer(self._buffers[-1].read(), np.float32).reshape(high, wide)

    def close(self) -> None:
        """Free the buffers."""
        for buffer in self._buffers:
            buffer.release()
