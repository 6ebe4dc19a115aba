"""Mismatch: holes that only one eye sees. The rivalry is worse than a hole in both eyes."""

from __future__ import annotations

from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from ..geometry import View, WarpMap
from ..gpu import flip_rows
from .picture_pairs import pixel_centres, row_blocks

# The nearest pixel of the other eye may lie half a pixel from the point on each axis. On a
# surface slanted by up to 80 degrees, at 10 pixels per degree, that is 1 % of its inverse depth.
# Surfaces that occlude each other differ by more.
DEPTH_TOLERANCE = 0.02
DEPTH_FLOOR = 0.002  # 1/m: differences below this count as equal


@attrs.frozen
class Mismatch:
    """Counts of left-eye pixels."""

    # Pixels whose surface both eyes see.
    seen_by_both: int = 0
    # Of these, the holes for exactly one eye.
    one_eyed: int = 0

    def __add__(self, other: Mismatch) -> Mismatch:
        return Mismatch(self.seen_by_both + other.seen_by_both, self.one_eyed + other.one_eyed)

    @property
    def share(self) -> float | None:
        """Holes for exactly one eye as a share, 0..1, of what both eyes see; None without any."""
        return self.one_eyed / self.seen_by_both if self.seen_by_both else None


class SharedSurface:
    """Pixels of the two eyes that show the same surface point, from the truth alone.

    Made once per refresh; comparing the holes of each warp is then quick. Each left pixel goes
    through the warp map to the right eye. It is visible there if the right eye's own depth at the
    nearest pixel is the same.

    left, right: the shown views. left_inverse_depth, right_inverse_depth: the truth's, (h, w) of
    one size, top row first, in 1/m, 0 or NaN = infinitely far.
    Errors: InputError unless the two have one size.
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
        """Compare the holes of one warp's two pictures.

        Coverages: (h, w), after the warp and before the fill, top row first; 0 is a hole.
        Errors: InputError for another size than the depths had.
        """
        if not left_coverage.shape == right_coverage.shape == self._shape:
            raise InputError(
                f"coverages have shapes {left_coverage.shape} and {right_coverage.shape}: expected {self._shape}"
            )
        holes = [(flip_rows(np.asarray(c)) == 0).ravel() for c in (left_coverage, right_coverage)]
        return Mismatch(len(self._left), int(np.count_nonzero(holes[0][self._left] != holes[1][self._right])))
