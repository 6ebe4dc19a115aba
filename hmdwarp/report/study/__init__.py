"""The page, tables and charts of a study, and the chart of a power simulation."""

from .page import render_study_report
from .power import PowerLine, power_chart
from .tables import comparison_lines, condition_lines, csv_tables, pairs_text

__all__ = [
    "PowerLine",
    "comparison_lines",
    "condition_lines",
    "csv_tables",
    "pairs_text",
    "power_chart",
    "render_study_report",
]
