"""The page, tables and charts of a study."""

from .page import best_first as best_first
from .page import csv_tables as csv_tables
from .page import render_study_report as render_study_report
from .page import study_lines as study_lines
from .page import study_page as study_page
