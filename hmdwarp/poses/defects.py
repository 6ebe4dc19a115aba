"""What was wrong with a trace file and what was done about it: nothing is dropped or bent silently."""

from __future__ import annotations

import attrs


@attrs.frozen
class Defect:
    """kind: a stable word for programs. what: for people. count: how often. line: the first place in the file (from 1), if any.

    done: what was done about it.
    """

    kind: str
    what: str
    done: str
    count: int = 1
    line: int | None = None

    def __str__(self) -> str:
        place = "" if self.line is None else f" (line {self.line}{' first' if self.count > 1 else ''})"
        return f"{self.what}{place}: {self.done}"
