"""Writes the head's poses to a trace file while they come."""

from __future__ import annotations

from pathlib import Path

from ..display import Display
from ..poses import PoseSample


class Recorder:
    """A native trace, flushed every second. Use as a context manager."""

    def __init__(self, path: Path) -> None:
        self.path = path

    def begin(self, display: Display) -> None:
        """Write the header."""

    def add(self, head: PoseSample) -> None:
        """One pose more."""

    def flush(self) -> None:
        """Put on the disk what has come so far."""

    def __enter__(self) -> Recorder:
        return self

    def __exit__(self, *_: object) -> None:
        pass
