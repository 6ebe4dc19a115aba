"""Pairs of pictures of one type and size, (h, w, 3), RGB, sRGB-encoded, uint8 or floats 0..1.

Block means, which tell whether two pictures are the same; FLIP, SSIM and flicker on the GPU, whose
judges in the tests are libraries and float64.
"""

from __future__ import annotations

import base64
import functools
import math
from collections.abc import Sequence
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..base import NO_NUMBERS, InputError, linear_from_srgb
from ..geometry import View, WarpMap
from ..gpu import SCALAR, Compute, Gpu, allocate, flip_map
from ..gpu.textures import release_all

PSNR_CAP_DB = 100.0  # JSON has no infinity; one grey level in one byte of a 640x400 picture would be 107 dB


def check_pair(shown: NDArray[Any], truth: NDArray[Any]) -> None:
    """Raise InputError unless both are (h, w, 3), of one type, uint8 or finite floats in 0..1."""
    if shown.shape != truth.shape or shown.ndim != 3 or shown.shape[2] != 3 or shown.size == 0:
        raise InputError(
            f"cannot compare pictures of shapes {shown.shape} and {truth.shape}: expected two of the same (h, w, 3)"
        )
    if shown.dtype != truth.dtype:
        raise InputError(f"cannot compare a {shown.dtype} picture with a {truth.dtype} one: convert both to uint8 sRGB")
    if shown.dtype == np.uint8:
        return
    # NaN fails both comparisons.
    if shown.dtype.kind != "f" or not all(p.min() >= 0 and p.max() <= 1 for p in (shown, truth)):
        raise InputError(
            f"pictures of {shown.dtype} have values outside 0..1 (or NaN): expected uint8 or sRGB floats in 0..1"
        )


def pair_of(shown: ArrayLike, truth: ArrayLike) -> tuple[NDArray[Any], NDArray[Any]]:
    """Return both as arrays. Errors: InputError for what is none; as check_pair."""
    try:
        pair = np.asarray(shown), np.asarray(truth)
    except NO_NUMBERS as error:
        raise InputError(f"expected two pictures, (h, w, 3), found what is no array: {error}") from error
    check_pair(*pair)
    return pair


def error_image(shown: NDArray[Any], truth: NDArray[Any]) -> NDArray[np.float32]:
    """Return the signed error shown - truth, (h, w, 3) in -1..1; bytes count as 0..255 over 255."""
    scale = np.float32(255 if shown.dtype == np.uint8 else 1)
    return (shown.astype(np.float32) - truth.astype(np.float32)) / scale


@attrs.frozen(eq=False)
class Compared:
    """What the eye was shown and what it should have seen."""

    shown: NDArray[Any]  # both are sRGB pictures, (h, w, 3), top row first
    truth: NDArray[Any]
    view: View

    def __attrs_post_init__(self) -> None:
        check_pair(self.shown, self.truth)


def db_of(mean_square: float) -> float:
    """Return a mean squared error, 0..1, in dB, at most 100 dB."""
    return min(PSNR_CAP_DB, -10 * math.log10(mean_square)) if mean_square else PSNR_CAP_DB


_SSIM_SIGMA = 1.5


@attrs.frozen(eq=False)
class Alike:
    """What a PairPass finds of two pictures."""

    flip_map: NDArray[np.float32]  # (h, w) LDR-FLIP error, 0..1
    ssim: float  # mean structural similarity, at most 1, over all pixels and channels
    flicker: float | None = None  # as flicker; None where the pass did not find it


BLOCKS = 8  # on each side of a picture
# Levels of 255 by which the means of two correct drivers may differ. Rounding to a byte is one. A
# sampler with weights of 8 bits is off by 1/256 of what it mixes, on two axes: two levels, if that
# is black and white everywhere. A pixel may show the other side of an edge that passes within
# 1/256 of a pixel of its centre: two levels more, if an edge from black to white crosses each.
BOUND = 5.0
_STEPS = 256


def block_means(picture: NDArray[np.uint8]) -> NDArray[np.float64]:
    """Return the mean levels of BLOCKS x BLOCKS parts of a picture (h, w, 3), or each pixel."""
    rows, columns = (np.linspace(0, side, min(BLOCKS, side) + 1).astype(int) for side in picture.shape[:2])
    sums = np.add.reduceat(np.add.reduceat(picture, rows[:-1], axis=0, dtype=np.int64), columns[:-1], axis=1)
    means: NDArray[np.float64] = sums / (np.diff(rows)[:, None, None] * np.diff(columns)[None, :, None])
    return means


def blocks_text(blocks: NDArray[np.float64]) -> str:
    """Return the means as text, to 1/256 of a level: base64 of 16-bit numbers, low byte first."""
    return base64.b64encode(np.round(blocks * _STEPS).astype("<u2").tobytes()).decode()


def blocks_apart(first: str, second: str) -> float:
    """Return the largest difference of two blocks_text, in levels; inf for other sizes."""
    one, other = (np.frombuffer(base64.b64decode(text), "<u2").astype(np.float64) for text in (first, second))
    return float(np.abs(one - other).max(initial=0.0) / _STEPS) if one.shape == other.shape else math.inf


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
        self._earlier = np.zeros_like(self._bytes)
        # Pixels, light of bytes, what is filtered along rows, a map.
        self._pixels, self._before = (allocate(gl, (wide, 2 * high), (4, "u1")) for _ in range(2))
        self._light = allocate(gl, (256, 1), SCALAR)
        self._between, self._map = allocate(gl, (2 * wide, 3 * high), (4, "f4")), allocate(gl, size, SCALAR)
        self._light.write(linear_from_srgb(np.arange(256, dtype=np.uint8)).tobytes())
        constant = {"size": size, "sight": sight, "shape": shape, "white_from_rgb": _WHITE_FROM_RGB}
        compared = {**constant, "rgb_from_white": np.linalg.inv(_WHITE_FROM_RGB), "most": _green_from_blue()}
        bell = np.exp(-((np.arange(-5, 6) / _SSIM_SIGMA) ** 2) / 2)
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
        """Return the mean absolute change, 0..1, of the signed error between neighbouring frames.

        The two are compared at the same shown view direction: the homography of the rotation alone
        maps the previous error to the current view (sampled bilinearly). Error that is fixed to a
        direction in the world does not count as flicker while the head turns; error that jumps
        does. Pixels whose direction is outside the previous picture, and those that either view
        hides, are left out; None if none remains. Interpolation softens the previous error under
        rotation, so pixel-sharp error counts a little even when it is steady.
        """
        wide, high = self._size
        self._has_truth &= np.array_equal(self._bytes[0, ..., :3], now.truth)
        for held, texture, one in ((self._bytes, self._pixels, now), (self._earlier, self._before, before)):
            held[0, ..., :3], held[1, ..., :3] = one.truth, one.shown
            held[0, ..., 3] = ~one.view.seen(self._size)
            texture.write(held)
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
