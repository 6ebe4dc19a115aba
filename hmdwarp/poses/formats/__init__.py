"""Trace formats: one file each, recognised by what a file holds."""

from __future__ import annotations

from ...registry import Registry
from ._base import TraceFormat, column_of, column_of_devices, ordered, parse_euler

formats: Registry[TraceFormat] = Registry("trace format", __name__)

__all__ = ["TraceFormat", "column_of", "column_of_devices", "formats", "ordered", "parse_euler"]
