"""Pairs of pictures of one type and size, (h, w, 3), RGB, sRGB-encoded, uint8 or floats 0..1.

Block means, which tell whether two pictures are the same; pixel centres.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator
from typing import Any

import attrs
import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..errors import NO_NUMBERS, InputError
from ..geometry import View, WarpMap
from ..gpu import flip_rows

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


def db_of(mean_square: float) -> float:
    """Return a mean squared error, 0..1, in dB, at most 100 dB."""
    return min(PSNR_CAP_DB, -10 * math.log10(mean_square)) if mean_square else PSNR_CAP_DB


# 32 rows keep float64 temporaries of a 2064x2208 eye under 10 MB, and every matrix product below
# OpenBLAS's threading threshold: with threads its last bits could depend on the load of the
# machine.
_ROWS = 32


def row_blocks(height: int) -> Iterator[slice]:
    """Yield slices of rows that together are 0..height."""
    return (slice(start, min(start + _ROWS, height)) for start in range(0, height, _ROWS))


def pixel_centres(rows: slice, width: int) -> NDArray[np.float64]:
    """Return the pixel coordinates x, y of the centres: (rows, width, 2), bottom row first."""
    x = np.arange(width) + 0.5
    y = np.arange(rows.start, rows.stop) + 0.5
    return np.stack(np.broadcast_arrays(x[None, :], y[:, None]), axis=-1)


SSIM_SIGMA = 1.5


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


# The nearest pixel of the other eye may lie half a pixel from the point on each axis. On a
# surface slanted by up to 80 degrees, at 10 pixels per degree, that is 1 % of its inverse depth.
# Surfaces that occlude each other differ by more.
DEPTH_TOLERANCE = 0.02
DEPTH_FLOOR = 0.002  # 1/m: differences below this count as equal


@attrs.frozen
class Mismatch:
    """Counts of left-eye pixels."""

    seen_by_both: int = 0  # pixels whose surface both eyes see
    one_eyed: int = 0  # of these, the holes for exactly one eye

    def __add__(self, other: Mismatch) -> Mismatch:
        return Mismatch(self.seen_by_both + other.seen_by_both, self.one_eyed + other.one_eyed)

    @property
    def share(self) -> float | None:
        """Holes for exactly one eye as a share, 0..1, of what both eyes see; None without any."""
        return self.one_eyed / self.seen_by_both if self.seen_by_both else None


class SharedSurface:
    """Pixels of the two eyes that show the same surface point, from the truth alone.

    Each left pixel goes through the warp map to the right eye, and is visible there if that eye's
    own depth at the nearest pixel is the same. left, right: the shown views. left_inverse_depth,
    right_inverse_depth: the truth's, (h, w) of one size, top row first, in 1/m, 0 or NaN =
    infinitely far. Errors: InputError unless the two have one size.
    """

    def __init__(
        self, left: View, right: View, left_inverse_depth: NDArray[Any], right_inverse_depth: NDArray[Any]
    ) -> None:
        shape = left_inverse_depth.shape
        if shape != right_inverse_depth.shape or len(shape) != 2:
            shapes = f"{shape} and {right_inverse_depth.shape}"
            raise InputError(f"the eyes' inverse depths have shapes {shapes}: expected two of the same (h, w)")
        height, width = self._shape = shape
        here, there = (
            np.nan_to_num(flip_rows(np.asarray(d, np.float64))) for d in (left_inverse_depth, right_inverse_depth)
        )
        there = there.ravel()
        mapping = WarpMap.between(left, (width, height), right, (width, height))
        mine, theirs = [], []
        for rows in row_blocks(height):
            pixel, inverse_depth, _ = mapping.apply(pixel_centres(rows, width), here[rows])
            with np.errstate(invalid="ignore"):  # NaN: out of view of the right eye
                inside = (pixel >= 0).all(axis=-1) & (pixel < (width, height)).all(axis=-1)
            x, y = np.floor(pixel[inside]).astype(np.int64).T
            index, inverse_depth = y * width + x, inverse_depth[inside]
            same = np.abs(there[index] - inverse_depth) <= np.maximum(DEPTH_TOLERANCE * inverse_depth, DEPTH_FLOOR)
            mine.append((np.flatnonzero(inside) + rows.start * width)[same])
            theirs.append(index[same])
        self._left, self._right = np.concatenate(mine), np.concatenate(theirs)

    def compare(self, left_coverage: NDArray[Any], right_coverage: NDArray[Any]) -> Mismatch:
        """Compare the holes (0) of one warp's two coverages, (h, w), top row first.

        Errors: InputError for another size than the depths had.
        """
        if not left_coverage.shape == right_coverage.shape == self._shape:
            raise InputError(
                f"coverages have shapes {left_coverage.shape} and {right_coverage.shape}: expected {self._shape}"
            )
        holes = [(flip_rows(np.asarray(c)) == 0).ravel() for c in (left_coverage, right_coverage)]
        return Mismatch(len(self._left), int(np.count_nonzero(holes[0][self._left] != holes[1][self._right])))
