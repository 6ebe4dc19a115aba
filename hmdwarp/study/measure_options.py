"""Options of measuring a study."""

from __future__ import annotations

import attrs

from ..base import Declared, group, option, same_as
from ..experiments.sweep import ClusterOptions
from ..run import RunOptions

_RUN = attrs.fields(RunOptions)


@attrs.frozen(kw_only=True)
class MeasureOptions(Declared):
    """Which trials to measure, and how finely."""

    every: int = same_as(_RUN.metrics_every)
    size: tuple[int, int] | None = same_as(_RUN.size, help="Pixels of one eye; by default as shown. Fewer are faster.")
    jod_s: float = same_as(_RUN.jod_s)
    workers: int | None = same_as(_RUN.workers)
    again: bool = option(False, "Re-measure trials already measured with these options.")
    pilot: bool = option(False, "Pilot sessions instead of those of participants.")
    where: ClusterOptions = group(ClusterOptions)
