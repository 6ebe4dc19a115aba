"""The results of a run: summary.json, frames.csv, pictures, a video, an HTML page, a table.

The pages of a bench and of a study are in report.bench and report.study.
"""

from .charts import Series, binned, time_series
from .files import (
    OutputFolder,
    atomic,
    write_bytes,
    write_csv,
    write_error,
    write_image_result,
    write_json,
    write_png,
    write_stream,
    write_text,
)
from .live_lines import budget_rows, live_lines
from .live_page import render_live_report
from .page import WorstFrame, render_report
from .pictures import comparison_panels, jpeg_bytes, labelled_strip, magma, png_bytes
from .schema import FRAME_COLUMNS, POSE_PARTS, SCHEMA, SUMMARY_KEYS, summary_faults, validate_summary
from .style import DASHES, PAGE, PAPER, css_variables, dashes_of, markers_of, warp_of
from .tables import comparison_rows, summary_table
from .transit import coding_rows, filled_rows, frame_rows, response_rows, transit_lines
from .video import VideoWriter, available_encoders
from .words import ALPHA, counted, interval, listed, p_is, p_text, pair_text, plain, signed

__all__ = [
    "ALPHA",
    "DASHES",
    "FRAME_COLUMNS",
    "PAGE",
    "PAPER",
    "POSE_PARTS",
    "SCHEMA",
    "SUMMARY_KEYS",
    "OutputFolder",
    "Series",
    "VideoWriter",
    "WorstFrame",
    "atomic",
    "available_encoders",
    "binned",
    "budget_rows",
    "coding_rows",
    "comparison_panels",
    "comparison_rows",
    "counted",
    "css_variables",
    "dashes_of",
    "filled_rows",
    "frame_rows",
    "interval",
    "jpeg_bytes",
    "labelled_strip",
    "listed",
    "live_lines",
    "magma",
    "markers_of",
    "p_is",
    "p_text",
    "pair_text",
    "plain",
    "png_bytes",
    "render_live_report",
    "render_report",
    "response_rows",
    "signed",
    "summary_faults",
    "summary_table",
    "time_series",
    "transit_lines",
    "validate_summary",
    "warp_of",
    "write_bytes",
    "write_csv",
    "write_error",
    "write_image_result",
    "write_json",
    "write_png",
    "write_stream",
    "write_text",
]
