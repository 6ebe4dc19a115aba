"""Exports of motion capture: a table of several bodies under a header of several lines."""

from __future__ import annotations

from pathlib import Path

from ..made import Made
from . import bids, motive, qualisys

_KINDS = (motive, qualisys, bids)


def export_reader(path: Path, start: bytes):
    """Return the module that reads such a file, None for any other. start: its first bytes."""
    return next((module for module in _KINDS if module.fits(path, start)), None)


__all__ = ["Made", "export_reader"]
