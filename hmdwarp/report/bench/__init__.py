"""The page, tables and charts of a bench."""

from .bars import Traffic, region_parts, regions_chart, row_name, traffic, traffic_chart
from .cases import COLUMNS, Case, Column, cases, column, common, measure_label
from .charts import pareto_chart, pareto_plot_png, pareto_text
from .displacement import AXES, axes_of, curves, displacement_chart, displacement_text
from .labels import boxes_touch, groups_of, leaders, place_labels, segments_hit, spread
from .page import render_bench_page
from .tables import DECISION, bench_table, choice_terms, markdown_table

__all__ = [
    "AXES",
    "COLUMNS",
    "DECISION",
    "Case",
    "Column",
    "Traffic",
    "axes_of",
    "bench_table",
    "boxes_touch",
    "cases",
    "choice_terms",
    "column",
    "common",
    "curves",
    "displacement_chart",
    "displacement_text",
    "groups_of",
    "leaders",
    "markdown_table",
    "measure_label",
    "pareto_chart",
    "pareto_plot_png",
    "pareto_text",
    "place_labels",
    "region_parts",
    "regions_chart",
    "render_bench_page",
    "row_name",
    "segments_hit",
    "spread",
    "traffic",
    "traffic_chart",
]
