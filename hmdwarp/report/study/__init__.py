"""The page, tables and charts of a study."""

from .page import render_study_report as render_study_report
from .page import study_page as study_page
from .results import comparison_lines as comparison_lines
from .results import condition_lines as condition_lines
from .results import csv_tables as csv_tables
from .results import pairs_text as pairs_text
from .results import preference_lines as preference_lines
from .results import score_lines as score_lines
