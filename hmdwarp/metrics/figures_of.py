"""All figures of one picture."""

from __future__ import annotations

import numpy as np

from .job import Measurement, QualityJob, QualityResult
from .metric import metrics_in_order
from .regions import region_sums


def measure(job: QualityJob, pixels_per_degree: float) -> QualityResult:
    """Return all figures of one job; the same job gives the same bits in any process."""
    now, there, measurement = job.now, job.inputs, Measurement(job, pixels_per_degree)
    values = {
        metric.name: metric.compute(measurement) if metric.needs in there else None for metric in metrics_in_order()
    }
    flip_map = measurement.flip[1]
    error_map = np.rint(flip_map * 255).astype(np.uint8) if job.error_map else None
    regions = None
    if job.regions:
        regions = region_sums(now.shown, now.truth, measurement.covered, measurement.truth_inverse_depth, flip_map)
    return QualityResult(values, error_map, regions)
