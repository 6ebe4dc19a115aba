"""Within-person correlations of what was measured with the ratings.

People differ in how they use a scale, so ratings and measures count from each person's own mean,
and one slope holds for all.
Source: Bakdash and Marusich 2017, Repeated measures correlation, Front Psychol 8, 456.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import pandas as pd

from ...metrics import PRIMARY, metrics_in_order
from ...report import listed

# Title of each column of the long table that is a measure.
MEASURES = {
    **{
        f"measured_{metric.name}": metric.study_title
        for metric in sorted(metrics_in_order(), key=lambda m: (m.name != PRIMARY, not m.is_contest, m.order))
    },
    "actual_latency_ms_median": "age of the frame",
    "actual_latency_ms_sd": "jitter of that age",
    "actual_hole_share_mean": "holes in the live picture",
    "actual_pose_age_ms_median": "age of the pose",
    "actual_missed_share": "missed refreshes",
    "actual_period_ms_p95": "95th percentile between pictures",
    "actual_angular_speed_deg_s_median": "speed of the turning head",
}
_STILL = 1e-9  # of its own size: what varies less is constant but for rounding


class Correlation(NamedTuple):
    """Repeated-measures correlation with its 95 % interval and the p of no association."""

    r: float
    low: float
    high: float
    p: float
    dof: int


def within_people(x: pd.Series, y: pd.Series, who: pd.Series) -> Correlation | str:
    """Return the correlation, or the reason why there is none.

    The interval is Fisher's, of as many pairs as degrees of freedom and two.
    """
    from scipy.special import stdtr

    several = who.groupby(who).transform("size") > 1
    x, y, who = x[several].astype(float), y[several].astype(float), who[several]
    dof = len(x) - who.nunique() - 1
    if dof < 2:
        return "too few ratings"
    dx, dy = (values - values.groupby(who).transform("mean") for values in (x, y))
    if dx.abs().max() <= _STILL * x.abs().max():
        return "the same in all trials of each person"
    if dy.abs().max() <= _STILL:
        return "every person gave one rating throughout"
    dx = dx / dx.abs().max()  # so that squares of 1e-200 are no 0
    r = min(1.0, max(-1.0, float((dx * dy).sum() / math.sqrt((dx**2).sum() * (dy**2).sum()))))
    if abs(r) == 1:
        return Correlation(r, r, r, 0.0, dof)
    half = 1.959963984540054 / math.sqrt(dof - 1)
    low, high = (math.tanh(math.atanh(r) + side * half) for side in (-1, 1))
    return Correlation(r, low, high, float(2 * stdtr(dof, -abs(r) * math.sqrt(dof / (1 - r * r)))), dof)


def correlation_data(rows: pd.DataFrame, scale: str) -> dict[str, Any] | None:
    """Return the correlation of each measure, with sentences; None where nothing was measured.

    Positive where more of a measure was rated worse.
    """
    rated = rows[(rows["scale"] == scale) & rows["value"].notna()]
    there = [name for name in MEASURES if name in rated and rated[name].notna().any()]
    if not there:
        return None
    worse = rated["value"] * (1 if rated["low_is_good"].iloc[0] else -1)
    how = rated[[name for name in ("measured_size", "measured_every") if name in rated]].dropna(how="all")
    mixed = len(how.drop_duplicates()) > 1
    found, left_out = [], []
    for name, title in MEASURES.items():
        is_metric = name.startswith("measured_")
        if name not in there:
            result: Correlation | str = "not measured; 'study measure' does it" if is_metric else "not measured"
        elif is_metric and mixed:
            result = "measured with several sizes or steps: 'study measure' with one --size makes them alike"
        else:
            own = rated[rated[name].notna()]
            result = within_people(own[name], worse[own.index], own["participant"])
        if isinstance(result, str):
            left_out.append((title, result))
        else:
            found.append({"name": name, "title": title, **result._asdict()})
    return {"sentences": _sentences(found, left_out), "measures": found, "left_out": [list(one) for one in left_out]}


def _sentences(found: list[dict[str, Any]], left_out: list[tuple[str, str]]) -> list[str]:
    texts = [f"{one['title']} {one['r']:+.2f} (95 % {one['low']:+.2f} .. {one['high']:+.2f})" for one in found]
    said = [f"Within a person the ratings go with {listed(texts)}; positive: more is rated worse."] if texts else []
    reasons: dict[str, list[str]] = {}
    for title, reason in left_out:
        reasons.setdefault(reason, []).append(title)
    return said + [f"Not tested: {listed(titles)} ({reason})." for reason, titles in reasons.items()]
