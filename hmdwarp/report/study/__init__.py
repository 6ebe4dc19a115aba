"""The page, tables and charts of a study, and the chart of a power simulation."""

from .charts import PowerLine, power_chart
from .page import render_study_report, study_page
from .results import (
    comparison_lines,
    condition_lines,
    csv_tables,
    pairs_text,
    prediction_lines,
    preference_lines,
    score_lines,
)

__all__ = [
    "PowerLine",
    "comparison_lines",
    "condition_lines",
    "csv_tables",
    "pairs_text",
    "power_chart",
    "prediction_lines",
    "preference_lines",
    "render_study_report",
    "score_lines",
    "study_page",
]
