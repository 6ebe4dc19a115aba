"""The declaration of a metric, what one picture of an eye is measured from, and its measurement."""

from __future__ import annotations

import enum
import functools
import math
from collections.abc import Callable, Iterable
from typing import Any

import attrs
import numpy as np
from numpy.typing import NDArray

from ..base import HmdwarpError, InputError, Registry
from ..geometry import View, WarpMap
from ..gpu import flip_rows
from .picture_pairs import Alike, Compared, db_of


class Input(enum.Flag):
    """What a metric is computed from."""

    TRUTH = enum.auto()  # the picture without latency
    COVERAGE = enum.auto()  # which pixels the warp covered, before the fill
    DEPTH = enum.auto()  # inverse depth of the truth
    RENDERED = enum.auto()  # the view the late frame was rendered for
    PREVIOUS = enum.auto()  # the neighbouring frame of the same eye
    ALIKE = enum.auto()  # what a PairPass has found


def _covered(coverage: Any) -> Any:
    return None if coverage is None else np.asarray(coverage) != 0


@attrs.frozen(eq=False)
class QualityJob:
    """One eye of one frame to measure. Inputs that are None leave out the metrics that need them.

    Errors: InputError for sizes that do not belong together.
    """

    now: Compared  # after the fill, before the lens
    previous: Compared | None = None  # the neighbouring frame of the same eye, from which a PairPass finds flicker
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
        if self.regions and Input.COVERAGE | Input.DEPTH | Input.RENDERED not in self.inputs:
            raise InputError(
                "regions of the error need the coverage, the truth's inverse depth and the rendered view: pass all"
            )

    @property
    def inputs(self) -> Input:
        """The inputs of metrics that the job has."""
        there = {
            Input.TRUTH: self.now,
            Input.COVERAGE: self.covered,
            Input.DEPTH: self.truth_inverse_depth,
            Input.RENDERED: None if self.rendered is None else self.rendered_size,
            Input.PREVIOUS: None if self.alike is None else self.alike.flicker,
            Input.ALIKE: self.alike,
        }
        return Input(sum(flag.value for flag, value in there.items() if value is not None))

    @functools.cached_property
    def seen(self) -> NDArray[np.bool_]:
        """(h, w): what the lens does not hide; the rest is black in both pictures."""
        high, wide = self.now.shown.shape[:2]
        return self.now.view.seen((wide, high))

    @functools.cached_property
    def border_holes(self) -> NDArray[np.bool_]:
        """(h, w): holes beyond what the late frame shows."""
        job: Any = _Declared(self)  # metrics that ask for it declare all that it is found from
        return border_holes(job.covered, job.truth_inverse_depth, self.now.view, job.rendered, job.rendered_size)


@attrs.frozen(eq=False)
class QualityResult:
    """The figures of one job."""

    values: dict[str, float | None]  # by metric; None where nothing could be measured
    error_map: NDArray[np.uint8] | None = None  # (h, w) bytes, FLIP 0..1 as 0..255, if the job requests it
    regions: NDArray[np.float64] | None = None  # as region_sums, if the job requests it


@attrs.frozen
class Figure:
    """The label, unit and rounding of one number."""

    name: str  # its key in a summary
    label: str
    unit: str
    digits: int
    scale: float = 1.0  # turns the stored number into `unit`
    higher_is_better: bool | None = None  # None where neither is

    def text(self, value: float | None) -> str:
        """Return the rounded number, or a dash where nothing was measured."""
        return "–" if value is None else f"{value * self.scale:.{self.digits}f}"


@attrs.frozen(kw_only=True)
class Metric:
    """A figure of one eye's picture, with everything that files, tables, charts and pages need."""

    name: str  # key in summary.json and bench.json, column of frames.csv and stem of its file
    order: int  # place among the metrics in every file, table and page
    compute: Callable[[Any], float | None]  # of a QualityJob that has what it needs
    # What it is of a picture of which no pixel is alike, from that of one with a share that is
    # black in both: hidden pixels. By default of a mean of errors.
    of_seen_share: Callable[[float, float], float] = lambda value, share: value / share
    needs: Input = Input.TRUTH  # Without one of these there is no figure (None). A live run has no TRUTH.
    higher_is_better: bool = False
    least: float = 0.0  # no value is beyond these: neither is the interval of a mean
    most: float = math.inf
    # Whether the better of two runs is marked. False for holes: a run without a warp has none.
    is_contest: bool = True

    label: str
    unit: str = ""  # of the stored number
    percent_of: str = ""  # for a share, stored as 0..1 and written in percent: of what
    digits: int = 4
    # For the tables of a bench, which are narrow.
    short_label: str = attrs.field(default=attrs.Factory(lambda self: self.label, takes_self=True))
    short_digits: int = 3

    # Columns of a low rank are dropped first from a bench's table on a narrow terminal; None: never
    # shown.
    bench_rank: float | None = 0
    tile_note: str = ""  # note under its tile at the top of a report; "": no tile
    chart: str = ""  # heading of its chart over time; "": no chart
    chart_from_zero: bool = True

    description: str  # one phrase, for the data dictionary of a study's export
    explanation: str = ""  # sentences for the readers of a report
    # Beside ratings, in the middle of a sentence.
    study_title: str = attrs.field(default=attrs.Factory(lambda self: self.label, takes_self=True))

    def of_seen(self, value: float | None, share: float) -> float | None:
        """Return the figure over the seen pixels, of one over all with hidden ones alike."""
        return value if value is None or share == 1 else min(self.of_seen_share(value, share), self.most)

    @property
    def scale(self) -> float:
        """Factor from the stored number to the written one."""
        return 100 if self.percent_of else 1

    @property
    def figure(self) -> Figure:
        """Its format in reports."""
        unit = "%" if self.percent_of else self.unit
        return Figure(self.name, self.label, unit, self.digits, self.scale, self.higher_is_better)

    @property
    def short_figure(self) -> Figure:
        """Its format in the tables of a bench."""
        return attrs.evolve(self.figure, label=self.short_label, digits=self.short_digits)

    @property
    def chart_unit(self) -> str:
        """Unit at the axis of its chart."""
        return f"% of {self.percent_of}" if self.percent_of else self.unit


_OWN = dict.fromkeys(("psnr_db", "ssim", "flip", "hole_share", "border_share", "flicker"), "figures")
metrics: Registry[Metric] = Registry(
    "metric", "hmdwarp.metrics.library", "metrics", columns="summary=description", modules=_OWN
)
PRIMARY = "flip"  # decides which pictures are the worst and, by default, which method is the best


@functools.cache
def metrics_in_order() -> tuple[Metric, ...]:
    """Return all metrics in the order of files, tables and pages."""
    return tuple(sorted(metrics, key=lambda metric: metric.order))


class _Declared:
    """A job as metrics see it: what it lacks is no figure of a metric that declares it."""

    def __init__(self, job: QualityJob) -> None:
        self._job = job

    def __getattr__(self, name: str) -> Any:
        if (value := getattr(self._job, name)) is None:
            raise HmdwarpError(f"a metric reads '{name}' of a job that lacks it: its `needs` does not declare it")
        return value


def measure(job: QualityJob) -> QualityResult:
    """Return all figures of one job; the same job gives the same bits in any process."""
    now, there, share, given = job.now, job.inputs, float(job.seen.mean()), _Declared(job)
    values = {
        metric.name: metric.of_seen(metric.compute(given), share) if metric.needs in there else None
        for metric in metrics_in_order()
    }
    flip_map: Any = None if job.alike is None else job.alike.flip_map
    error_map = np.rint(flip_map * 255).astype(np.uint8) if job.error_map else None
    regions = None
    if job.regions:
        region = region_of(job.covered, job.truth_inverse_depth, job.border_holes)  # type: ignore[arg-type]
        region[~job.seen] = len(REGIONS)
        regions = region_sums(now.shown, now.truth, region, flip_map)
    return QualityResult(values, error_map, regions)


# Holes beyond the rendered field of view, other holes, what is covered near jumps of depth, and the
# rest.
REGIONS = ("border_holes", "inside_holes", "silhouettes", "seen")

# Across a plane inverse depth changes by the same step from pixel to pixel, whatever its slant.
# Where two planes meet, the step changes by at most the step of each alone: tan(80 deg) x 0.1 deg =
# 1 % of the inverse depth per pixel at 10 pixels per degree.
RELATIVE_STEP = 0.02
# 1/m. A head motion of 0.3 m shifts so small a difference by 0.6 mrad, less than a pixel of any
# headset: no visible edge.
LEAST_STEP = 0.002
_EDGE_WIDTH_PX = 2


def border_holes(
    coverage: NDArray[Any],
    truth_inverse_depth: NDArray[Any],
    shown: View,
    rendered: View,
    rendered_size: tuple[int, int],
) -> NDArray[np.bool_]:
    """Return the holes beyond the rendered field of view, (h, w).

    Each hole's pixel and its true inverse depth go through the warp map to the rendered view:
    beyond the edges of that picture, or beside or behind its eye (w <= 0), no frame could have held
    it. The other holes are disocclusions and gaps between stretched pixels.

    coverage, truth_inverse_depth: (h, w), top row first; 0 of the former is a hole; the latter in
    1/m in the shown view, 0 (or NaN) = infinitely far. rendered_size: (w, h) of the late frame.
    """
    holes, inverse_depth = flip_rows(np.asarray(coverage) == 0), flip_rows(np.asarray(truth_inverse_depth))
    mapping = WarpMap.between(shown, holes.shape[::-1], rendered, rendered_size)
    places = np.stack(holes.nonzero()[::-1], axis=1) + 0.5
    pixel, _, w = mapping.apply(places, np.nan_to_num(inverse_depth[holes].astype(np.float64), nan=0.0))
    beyond = np.zeros(holes.shape, bool)
    beyond[holes] = ~((w > 0) & (pixel >= 0).all(axis=-1) & (pixel <= rendered_size).all(axis=-1))
    return np.asarray(flip_rows(beyond))


def region_of(
    coverage: NDArray[Any], truth_inverse_depth: NDArray[Any], beyond: NDArray[np.bool_]
) -> NDArray[np.uint8]:
    """Return the region of each pixel, (h, w), as an index into REGIONS; beyond: border_holes."""
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
        pixels, rows = np.moveaxis(near, axis, 1), np.moveaxis(depth, axis, 1)  # views: marking one marks `near`
        step = np.diff(rows, axis=1)  # from each pixel of a row to the next
        allowed = np.maximum(RELATIVE_STEP * np.maximum(np.abs(rows[:, :-1]), np.abs(rows[:, 1:])), LEAST_STEP)
        jump = np.abs(step) > allowed
        change = np.abs(np.diff(step, axis=1))
        # The end of a row has one step to continue; two pixels have none: a large step is a jump.
        jump[:, 1:] &= change > allowed[:, 1:]
        jump[:, :-1] &= change > allowed[:, :-1]
        pixels[:, :-1] |= jump
        pixels[:, 1:] |= jump
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(near, np.ones((3, 3)), iterations=_EDGE_WIDTH_PX - 1))


def region_sums(
    shown: NDArray[Any], truth: NDArray[Any], region: NDArray[np.uint8], flip_map: NDArray[Any]
) -> NDArray[np.float64]:
    """Return (REGIONS, 3) sums of one picture: pixels, squared errors as integers, FLIP errors.

    shown, truth: (h, w, 3) uint8. region: (h, w), as of region_of. flip_map: (h, w), 0..1.
    """
    region = region.ravel()
    difference = shown.astype(np.int32) - truth
    squared = np.einsum("hwc,hwc->hw", difference, difference).ravel()
    columns = (np.ones(region.size), squared, flip_map.ravel())  # float64 holds integers exactly up to 2^53
    sums = [np.bincount(region, weights=column, minlength=len(REGIONS)) for column in columns]
    return np.array(sums, np.float64).T[: len(REGIONS)]


def pooled(pictures: Iterable[NDArray[np.float64]]) -> dict[str, dict[str, float | None]]:
    """Return, by region, its share of all pixels, and PSNR and mean FLIP over its own pixels.

    pictures: region_sums of each. Errors are pooled before the logarithm: a picture with a small
    region counts little. A region without pixels has None; without any picture `share` is None too.
    """
    totals = sum(pictures, start=np.zeros((len(REGIONS), 3)))
    everything, found = float(totals[:, 0].sum()), dict[str, dict[str, float | None]]()
    for name, (pixels, squared_error, flip) in zip(REGIONS, totals.tolist(), strict=True):
        found[name] = {"share": pixels / everything if everything else None, "psnr_db": None, "flip": None}
        if pixels:
            psnr_db = db_of(squared_error / (3 * pixels) / 255**2)
            found[name] |= {"psnr_db": psnr_db, "flip": flip / pixels}
    return found
