"""Figures of what a trial really showed, stored with it: a rating is never about a plan alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Values = NDArray[np.float64]
Column = Callable[[str], Values]

# None where unknown.
NUMBERS = (
    "onset_s", "seconds", "pictures", "rate_hz", "latency_ms_median", "latency_ms_p95", "latency_ms_sd",
    "period_ms_median", "period_ms_p95", "missed", "missed_share", "over_budget_share", "hole_share_mean",
    "hole_share_p95", "pose_age_ms_median", "pose_age_ms_p95", "passes_ms_median", "passes_ms_p95",
    "angular_speed_deg_s_median", "linear_speed_m_s_median", "lost_s", "tracking_lost_share", "head_turn_deg",
    "head_shift_m", "inputs", "input_response_ms_mean", "input_response_ms_p95",
)  # fmt: skip
# Whole numbers among them.
COUNTS = ("pictures", "missed", "inputs")
FLAGS = ("head_still",)
TEXTS = (
    "warp", "fill", "scene", "effects", "lens", "headset", "gpu", "gl", "source", "hmdwarp", "size", "ended_by",
    "commit", "options", "numpy", "moderngl",
)  # fmt: skip
NOTHING: dict[str, Any] = {**dict.fromkeys((*NUMBERS, *FLAGS)), **dict.fromkeys(TEXTS, "")}
_EYES = (0, 1)


def actual_of(summary: Mapping[str, Any], column: Column) -> dict[str, Any]:
    """Return NUMBERS, FLAGS and TEXTS from a live run's summary and its columns.

    The session adds its own: onset_s, from the session's start to the first picture; head_turn_deg
    and head_shift_m, largest distances of the head from where it was first; head_still; ended_by:
    "time", or who ended a trial that is shown until done, "" for one not seen to its end.

    Parameters
    ----------
    summary
        As summary.json of the run; one without pictures gives None throughout.
    column
        Returns a column of frames.csv by name, with a number for each refresh, NaN where unknown.

    Returns
    -------
    dict
        Times in seconds or ms, as the name says. latency: from drawing the frame to showing it.
        period: between two pictures. missed: refreshes without a new picture, and their share.
        over_budget: drawing and passes took longer than a refresh. hole_share: of both eyes'
        pixels, after the warp and before the fill. pose_age: from reading the head to handing the
        picture over. passes: of both eyes. lost_s: without a display. tracking_lost: pictures for a
        head held at its last known pose. input_response: to the first picture that shows it.
    """
    if not summary:
        return dict(NOTHING)

    def of_eyes(name: str, together: Callable[..., Values]) -> Values:  # of refreshes that were measured
        eyes = np.array([column(f"{name}/{eye}") for eye in _EYES])
        return together(eyes[:, ~np.isnan(eyes).all(axis=0)], axis=0)

    def known(name: str) -> Values:
        return (values := column(name))[~np.isnan(values)]

    def middle(values: Values) -> float | None:
        return float(np.median(values)) if len(values) else None

    def tail(values: Values) -> float | None:
        return float(np.percentile(values, 95)) if len(values) else None

    live, pictures, machine = summary["live"], summary["frames"], summary["machine"]
    holes, latency = of_eyes("hole_share", np.nanmean), known("age_ms")
    several = {"latency_ms": latency, "period_ms": known("period_ms"), "pose_age_ms": known("pose_age_ms")}
    several["passes_ms"] = of_eyes("total_ms", np.nansum)
    acted = summary.get("input", {"count": 0})
    response = acted.get("response_time_ms", {})
    return {
        **NOTHING,
        "seconds": live["seconds"],
        "pictures": pictures,
        "rate_hz": (pictures - 1) / live["seconds"] if live["seconds"] else None,
        **{f"{name}_median": middle(values) for name, values in several.items()},
        **{f"{name}_p95": tail(values) for name, values in several.items()},
        "latency_ms_sd": float(np.std(latency, ddof=1)) if len(latency) > 1 else None,
        "missed": live["missed"],
        "missed_share": live["missed"] / (live["missed"] + pictures),
        "over_budget_share": live["over"] / live["timed"] if live["timed"] else None,
        "hole_share_mean": math.fsum(holes) / len(holes) if len(holes) else None,
        "hole_share_p95": tail(holes),
        "angular_speed_deg_s_median": middle(known("angular_speed_deg_s")),
        "linear_speed_m_s_median": middle(known("linear_speed_m_s")),
        "inputs": acted["count"],
        **{f"input_response_ms_{name}": response.get(name) for name in ("mean", "p95")},
        "lost_s": math.fsum(loss["away_s"] or 0.0 for loss in live["lost"]),
        "tracking_lost_share": sum(live["notices"].values()) / pictures,
        **{name: str(summary[name]) for name in ("warp", "fill", "scene", "lens", "headset", "hmdwarp")},
        "effects": "+".join(summary["effects"]),
        "gpu": machine["gl_renderer"],
        "gl": machine["gl_version"],
        "source": live["source"],
        "size": "x".join(map(str, summary["size"])),
        **{name: summary["made_with"][name] for name in ("commit", "options", "numpy", "moderngl")},
    }
