"""Export of a study: one long table, questionnaires, a BIDS data set with the motion of the heads.

Participants are random words, and no dates leave the machine.
"""

from .columns import COLUMNS, FLAG, LONG_COLUMNS, MISSING, NUMBER, WHOLE, Column, columns_for
from .formats import csv_text, field_text, tsv_text
from .motion import CHANNELS, Rates, motion_text
from .rows import answer_rows, long_rows, of_origin, plan_of, revision_rows, score_rows, settings_row
from .write import Exported, ExportOptions, export, no_sessions

__all__ = [
    "CHANNELS",
    "COLUMNS",
    "FLAG",
    "LONG_COLUMNS",
    "MISSING",
    "NUMBER",
    "WHOLE",
    "Column",
    "ExportOptions",
    "Exported",
    "Rates",
    "answer_rows",
    "columns_for",
    "csv_text",
    "export",
    "field_text",
    "long_rows",
    "motion_text",
    "no_sessions",
    "of_origin",
    "plan_of",
    "revision_rows",
    "score_rows",
    "settings_row",
    "tsv_text",
]
