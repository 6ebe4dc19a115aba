"""What leaves the machine: one long table, questionnaires, a BIDS tree with the heads' motion; random words instead of people, no dates."""

from .columns import COLUMNS, LONG_COLUMNS, MISSING, Column, columns_for
from .rows import answer_rows, long_rows, of_origin, questionnaire_rows, revision_rows, score_rows
from .write import Exported, ExportOptions, export

__all__ = [
    "COLUMNS",
    "LONG_COLUMNS",
    "MISSING",
    "Column",
    "ExportOptions",
    "Exported",
    "answer_rows",
    "columns_for",
    "export",
    "long_rows",
    "of_origin",
    "questionnaire_rows",
    "revision_rows",
    "score_rows",
]
