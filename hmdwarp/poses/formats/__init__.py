"""Trace formats: one file each, recognised by what a file holds."""

from ._base import TraceFormat, column_of, column_of_devices, formats, of_matrix, ordered

__all__ = ["TraceFormat", "column_of", "column_of_devices", "formats", "of_matrix", "ordered"]
