"""The declaration of a metric, and the registry of metrics: one file each in metrics/library."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable

import attrs
import numpy as np

from ..registry import Registry
from .job import REGIONS, Input, Measurement, QualityJob, QualityResult, region_of, region_sums


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
    """A figure of one eye's picture, with everything that files, tables, charts and pages need.

    This is the only declaration of a metric: everything else reads it from here.
    """

    name: str  # key in summary.json and bench.json, column of frames.csv and stem of its file
    order: int  # place among the metrics in every file, table and page
    compute: Callable[[Measurement], float | None]
    # What it is of a picture of which no pixel is alike, from that of one with a share that is
    # black in both: hidden pixels. By default of a mean of errors.
    of_seen_share: Callable[[float, float], float] = lambda value, share: value / share
    needs: Input = Input.TRUTH  # Without one of these there is no figure (None). A live run has no TRUTH.
    higher_is_better: bool = False
    least: float = 0.0  # no value is beyond these: neither is the interval of a mean
    most: float = math.inf
    # Whether the better of two runs is marked. False for holes: a run without a warp has none.
    is_contest: bool = True

    # --- how the number is written ---
    label: str
    unit: str = ""  # of the stored number
    percent_of: str = ""  # for a share, stored as 0..1 and written in percent: of what
    digits: int = 4
    # For the tables of a bench, which are narrow.
    short_label: str = attrs.field(default=attrs.Factory(lambda self: self.label, takes_self=True))
    short_digits: int = 3

    # --- where it is shown --- Columns of a low rank are dropped first from a bench's table on a
    # narrow terminal; None: never shown.
    bench_rank: float | None = 0
    tile_note: str = ""  # note under its tile at the top of a report; "": no tile
    chart: str = ""  # heading of its chart over time; "": no chart
    chart_from_zero: bool = True

    # --- what it is ---
    description: str  # one phrase, for the data dictionary of a study's export
    explanation: str = ""  # sentences for the readers of a report
    # Beside ratings, in the middle of a sentence.
    study_title: str = attrs.field(default=attrs.Factory(lambda self: self.label, takes_self=True))

    def of_seen(self, value: float | None, share: float) -> float | None:
        """Return the figure over the seen pixels, of one over all with hidden ones alike."""
        return value if value is None or share == 1 else min(self.of_seen_share(value, share), self.most)

    def of_all(self, value: float | None, share: float) -> float | None:
        """Return the figure over all pixels; the inverse of of_seen."""
        return self.of_seen(value, 1 / share)

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


_FAMILIES = {
    **dict.fromkeys(("ssim", "flip", "psnr_db"), "alike"),
    **dict.fromkeys(("hole_share", "border_share"), "holes"),
}
metrics: Registry[Metric] = Registry(
    "metric", "hmdwarp.metrics.library", "metrics", columns="summary=description", modules=_FAMILIES
)
PRIMARY = "flip"  # decides which pictures are the worst and, by default, which method is the best


@functools.cache
def metrics_in_order() -> tuple[Metric, ...]:
    """Return all metrics in the order of files, tables and pages."""
    return tuple(sorted(metrics, key=lambda metric: metric.order))


def measure(job: QualityJob) -> QualityResult:
    """Return all figures of one job; the same job gives the same bits in any process."""
    now, there, measurement = job.now, job.inputs, Measurement(job)
    share = float(measurement.seen.mean())
    values = {
        metric.name: metric.of_seen(metric.compute(measurement), share) if metric.needs in there else None
        for metric in metrics_in_order()
    }
    error_map = np.rint(measurement.alike.flip_map * 255).astype(np.uint8) if job.error_map else None
    regions = None
    if job.regions:
        region = region_of(measurement.covered, measurement.truth_inverse_depth, measurement.border_holes)
        region[~measurement.seen] = len(REGIONS)
        regions = region_sums(now.shown, now.truth, region, measurement.alike.flip_map)
    return QualityResult(values, error_map, regions)
