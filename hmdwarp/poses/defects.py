"""Defects of a trace file and their repair: nothing is dropped or changed silently."""

from __future__ import annotations

import attrs


@attrs.frozen
class Defect:
    """One kind of defect in a file."""

    kind: str  # a stable identifier for programs
    what: str  # a description for people
    done: str  # the repair
    count: int = 1
    line: int | None = None  # the first line concerned, from 1

    def __str__(self) -> str:
        place = "" if self.line is None else f" (line {self.line}{' first' if self.count > 1 else ''})"
        return f"{self.what}{place}: {self.done}"
