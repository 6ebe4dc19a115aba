"""report.html of a replay: one page with its pictures and charts, without network access."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from typing import Any

import attrs

from ..metrics import PRIMARY, Kept, metrics_in_order
from .charts import Series, time_series
from .frame_ways import timeline_svg
from .miss_parts import miss_chart, miss_tile
from .parts import CLOCK_NAMES, Chart, Tile, environment
from .pictures import Panel, comparison_panels, jpeg_bytes
from .source_texts import eyes_text, source_facts
from .tables import QUALITY_FIGURES, TIME_FIGURES, Summary, column_names, comparison_rows, how_sure
from .transit import coding_rows, filled_rows, frame_rows, model_rows, response_rows
from .words import listed

Rows = Sequence[Mapping[str, Any]]

EYES = ("left eye", "right eye")
# (heading, column, unit)
_MOTION_CHARTS = (
    ("Age of the shown frame", "age_ms", "ms"),
    ("Angular speed of the head", "angular_speed_deg_s", "deg/s"),
    ("Linear speed of the head", "linear_speed_m_s", "m/s"),
)


@attrs.frozen(eq=False)
class WorstFrame:
    """One picture of the strip of worst frames."""

    time_s: float
    eye: int  # 0 left, 1 right
    panels: tuple[Panel, ...]  # labelled, as comparison_panels makes them
    values: Mapping[str, float | None]  # by metric

    @classmethod
    def of(cls, time_s: float, eye: int, kept: Kept) -> WorstFrame:
        """Make one of a picture that QualityPool kept."""
        assert kept.result.error_map is not None
        pictures = kept.job.now
        panels = comparison_panels(kept.job.rendered_picture, pictures.shown, pictures.truth, kept.result.error_map)
        return cls(time_s, eye, tuple(panels), kept.result.values)


def render_report(
    summary: Summary,
    baselines: Sequence[Summary] = (),
    *,
    rows: Rows,
    baselines_rows: Sequence[Rows] = (),
    misses: Sequence[Rows] = (),
    worst: Sequence[WorstFrame] = (),
    command: str,
    notes: Sequence[str] = (),
) -> str:
    """Return the text of report.html; the same arguments give the same text.

    summary, baselines: as summary.json. rows, baselines_rows: as frames.csv's, None for absent
    values. misses: as misses.csv's, of the run and each baseline, empty without `miss` in the
    summary; none if no one misses any. command: as the user typed it. notes: the run's, one
    sentence each.
    """
    names = column_names(summary, *baselines)
    comparison = comparison_rows(summary, *baselines)
    template = environment().get_template("report.html")
    return template.render(
        summary=summary,
        source=source_facts(summary),
        eyes=eyes_text(summary),
        command=command,
        notes=list(notes),
        columns=names,
        baselines=baselines,
        sure=how_sure(summary, mark="★" if baselines else None),
        quality_rows=comparison[: len(QUALITY_FIGURES)],
        time_rows=comparison[len(QUALITY_FIGURES) :][: len(TIME_FIGURES)],
        miss_rows=comparison[len(QUALITY_FIGURES + TIME_FIGURES) :],
        tiles=_tiles(summary, baselines, names),
        charts=_charts(summary, names, rows, baselines_rows) + _of_misses(summary, names, misses),
        worst=[_worst(frame, _eye_names(summary)) for frame in worst],
        measured=_measured(summary),
        auto=_auto(summary),
        filled=filled_rows(summary),
        models=model_rows(summary),
        response=response_rows(summary),
        frames=frame_rows(summary),
        coding=coding_rows(summary),
        timeline=timeline_svg((summary.get("link") or {}).get("timeline") or ()),
        clock=CLOCK_NAMES[summary["clock"]],
        metrics=metrics_in_order(),
        rising=listed([metric.label for metric in metrics_in_order() if metric.higher_is_better]),
    )


def _tiles(summary: Summary, baselines: Sequence[Summary], names: list[str]) -> list[Tile]:
    figures = [(m.label, m.figure, "quality", "mean", m.tile_note) for m in metrics_in_order() if m.tile_note]
    figures.append(("Time per eye", TIME_FIGURES[-1], "time_ms", "median", "all stages, median per eye"))
    tiles = []
    for label, figure, table, main, note in figures:
        other = "; ".join(
            f"{name}: {figure.text(one[table][figure.name][main])}"
            for name, one in zip(names[1:], baselines, strict=True)
        )
        tiles.append(Tile(label, figure.unit, figure.text(summary[table][figure.name][main]), note, other))
    if "miss" in summary:
        missing = [(name, one["miss"]) for name, one in zip(names[1:], baselines, strict=True) if "miss" in one]
        tiles.append(miss_tile(summary["miss"], missing))
    return tiles


def _of_misses(summary: Summary, names: list[str], misses: Sequence[Rows]) -> list[Chart]:
    return [miss_chart(summary["miss"]["budget_ms"], list(zip(names, misses, strict=True)))] if misses else []


def _charts(summary: Summary, names: list[str], rows: Rows, baselines_rows: Sequence[Rows]) -> list[Chart]:
    """Return the charts over time: the primary metric, the others, then the head's motion."""
    charts = []
    for metric in sorted(metrics_in_order(), key=lambda m: m.name != PRIMARY):
        if not metric.chart:
            continue
        drawn = zip(names, (rows, *baselines_rows), strict=True)
        series = [Series.of(name, its_rows, metric.name, metric.scale) for name, its_rows in drawn]
        charts.append(Chart(metric.chart, time_series(series, metric.chart_unit, from_zero=metric.chart_from_zero)))
    others = [*_MOTION_CHARTS, *([("Time per eye", "total_ms", "ms")] if "auto" in summary else [])]
    return charts + [Chart(heading, time_series([Series.of("", rows, name)], unit)) for heading, name, unit in others]


def _auto(summary: Summary) -> dict[str, Any] | None:
    """Return the levels and changes of warp "auto" as text; None for a run of one warp."""
    if "auto" not in summary:
        return None
    auto = summary["auto"]
    ladder = [
        (
            level["name"],
            f"{level['total_ms']:.2f}",
            f"{level['flip']:.4f}",
            f"{level['refreshes'] / summary['frames']:.1%}",
        )
        for level in auto["ladder"]
    ]
    changes = [(f"{c['time_s']:.2f} s", c["from"], c["to"], c["reason"]) for c in auto["changes"]]
    return {"budget": f"{auto['budget_ms']:g}", "ladder": ladder, "changes": changes}


def _eye_names(summary: Summary) -> tuple[str, ...]:
    return EYES if summary.get("eyes", 2) == 2 else ("camera",)


def _worst(frame: WorstFrame, names: tuple[str, ...]) -> dict[str, Any]:
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
    return {"time": f"{frame.time_s:.2f} s", "eye": names[frame.eye], "figures": figures, "panels": panels}


def _measured(summary: Summary) -> str | None:
    """Return how many pictures were measured, if the summary says so."""
    count = summary.get("measured", {}).get(PRIMARY)
    return None if count is None else f"{count} of {summary.get('eyes', 2) * summary['frames']}"
