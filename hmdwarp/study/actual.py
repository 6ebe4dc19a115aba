"""Figures of what a trial really showed, stored with it: a rating is never about a plan alone."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

Column = Callable[[str], NDArray[np.float64]]

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

    A summary without pictures gives None throughout. The session adds its own: onset_s, from the
    session's start to the first picture; head_turn_deg, head_shift_m: largest distances of the head
    from where it was first; head_still: session/wording.py; ended_by: "time", or who
    ended a trial that is shown until done, "" for one that was not seen to its end.

    seconds: from the first picture to the last. rate_hz: pictures per second. latency: from drawing
    the frame to showing it. period: between two pictures. missed: refreshes without a new picture,
    with their share of all refreshes. over_budget: drawing and passes took longer than a refresh.
    hole_share: of both eyes' pixels, after the warp and before the fill. pose_age: from reading the
    head to handing the picture over. passes: of both eyes together. lost_s: without a display.
    tracking_lost: pictures for a head that was held at its last known pose. input_response: from an
    input to the first picture that shows what came of it.
    """
    if not summary:
        return dict(NOTHING)
    live, pictures = summary["live"], summary["frames"]
    holes, passes = _of_eyes(column, "hole_share", np.nanmean), _of_eyes(column, "total_ms", np.nansum)
    latency, acted = _known(column("age_ms")), summary.get("input", {"count": 0})
    response = acted.get("response_time_ms", {})
    numbers = {
        "seconds": live["seconds"],
        "pictures": pictures,
        "rate_hz": (pictures - 1) / live["seconds"] if live["seconds"] else None,
        **_middle_and_tail("latency_ms", latency),
        "latency_ms_sd": float(np.std(latency, ddof=1)) if len(latency) > 1 else None,
        **_middle_and_tail("period_ms", _known(column("period_ms"))),
        "missed": live["missed"],
        "missed_share": live["missed"] / (live["missed"] + pictures),
        "over_budget_share": live["over"] / live["timed"] if live["timed"] else None,
        "hole_share_mean": math.fsum(holes) / len(holes) if len(holes) else None,
        "hole_share_p95": _tail(holes),
        **_middle_and_tail("pose_age_ms", _known(column("pose_age_ms"))),
        **_middle_and_tail("passes_ms", passes),
        "angular_speed_deg_s_median": _middle(_known(column("angular_speed_deg_s"))),
        "linear_speed_m_s_median": _middle(_known(column("linear_speed_m_s"))),
        "inputs": acted["count"],
        **{f"input_response_ms_{name}": response.get(name) for name in ("mean", "p95")},
        "lost_s": math.fsum(loss["away_s"] or 0.0 for loss in live["lost"]),
        "tracking_lost_share": sum(live["notices"].values()) / pictures,
    }
    return {**NOTHING, **numbers, **_texts(summary)}


def _texts(summary: Mapping[str, Any]) -> dict[str, str]:
    machine = summary["machine"]
    return {
        **{name: str(summary[name]) for name in ("warp", "fill", "scene", "lens", "headset", "hmdwarp")},
        "effects": "+".join(summary["effects"]),
        "gpu": machine["gl_renderer"],
        "gl": machine["gl_version"],
        "source": summary["live"]["source"],
        "size": "x".join(map(str, summary["size"])),
        **{name: summary["made_with"][name] for name in ("commit", "options", "numpy", "moderngl")},
    }


def _of_eyes(column: Column, name: str, together: Callable[..., NDArray[np.float64]]) -> NDArray[np.float64]:
    """Combine both eyes of each refresh, without refreshes that were not measured."""
    eyes = np.array([column(f"{name}/{eye}") for eye in _EYES])
    return together(eyes[:, ~np.isnan(eyes).all(axis=0)], axis=0)


def _known(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values[~np.isnan(values)]


def _middle(values: NDArray[np.float64]) -> float | None:
    return float(np.median(values)) if len(values) else None


def _tail(values: NDArray[np.float64]) -> float | None:
    return float(np.percentile(values, 95)) if len(values) else None


def _middle_and_tail(name: str, values: NDArray[np.float64]) -> dict[str, float | None]:
    return {f"{name}_median": _middle(values), f"{name}_p95": _tail(values)}
