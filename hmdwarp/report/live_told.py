"""A live run in a few lines for the terminal, and its table of what a refresh goes into."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .tables import QUALITY_FIGURES, TIME_FIGURES, Figure

Summary = Mapping[str, Any]
_MS = Figure("", "", "ms", 2)
_HOLES = next(figure for figure in QUALITY_FIGURES if figure.name == "hole_share")


def live_lines(summary: Summary, folder: Path | None) -> list[str]:
    """What to tell at the end. summary: as summary.json, empty where no picture was shown; folder: where it lies."""
    if not summary:
        return ["no picture was shown"]
    live = summary["live"]
    told = [
        ("shown", _shown(live)),
        ("frames are old by", _pair(live["age_ms"])),
        ("heads are read before", _pair(live["pose_age_ms"])),
        ("from picture to picture", _pair(live["period_ms"])),
        ("time per eye", _per_eye(summary)),
        ("drawing and both eyes", _pair(live["refresh_ms"]["total"], f", of {live['budget_ms']:.2f} ms for a refresh")),
        ("holes before the fill", _holes(summary)),
    ]
    lines = [f"{label:<24}{text}" for label, text in told if text]
    lines += [f"note: {note}" for note in summary["notes"]]
    return lines + ([f"report: {folder / 'report.html'}"] if folder is not None else [])


def missed_share(live: Mapping[str, Any]) -> float:
    """Of all refreshes that could have had a picture, those that went by without a new one."""
    return live["missed"] / max(1, live["missed"] + live["refreshes"])


def budget_rows(summary: Summary) -> list[tuple[str, str, str, float]]:
    """(what, median ms of all eyes, p95 ms, share of a refresh) of all that a refresh goes into on this machine, then the sum."""
    live = summary["live"]
    rows = []
    for name, entry in live["refresh_ms"].items():
        what = {"render": "the server draws", "total": "all of it"}.get(name, name)
        rows.append(
            (what, _MS.text(entry["median"]), _MS.text(entry["p95"]), (entry["median"] or 0.0) / live["budget_ms"])
        )
    return rows


def _shown(live: Mapping[str, Any]) -> str:
    rate = f", {(live['refreshes'] - 1) / live['seconds']:.1f} a second" if live["seconds"] > 0 else ""
    missed = f"; {live['missed']} missed ({missed_share(live):.1%})" if live["missed"] else "; none missed"
    return f"{live['refreshes']} picture{'s' * (live['refreshes'] != 1)} in {live['seconds']:.1f} s{rate}{missed}"


def _pair(entry: Mapping[str, float | None], more: str = "") -> str:
    return "" if entry["median"] is None else f"{entry['median']:.2f} ms, p95 {entry['p95']:.2f}{more}"


def _per_eye(summary: Summary) -> str:
    times = summary["time_ms"]
    if times["total"]["median"] is None:
        return ""
    parts = [
        f"{figure.name} {times[figure.name]['median']:.2f}"
        for figure in TIME_FIGURES[:-1]
        if times[figure.name]["median"]
    ]
    clock = "" if summary["clock"] == "gpu" else ", by the wall clock"
    return f"{_pair(times['total'])}: {', '.join(parts) or 'nothing to be done'}{clock}"


def _holes(summary: Summary) -> str:
    entry = summary["quality"]["hole_share"]
    return "" if entry["mean"] is None else f"{_HOLES.text(entry['mean'])} %, p95 {_HOLES.text(entry['p95'])}"
