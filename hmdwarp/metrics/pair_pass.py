"""FLIP, SSIM and flicker on the GPU; libraries and float64 are the judges in the tests."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..colour import linear_from_srgb
from ..geometry import WarpMap
from ..gpu import SCALAR, Gpu, allocate, flip_map
from ..gpu.shaders import Compute
from ..gpu.textures import release_all
from .metric import Compared
from .picture_pairs import SSIM_SIGMA, Alike, check_pair

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


class PairPass:
    """Measures pairs of byte pictures of one size."""

    def __init__(self, gpu: Gpu, size: tuple[int, int], pixels_per_degree: float) -> None:
        self._gpu, self._size = gpu, size
        radius, sight, shape = _kernels(pixels_per_degree)
        (wide, high), gl = size, gpu.gl
        # Of both pictures, the truth first, whose filtered rows stay for the next picture.
        self._bytes, self._has_truth = np.zeros((2, high, wide, 4), np.uint8), False
        self._earlier, self._earlier_truth = np.zeros_like(self._bytes), np.empty(0)
        # Pixels, light of bytes, what is filtered along rows, a map.
        self._pixels, self._before = (allocate(gl, (wide, 2 * high), (4, "u1")) for _ in range(2))
        self._light = allocate(gl, (256, 1), SCALAR)
        self._between, self._map = allocate(gl, (2 * wide, 3 * high), (4, "f4")), allocate(gl, size, SCALAR)
        self._light.write(linear_from_srgb(np.arange(256, dtype=np.uint8)).tobytes())
        constant = {"size": size, "sight": sight, "shape": shape, "white_from_rgb": _WHITE_FROM_RGB}
        compared = {**constant, "rgb_from_white": np.linalg.inv(_WHITE_FROM_RGB), "most": _green_from_blue()}
        bell = np.exp(-((np.arange(-5, 6) / SSIM_SIGMA) ** 2) / 2)
        window = {"size": size, "bell": bell / bell.sum()}
        compute = gpu.shaders.compute
        self._flip = (
            (compute("metrics/flip_rows.comp", RADIUS=radius), constant, -(-wide // 4)),
            (compute("metrics/flip.comp", RADIUS=radius), compared, wide),
        )
        self._ssim = (
            (compute("metrics/ssim_rows.comp"), window, -(-wide // 2)),
            (compute("metrics/ssim.comp"), window, wide),
        )
        self._change = compute("metrics/flicker.comp")

    def run(self, shown: NDArray[Any], truth: NDArray[Any]) -> Alike:
        """Return how alike two pictures are.

        shown, truth: (h, w, 3) uint8 sRGB of the size. Errors: InputError as check_pair.
        """
        check_pair(shown, truth)
        high = self._size[1]
        first = high if self._has_truth and np.array_equal(self._bytes[0, ..., :3], truth) else 0
        self._bytes[0, ..., :3], self._bytes[1, ..., :3] = truth, shown
        self._pixels.write(self._bytes)
        for unit, texture in enumerate((self._pixels, self._light, self._between, self._map)):
            texture.bind_to_image(unit, read=unit < 3, write=unit > 1)
        flip_map = self._made(self._flip, 2 * high - first, first=first)
        self._has_truth = True
        return Alike(flip_map, 1 - float(self._made(self._ssim, high).mean(dtype=np.float64)))

    def flicker(self, now: Compared, before: Compared) -> float | None:
        """Return the flicker of the pictures of the last run against those before them.

        None where metrics.flicker has to find it: views that hide pixels, and other sizes.
        """
        wide, high = self._size
        if before.shown.shape != (high, wide, 3) or not (now.view.hidden is before.view.hidden is None):
            return None
        if before.truth is not self._earlier_truth:
            self._earlier[0, ..., :3] = self._earlier_truth = before.truth
        self._earlier[1, ..., :3] = before.shown
        self._before.write(self._earlier)
        for unit, texture in ((0, self._pixels), (2, self._before), (3, self._map)):
            texture.bind_to_image(unit, read=unit < 3, write=unit == 3)
        turn = WarpMap.between(now.view, self._size, before.view, self._size).H
        self._change.uniforms.set(size=self._size, before_from_now=flip_map(turn, high))
        self._change.run(wide, high)
        self._gpu.barrier()
        found = self._read_map()
        there = found[found >= 0]
        return float(there.mean(dtype=np.float64)) if there.size else None

    def _made(
        self, programs: Sequence[tuple[Compute, dict[str, Any], int]], lines: int, **more: int
    ) -> NDArray[np.float32]:
        """Filter so many rows, then along columns; return the map."""
        (rows, row_values, along_rows), (columns, values, wide) = programs
        high = self._size[1]
        rows.uniforms.set(**row_values, **more)
        rows.run(along_rows, lines)
        self._gpu.barrier()
        columns.uniforms.set(**values)
        columns.run(wide, high)
        self._gpu.barrier()
        return self._read_map()

    def _read_map(self) -> NDArray[np.float32]:
        return np.frombuffer(self._map.read(), np.float32).reshape(self._size[::-1])

    def close(self) -> None:
        """Free the textures."""
        release_all(self._pixels, self._before, self._light, self._between, self._map)
