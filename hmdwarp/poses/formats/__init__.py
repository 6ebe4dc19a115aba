"""Trace formats: one file each, recognised by what a file holds."""

from __future__ import annotations

from ...registry import Registry
from ._base import TraceFormat, ordered

formats: Registry[TraceFormat] = Registry("trace format", __name__)

__all__ = ["TraceFormat", "formats", "ordered"]
