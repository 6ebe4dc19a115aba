"""Defects of a trace file and their repair: nothing is dropped or changed silently."""

from __future__ import annotations

import attrs


@attrs.frozen
class Defect:
    """One kind of defect in a file."""

    kind: str  # a stable word for programs
    what: str  # for people
    done: str  # what was done about it
    count: int = 1
    line: int | None = None  # the first place in the file, from 1

    def __str__(self) -> str:
        place = "" if self.line is None else f" (line {self.line}{' first' if self.count > 1 else ''})"
        return f"{self.what}{place}: {self.done}"
