"""Exports of motion capture: a table of several bodies under a header of several lines."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..made import Made
from . import bids_motion, motive_csv, qualisys_tsv

_KINDS = (motive_csv, qualisys_tsv, bids_motion)


def export_reader(path: Path, start: bytes) -> Callable[[Path, str], Made] | None:
    """Return what reads such an export, None for any other file. start: its first bytes."""
    return next((module.made for module in _KINDS if module.fits(path, start)), None)


__all__ = ["Made", "export_reader"]
