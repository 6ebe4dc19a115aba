from .page import render_study_report as render_study_report
from .power import PowerLine as PowerLine
from .power import power_chart as power_chart
from .tables import comparison_lines as comparison_lines
from .tables import condition_lines as condition_lines
from .tables import csv_tables as csv_tables
from .tables import pairs_text as pairs_text
