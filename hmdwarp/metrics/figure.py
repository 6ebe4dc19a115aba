"""Formatting of numbers for display."""

from __future__ import annotations

import attrs


@attrs.frozen
class Figure:
    """The label, unit and rounding of one number."""

    name: str  # its key in a summary
    label: str
    unit: str
    digits: int
    scale: float = 1.0  # turns the stored number into `unit`

    def text(self, value: float | None) -> str:
        """Return the rounded number, or a dash where nothing was measured."""
        return "–" if value is None else f"{value * self.scale:.{self.digits}f}"
