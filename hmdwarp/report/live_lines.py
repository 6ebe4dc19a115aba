"""A live run in a few lines for the terminal, and the table of its time per refresh."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ..metrics import Figure, metrics
from .source_texts import drawing_text, eyes_text
from .tables import TIME_FIGURES, Summary, miss_texts
from .words import counted

_MS = Figure("", "", "ms", 2)


def live_lines(summary: Summary, folder: Path | None) -> list[str]:
    """Return the lines that end a live run.

    summary: as summary.json, empty if no picture was shown; folder: of the report.
    """
    if not summary:
        return ["no picture was shown"]
    live, drawn = summary["live"], "drawing" if "recorded" not in summary else "reading"
    of_refresh = f", of {live['budget_ms']:.2f} ms for a refresh"
    figures = [
        ("shown", _shown(summary)),
        ("judder", _judder(summary)),
        ("frame age at display", _pair(live["age_ms"])),
        ("pose age at hand-over", _pair(live["pose_age_ms"])),
        ("from picture to picture", _pair(live["period_ms"])),
        ("time per eye", _per_eye(summary)),
        (f"{drawn} and {eyes_text(summary)}", _pair(live["refresh_ms"]["total"], of_refresh)),
        ("holes before the fill", _holes(summary)),
    ]
    lines = [f"{label:<24}{text}" for label, text in figures if text]
    lines += [f"note: {note}" for note in summary["notes"]]
    return lines + ([f"report: {folder / 'report.html'}"] if folder is not None else [])


def budget_rows(summary: Summary) -> list[tuple[str, str, str, float]]:
    """Return (part, median ms of all eyes, p95 ms, share) of a refresh, then the sum."""
    live = summary["live"]
    rows = []
    for name, entry in live["refresh_ms"].items():
        what = {"render": f"{drawing_text(summary)} by the server", "total": "total"}.get(name, name)
        share = (entry["median"] or 0.0) / live["budget_ms"]
        rows.append((what, _MS.text(entry["median"]), _MS.text(entry["p95"]), share))
    return rows


def _shown(summary: Summary) -> str:
    live, (share, longest, _) = summary["live"], miss_texts(summary["miss"])
    rate = f", {(live['refreshes'] - 1) / live['seconds']:.1f} a second" if live["seconds"] > 0 else ""
    missed = f"{live['missed']} missed ({share} %, at most {longest} in a row)" if live["missed"] else "none missed"
    return f"{counted(live['refreshes'], 'picture')} in {live['seconds']:.1f} s{rate}; {missed}"


def _judder(summary: Summary) -> str:
    judder = miss_texts(summary["miss"])[-1]
    return f"{judder} deg RMS" if summary["live"]["missed"] else ""


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
    return f"{_pair(times['total'])}: {', '.join(parts) or 'no pass ran'}{clock}"


def _holes(summary: Summary) -> str:
    entry, text = summary["quality"]["hole_share"], metrics.get("hole_share").figure.text
    return "" if entry["mean"] is None else f"{text(entry['mean'])} %, p95 {text(entry['p95'])}"
