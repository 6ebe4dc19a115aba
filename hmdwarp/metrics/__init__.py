"""How far the shown picture is from the truth: error, holes, flicker; measured in other processes.

A metric is one file in metrics/library. Pictures are sRGB-encoded, (h, w, 3), top row first; holes
are black pixels and count.
"""

from .figure import Figure
from .job import Compared, Measurement, QualityJob, QualityResult, measure
from .library.border_share import border_share
from .library.flicker import flicker
from .library.flip import flip
from .library.hole_share import hole_share
from .library.psnr_db import PSNR_CAP_DB, psnr_db
from .library.ssim import ssim
from .metric import METRICS, PRIMARY, Input, Metric, metrics_in_order
from .mismatch import Mismatch, SharedSurface
from .pareto import error_and_time, pareto
from .pictures import check_pair, error_image
from .pool import QualityPool, worker_count
from .regions import REGIONS, near_discontinuity, pooled, region_of, region_sums
from .sharpness import sharpness
from .summary import QUALITY, STAGES, aggregate, aggregate_columns, middle_and_tail
from .worst import Kept, WorstKeeper

__all__ = [
    "METRICS",
    "PRIMARY",
    "PSNR_CAP_DB",
    "QUALITY",
    "REGIONS",
    "STAGES",
    "Compared",
    "Figure",
    "Input",
    "Kept",
    "Measurement",
    "Metric",
    "Mismatch",
    "QualityJob",
    "QualityPool",
    "QualityResult",
    "SharedSurface",
    "WorstKeeper",
    "aggregate",
    "aggregate_columns",
    "border_share",
    "check_pair",
    "error_and_time",
    "error_image",
    "flicker",
    "flip",
    "hole_share",
    "measure",
    "metrics_in_order",
    "middle_and_tail",
    "near_discontinuity",
    "pareto",
    "pooled",
    "psnr_db",
    "region_of",
    "region_sums",
    "sharpness",
    "ssim",
    "worker_count",
]
