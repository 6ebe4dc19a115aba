"""One picture to measure: its inputs, the measurement and all its figures."""

from __future__ import annotations

import enum
import functools
from collections.abc import Iterable, Mapping
from typing import Any, TypeVar

import attrs
import numpy as np
from numpy.typing import NDArray

from ..errors import HmdwarpError, InputError
from ..geometry import View, WarpMap
from ..gpu import flip_rows
from .picture_pairs import Alike, check_pair, db_of, error_image, row_blocks

T = TypeVar("T")


class Input(enum.Flag):
    """What a metric is computed from."""

    TRUTH = enum.auto()  # the picture without latency
    COVERAGE = enum.auto()  # which pixels the warp covered, before the fill
    DEPTH = enum.auto()  # inverse depth of the truth
    RENDERED = enum.auto()  # the view the late frame was rendered for
    PREVIOUS = enum.auto()  # the neighbouring frame of the same eye
    ALIKE = enum.auto()  # what a PairPass has found


_PLACES = Input.COVERAGE | Input.DEPTH | Input.RENDERED  # what tells where an error is


@attrs.frozen(eq=False)
class Compared:
    """What the eye was shown and what it should have seen."""

    shown: NDArray[Any]  # sRGB pictures, (h, w, 3), top row first
    truth: NDArray[Any]
    view: View

    def __attrs_post_init__(self) -> None:
        check_pair(self.shown, self.truth)

    @property
    def error(self) -> NDArray[np.float32]:
        """The signed error image."""
        return error_image(self.shown, self.truth)


def _covered(coverage: NDArray[Any] | None) -> NDArray[np.bool_] | None:
    return None if coverage is None else np.asarray(coverage) != 0


@attrs.frozen(eq=False)
class QualityJob:
    """One eye of one frame to measure. Inputs that are None leave out the metrics that need them.

    Errors: InputError for sizes that do not belong together.
    """

    now: Compared  # after the fill, before the lens
    previous: Compared | None = None  # the neighbouring frame of the same eye
    # (h, w), coverage after the warp and before the fill; anything but 0 is covered.
    covered: NDArray[np.bool_] | None = attrs.field(default=None, converter=_covered)
    truth_inverse_depth: NDArray[Any] | None = None  # (h, w), 1/m in the shown view, top row first
    rendered: View | None = None  # view and (w, h) of the late frame
    rendered_size: tuple[int, int] | None = None
    rendered_picture: NDArray[Any] | None = None  # the late frame's, for reports only
    alike: Alike | None = None  # FLIP, SSIM and flicker, where a PairPass has found them
    # (name, picture, FLIP map as bytes) of other warps on the same late frame, for reports only.
    beside: tuple[tuple[str, NDArray[Any], NDArray[np.uint8]], ...] = ()
    error_map: bool = False  # whether the result has the FLIP map
    # Whether the result says where the error is; this needs coverage, depth and the rendered view.
    regions: bool = False

    def __attrs_post_init__(self) -> None:
        size = self.now.shown.shape[:2]
        flip_map = None if self.alike is None else self.alike.flip_map
        depth = self.truth_inverse_depth
        for name, array in (("coverage", self.covered), ("truth inverse depth", depth), ("FLIP map", flip_map)):
            if array is not None and array.shape != size:
                raise InputError(f"{name} is {array.shape}, the picture {size}: expected the same (h, w)")
        if self.regions and _PLACES not in self.inputs:
            raise InputError(
                "regions of the error need the coverage, the truth's inverse depth and the rendered view: pass all"
            )

    @property
    def flicker(self) -> float | None:
        """Flicker that a PairPass has found, in place of the frame before; None: it has not."""
        return None if self.alike is None else self.alike.flicker

    @property
    def inputs(self) -> Input:
        """The inputs of metrics that the job has."""
        there = Input.TRUTH
        for flag, value in (
            (Input.COVERAGE, self.covered),
            (Input.DEPTH, self.truth_inverse_depth),
            (Input.RENDERED, None if self.rendered is None else self.rendered_size),
            (Input.PREVIOUS, self.flicker if self.previous is None else self.previous),
            (Input.ALIKE, self.alike),
        ):
            if value is not None:
                there |= flag
        return there


@attrs.frozen(eq=False)
class QualityResult:
    """The figures of one job."""

    values: dict[str, float | None]  # by metric; None where nothing could be measured
    error_map: NDArray[np.uint8] | None = None  # (h, w) bytes, FLIP 0..1 as 0..255, if the job requests it
    regions: dict[str, dict[str, float]] | None = None  # as region_sums, if the job requests it


class Measurement:
    """A job under measurement: the inputs of metrics, and intermediate results that several share.

    Errors: HmdwarpError for an input that the job lacks, because the metric does not declare it.
    """

    def __init__(self, job: QualityJob) -> None:
        self._job, self.now = job, job.now

    @functools.cached_property
    def seen(self) -> NDArray[np.bool_]:
        """(h, w): what the lens does not hide; the rest is black in both pictures."""
        high, wide = self.now.shown.shape[:2]
        return self.now.view.seen((wide, high))

    @property
    def alike(self) -> Alike:
        """FLIP and SSIM."""
        return _declared(self._job.alike, Input.ALIKE)

    @property
    def flicker(self) -> float | None:
        """Flicker, where it is known."""
        return self._job.flicker

    @property
    def previous(self) -> Compared:
        """The neighbouring frame."""
        return _declared(self._job.previous, Input.PREVIOUS)

    @property
    def covered(self) -> NDArray[np.bool_]:
        """(h, w): where the warp left no hole."""
        return _declared(self._job.covered, Input.COVERAGE)

    @property
    def truth_inverse_depth(self) -> NDArray[Any]:
        """(h, w), 1/m."""
        return _declared(self._job.truth_inverse_depth, Input.DEPTH)

    @functools.cached_property
    def border_holes(self) -> NDArray[np.bool_]:
        """(h, w): holes beyond what the late frame shows."""
        rendered = _declared(self._job.rendered, Input.RENDERED)
        size = _declared(self._job.rendered_size, Input.RENDERED)
        return border_holes(self.covered, self.truth_inverse_depth, self.now.view, rendered, size)


def _declared(value: T | None, flag: Input) -> T:
    if value is None:
        raise HmdwarpError(f"a metric reads {flag.name} without declaring it in `needs`")
    return value


# Holes beyond the rendered field of view, other holes, what is covered near jumps of depth, and the
# rest.
REGIONS = ("border_holes", "inside_holes", "silhouettes", "seen")
SUMS = ("pixels", "squared_error", "flip")

# Across a plane inverse depth changes by the same step from pixel to pixel, whatever its slant.
# Where two planes meet, the step changes by at most the step of each alone: tan(80 deg) x 0.1 deg =
# 1 % of the inverse depth per pixel at 10 pixels per degree.
RELATIVE_STEP = 0.02
# 1/m. A head motion of 0.3 m shifts so small a difference by 0.6 mrad, less than a pixel of any
# headset: no visible edge.
LEAST_STEP = 0.002
EDGE_WIDTH_PX = 2


def border_holes(
    coverage: NDArray[Any],
    truth_inverse_depth: NDArray[Any],
    shown: View,
    rendered: View,
    rendered_size: tuple[int, int],
) -> NDArray[np.bool_]:
    """Return the holes beyond the rendered field of view, (h, w).

    The truth says what belongs there. Each hole's pixel and its true inverse depth go through the
    warp map to the rendered view. Beyond the edges of that picture, or beside or behind its eye (w
    <= 0), no frame could have held it. The other holes are disocclusions and gaps between stretched
    pixels.

    coverage, truth_inverse_depth: (h, w), top row first; the former after the warp and before the
    fill, 0 is a hole; the latter in 1/m in the shown view, 0 (or NaN) = infinitely far.
    rendered_size: (w, h) of the late frame.
    Errors: InputError if their sizes differ.
    """
    if coverage.shape != truth_inverse_depth.shape or coverage.ndim != 2:
        shapes = f"{coverage.shape} and {truth_inverse_depth.shape}"
        raise InputError(
            f"coverage and the truth's inverse depth have shapes {shapes}: expected two of the same (h, w)"
        )
    holes, inverse_depth = flip_rows(np.asarray(coverage) == 0), flip_rows(np.asarray(truth_inverse_depth))
    height, width = holes.shape
    mapping = WarpMap.between(shown, (width, height), rendered, rendered_size)
    beyond = np.zeros(holes.shape, bool)
    for rows in row_blocks(height):
        here = holes[rows]
        if not here.any():
            continue
        depth = np.nan_to_num(inverse_depth[rows][here].astype(np.float64), nan=0.0)
        y, x = here.nonzero()
        pixel, _, w = mapping.apply(np.stack([x, y + rows.start], axis=1) + 0.5, depth)
        beyond[rows][here] = ~((w > 0) & (pixel >= 0).all(axis=-1) & (pixel <= rendered_size).all(axis=-1))
    found: NDArray[np.bool_] = flip_rows(beyond)
    return found


def region_of(
    coverage: NDArray[Any], truth_inverse_depth: NDArray[Any], beyond: NDArray[np.bool_]
) -> NDArray[np.uint8]:
    """Return the region of each pixel, (h, w), as an index into REGIONS.

    coverage, truth_inverse_depth: as of border_holes, which `beyond` are. A hole near a jump of
    depth is a hole.
    """
    region = np.where(near_discontinuity(truth_inverse_depth), np.uint8(2), np.uint8(3))
    region[np.asarray(coverage) == 0] = 1
    region[beyond] = 0
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
        pixels = np.moveaxis(near, axis, 1)  # a view: marking it marks `near`
        jump = _jumps(np.moveaxis(depth, axis, 1))
        pixels[:, :-1] |= jump
        pixels[:, 1:] |= jump
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
    shown: NDArray[Any], truth: NDArray[Any], region: NDArray[np.uint8], flip_map: NDArray[Any]
) -> dict[str, dict[str, float]]:
    """Return the SUMS of one picture by region.

    They are its pixels, the squared sRGB error over pixels and channels, and the FLIP error.
    Squared errors are summed in integers, so their order does not matter.

    shown, truth: (h, w, 3) uint8. region: (h, w), as of region_of. flip_map: (h, w), 0..1.
    Errors: InputError for sizes that do not belong together.
    """
    check_pair(shown, truth)
    if shown.dtype != np.uint8 or not shown.shape[:2] == region.shape == flip_map.shape:
        found = f"{shown.dtype} pictures {shown.shape}, regions {region.shape}, FLIP map {flip_map.shape}"
        raise InputError(f"{found}: expected uint8 (h, w, 3) and two (h, w)")
    region = region.ravel()
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
