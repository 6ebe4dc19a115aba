"""Error by region: the holes of the warp, depth edges, and elsewhere.

Errors are summed over pictures; dB are never averaged.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .picture_pairs import check_pair, db_of

REGIONS = ("holes", "edges", "elsewhere")
SUMS = ("pixels", "squared_error", "flip")

# Across a plane inverse depth changes by the same step from pixel to pixel, whatever its slant.
# Where two planes meet, the step changes by at most the step of each alone: tan(80 deg) x 0.1 deg =
# 1 % of the inverse depth per pixel at 10 pixels per degree.
RELATIVE_STEP = 0.02
# 1/m. A head motion of 0.3 m shifts so small a difference by 0.6 mrad, less than a pixel of any
# headset: no visible edge.
LEAST_STEP = 0.002
EDGE_WIDTH_PX = 2


def region_of(coverage: NDArray[Any], truth_inverse_depth: NDArray[Any]) -> NDArray[np.uint8]:
    """Return the region of each pixel, (h, w), as an index into REGIONS.

    coverage: (h, w), after the warp and before the fill; 0 is a hole. truth_inverse_depth: (h, w)
    in 1/m, 0 or NaN = infinitely far.
    Errors: InputError unless both have one size.
    """
    if coverage.shape != truth_inverse_depth.shape or coverage.ndim != 2:
        shapes = f"{coverage.shape} and {truth_inverse_depth.shape}"
        raise InputError(
            f"coverage and the truth's inverse depth have shapes {shapes}: expected two of the same (h, w)"
        )
    region = np.where(near_discontinuity(truth_inverse_depth), np.uint8(1), np.uint8(2))
    region[np.asarray(coverage) == 0] = 0
    return region


def near_discontinuity(inverse_depth: NDArray[Any]) -> NDArray[np.bool_]:
    """Return the pixels, (h, w), within 2 pixels of a jump in depth, along a row, a column or both.

    A jump lies between two neighbours whose step continues neither the step before it nor the one
    after it, by more than two planes that meet could make: RELATIVE_STEP of the nearer one, at
    least LEAST_STEP. A wall seen at a grazing angle has none.
    """
    depth = np.nan_to_num(np.asarray(inverse_depth, dtype=np.float32), nan=0.0)
    near = np.zeros(depth.shape, bool)
    for axis in (0, 1):
        beside = np.moveaxis(near, axis, 1)  # a view: marking it marks `near`
        jump = _jumps(np.moveaxis(depth, axis, 1))
        beside[:, :-1] |= jump
        beside[:, 1:] |= jump
    return _grown(near, EDGE_WIDTH_PX - 1)


def _jumps(rows: NDArray[np.float32]) -> NDArray[np.bool_]:
    """Return the jumps between each pixel of a row and the next, (h, w - 1)."""
    step = np.diff(rows, axis=1)
    allowed = np.maximum(RELATIVE_STEP * np.maximum(np.abs(rows[:, :-1]), np.abs(rows[:, 1:])), LEAST_STEP)
    jump = np.abs(step) > allowed
    change = np.abs(np.diff(step, axis=1))
    # The end of a row has one step to continue. Two pixels have none: there a large step is a jump.
    jump[:, 1:] &= change > allowed[:, 1:]
    jump[:, :-1] &= change > allowed[:, :-1]
    return jump


def _grown(mask: NDArray[np.bool_], by: int) -> NDArray[np.bool_]:
    """Return the mask grown by `by` pixels, diagonals included."""
    for axis in (0, 1):
        source = np.moveaxis(mask, axis, 1)
        grown = source.copy()
        for shift in range(1, by + 1):
            grown[:, shift:] |= source[:, :-shift]
            grown[:, :-shift] |= source[:, shift:]
        mask = np.moveaxis(grown, 1, axis)
    return mask


def region_sums(
    shown: NDArray[Any],
    truth: NDArray[Any],
    coverage: NDArray[Any],
    truth_inverse_depth: NDArray[Any],
    flip_map: NDArray,
) -> dict[str, dict[str, float]]:
    """Return the SUMS of one picture by region.

    They are its pixels, the squared sRGB error over pixels and channels, and the FLIP error.
    Squared errors are summed in integers, so their order does not matter.

    shown, truth: (h, w, 3) uint8. The rest: (h, w), as region_of; flip_map 0..1.
    Errors: InputError for sizes that do not belong together.
    """
    check_pair(shown, truth)
    if shown.dtype != np.uint8 or not shown.shape[:2] == coverage.shape == flip_map.shape:
        found = f"{shown.dtype} pictures {shown.shape}, coverage {coverage.shape}, FLIP map {flip_map.shape}"
        raise InputError(f"{found}: expected uint8 (h, w, 3) and two (h, w)")
    region = region_of(coverage, truth_inverse_depth).ravel()
    difference = shown.astype(np.int32) - truth
    squared = np.einsum("hwc,hwc->hw", difference, difference).ravel()
    columns = (np.ones(region.size), squared, flip_map.ravel())  # float64 holds integers exactly up to 2^53
    sums = [np.bincount(region, weights=column, minlength=len(REGIONS)) for column in columns]
    return {
        name: {key: float(total[index]) for key, total in zip(SUMS, sums, strict=True)}
        for index, name in enumerate(REGIONS)
    }


def pooled(pictures: Iterable[Mapping[str, Mapping[str, float]]]) -> dict[str, dict[str, float | None]]:
    """Return, by region, its share of all pixels, and PSNR and mean FLIP over its own pixels.

    pictures: region_sums of each. Errors are pooled before the logarithm: a picture with a small
    region counts little. A region without pixels has None; without any picture `share` is None too.
    """
    totals = {name: dict.fromkeys(SUMS, 0.0) for name in REGIONS}
    for picture in pictures:
        for name in REGIONS:
            for key in SUMS:
                totals[name][key] += picture[name][key]
    everything = sum(total["pixels"] for total in totals.values())
    return {name: _figures(total, everything) for name, total in totals.items()}


def _figures(total: Mapping[str, float], everything: float) -> dict[str, float | None]:
    pixels = total["pixels"]
    if not pixels:
        return {"share": 0.0 if everything else None, "psnr_db": None, "flip": None}
    mean_square = total["squared_error"] / (3 * pixels) / 255**2
    return {"share": pixels / everything, "psnr_db": db_of(mean_square), "flip": total["flip"] / pixels}
