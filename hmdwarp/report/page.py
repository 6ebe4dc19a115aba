"""report.html: one page that holds everything, its pictures and charts included, and asks the network for nothing."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import attrs

from ..metrics.worst import Kept
from .bench_cases import name_pieces
from .charts import Series, time_series
from .pictures import Panel, comparison_panels, jpeg_bytes
from .tables import QUALITY_FIGURES, TIME_FIGURES, Summary, column_names, comparison_rows
from .way import coding_rows, filled_rows, frame_rows, response_rows

if TYPE_CHECKING:
    from jinja2 import Environment

Rows = Sequence[Mapping[str, Any]]

EYES = ("left eye", "right eye")
CLOCK_NAMES = {"gpu": "GPU timer queries", "wall": "wall clock around finished GPU work"}
_SHORT_NOTE = {  # the figures that get a tile of their own
    "psnr_db": "larger is better, identical pictures count as 100",
    "ssim": "larger is better, 1 is identical",
    "flip": "smaller is better, 0 is identical",
    "hole_share": "empty after the warp, before the fill",
}
# (heading, column, unit, scale, axis from zero)
_CHARTS = (
    ("FLIP error", "flip", "", 1, True),
    ("PSNR", "psnr_db", "dB", 1, False),
    ("Holes before the fill", "hole_share", "% of pixels", 100, True),
    ("Flicker", "flicker", "", 1, True),
)
_MOTION_CHARTS = (
    ("How fast the head turns", "angular_speed_deg_s", "deg/s", 1, True),
    ("How fast the head moves", "linear_speed_m_s", "m/s", 1, True),
)


@attrs.frozen(eq=False)
class WorstFrame:
    """One picture of the strip of worst frames: when, which eye (0 left, 1 right), labelled panels (see
    pictures.comparison_panels) and its figures by the names of QUALITY."""

    time_s: float
    eye: int
    panels: tuple[Panel, ...]
    values: Mapping[str, float | None]

    @classmethod
    def of(cls, time_s: float, eye: int, kept: Kept) -> WorstFrame:
        """From what QualityPool kept."""
        pictures = kept.job.now
        panels = comparison_panels(kept.job.rendered_picture, pictures.shown, pictures.truth, kept.result.error_map)
        return cls(time_s, eye, tuple(panels), kept.result.values)


@attrs.frozen
class Tile:
    """A figure large; baseline: the compared run's, as text."""

    label: str
    unit: str
    text: str
    note: str
    baseline: str | None


@attrs.frozen
class Chart:
    """A heading over an <svg> element."""

    heading: str
    svg: str


def render_report(
    summary: Summary,
    baseline_summary: Summary | None = None,
    *,
    rows: Rows,
    baseline_rows: Rows | None = None,
    worst: Sequence[WorstFrame] = (),
    command: str,
    notes: Sequence[str] = (),
) -> str:
    """The text of report.html; the same arguments give the same text.

    summary, baseline_summary: as summary.json; rows, baseline_rows: as frames.csv's, None for absent values. command: what
    the user typed, exactly. notes: what the run noticed, one sentence each.
    """
    names = column_names(summary, baseline_summary)
    comparison = comparison_rows(summary, baseline_summary)
    return (
        environment()
        .get_template("report.html")
        .render(
            summary=summary,
            command=command,
            notes=list(notes),
            columns=names,
            baseline=baseline_summary,
            quality_rows=comparison[: len(QUALITY_FIGURES)],
            time_rows=comparison[len(QUALITY_FIGURES) :],
            tiles=_tiles(summary, baseline_summary, names),
            charts=_charts(summary, names, rows, baseline_rows),
            worst=[_worst(frame) for frame in worst],
            measured=_measured(summary),
            auto=_auto(summary),
            filled=filled_rows(summary),
            response=response_rows(summary),
            frames=frame_rows(summary),
            coding=coding_rows(summary),
            clock=CLOCK_NAMES[summary["clock"]],
        )
    )


def environment() -> Environment:
    """What turns templates into pages: everything is escaped, and a name that is missing is an error."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    made = Environment(
        loader=PackageLoader("hmdwarp.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    made.filters["pieces"] = name_pieces
    return made


def _tiles(summary: Summary, baseline: Summary | None, names: list[str]) -> list[Tile]:
    figures = [(f.label, f, "quality", "mean", _SHORT_NOTE[f.name]) for f in QUALITY_FIGURES if f.name in _SHORT_NOTE]
    figures.append(("Time per eye", TIME_FIGURES[-1], "time_ms", "median", "all stages, median per eye"))
    tiles = []
    for label, figure, table, main, note in figures:
        other = None if baseline is None else f"{names[1]}: {figure.text(baseline[table][figure.name][main])}"
        tiles.append(Tile(label, figure.unit, figure.text(summary[table][figure.name][main]), note, other))
    return tiles


def _charts(summary: Summary, names: list[str], rows: Rows, baseline_rows: Rows | None) -> list[Chart]:
    charts = []
    for heading, column, unit, scale, from_zero in _CHARTS:
        series = [Series.of(names[0], rows, column, scale)]
        if baseline_rows is not None:
            series.append(Series.of(names[-1], baseline_rows, column, scale))
        charts.append(Chart(heading, time_series(series, unit, from_zero=from_zero)))
    for heading, column, unit, scale, from_zero in _MOTION_CHARTS:
        charts.append(Chart(heading, time_series([Series.of("", rows, column, scale)], unit, from_zero=from_zero)))
    if "auto" in summary:
        charts.append(Chart("Time per eye", time_series([Series.of("", rows, "total_ms")], "ms", from_zero=True)))
    return charts


def _auto(summary: Summary) -> dict[str, Any] | None:
    """What warp "auto" chose from, and its changes, as text; None for a run of one warp."""
    if "auto" not in summary:
        return None
    auto = summary["auto"]
    ladder = [
        (r["name"], f"{r['total_ms']:.2f}", f"{r['flip']:.4f}", f"{r['refreshes'] / summary['frames']:.1%}")
        for r in auto["ladder"]
    ]
    changes = [(f"{c['time_s']:.2f} s", c["from"], c["to"], c["reason"]) for c in auto["changes"]]
    return {"budget": f"{auto['budget_ms']:g}", "ladder": ladder, "changes": changes}


def _worst(frame: WorstFrame) -> dict[str, Any]:
    figures = [(f.label, f.text(frame.values.get(f.name)), f.unit) for f in QUALITY_FIGURES]
    panels = [
        {
            "label": label,
            "source": "data:image/jpeg;base64," + base64.b64encode(jpeg_bytes(picture)).decode("ascii"),
            "width": picture.shape[1],
            "height": picture.shape[0],
        }
        for label, picture in frame.panels
    ]
    return {"time": f"{frame.time_s:.2f} s", "eye": EYES[frame.eye], "figures": figures, "panels": panels}


def _measured(summary: Summary) -> str | None:
    """How many pictures were measured, if the summary says so."""
    count = summary.get("measured", {}).get("flip")
    return None if count is None else f"{count} of {2 * summary['frames']}"
