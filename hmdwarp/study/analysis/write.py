"""An analysis as files: report.html, analysis.json, tables/*.csv."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ...report import OutputFolder
from ...report.study import csv_tables, render_study_report

REPORT, DATA = "report.html", "analysis.json"


def write_analysis(folder: str | os.PathLike, data: Mapping[str, Any], command: str) -> Path:
    """Write the folder, whole or not at all, and say where the page is. Errors: InputError or MachineError for a place that cannot be
    written."""
    page = render_study_report(data, command)
    with OutputFolder(folder, owned=("tables/*.csv",), last=DATA) as out:
        for name, (columns, rows) in csv_tables(data).items():
            out.write_csv(f"tables/{name}", rows, columns)
        out.write_text(REPORT, page)
        out.write_json(DATA, data)
    return Path(folder) / REPORT
