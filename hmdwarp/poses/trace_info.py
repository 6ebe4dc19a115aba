"""What is known of a head trace and its motion, as plain data for other programs."""

from __future__ import annotations

from typing import Any

import attrs

from .load import LoadedTrace
from .prediction_errors import ERROR_PERCENTILES
from .track_statistics import SPEED_PERCENTILES, Analysis


def trace_as_json(loaded: LoadedTrace, figures: Analysis) -> dict[str, Any]:
    """Return what `hmdwarp trace info --json` prints.

    Percentiles are keys such as p95. What the track is too short for is NaN.
    """
    return {
        "trace": str(loaded.path),
        "format": loaded.format,
        "origin": loaded.track.origin,
        "axes": loaded.axes,
        "columns": loaded.columns,
        "samples": figures.samples,
        "repeated_share": figures.repeated_share,
        "duration_s": figures.duration_s,
        "rate_hz": figures.rate_hz,
        "mean_rate_hz": figures.mean_rate_hz,
        "clock": loaded.time_unit,
        "clock_starts_s": loaded.track.epoch_ns / 1e9,
        "gaps": [{"start_s": gap.start_ns / 1e9, "length_s": gap.length_ns / 1e9} for gap in figures.gaps],
        "jumps": figures.jumps,
        "angular_speed_deg_s": _percentiles(figures.angular_speed_deg_s, SPEED_PERCENTILES),
        "linear_speed_m_s": _percentiles(figures.linear_speed_m_s, SPEED_PERCENTILES),
        "errors_deg": [
            {
                "latency_ms": row.latency_ms,
                **{
                    name: {
                        "mean": errors.mean,
                        **_percentiles(errors.percentiles, ERROR_PERCENTILES),
                        "lead_share": errors.lead_share,
                        "lead_p95": errors.lead,
                        "lag_p95": errors.lag,
                    }
                    for name, errors in row.errors.items()
                },
            }
            for row in figures.errors
        ],
        "segments": [attrs.asdict(segment) for segment in loaded.segments],
        "defects": [attrs.asdict(defect) for defect in loaded.defects],
    }


def _percentiles(values: tuple[float, ...], which: tuple[float, ...]) -> dict[str, float]:
    return {f"p{percent:g}": value for percent, value in zip(which, values, strict=True)}
