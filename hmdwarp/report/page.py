from __future__ import annotations
import attrs
@attrs.frozen(eq=False)
class WorstFrame:
    time_s: float
    eye: int
    panels: tuple
    values: dict
