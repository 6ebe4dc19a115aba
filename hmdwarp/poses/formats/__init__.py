"""Trace formats: one file each, found by looking at what a file holds."""

from __future__ import annotations

from ...registry import Registry

formats: Registry = Registry("trace format", __name__)
